//! Points from breakages, against f64.

use super::adapter;
use super::faces::{Impact, RATES, steps};
use crate::coupling::Rule;
use crate::coupling::exchange::ExchangedContact;
use crate::dem::Workspace;
use crate::dem::event::Breakage;
use crate::gpu::continuum::DeviceContinuum;
use crate::mpm::LoadingPlate;

/// Points have 0.075 l of solids, grains a density of 2500 kg/m³.
const RULE: Rule = Rule { release_strain: 0.2, law: 0, porosity: 0.4, solid: 7.5e-5, density: 2500.0, at_rest: false };

/// Another one in the same state.
fn twin(of: &Impact) -> Impact {
    Impact {
        work: Workspace::new(&of.physics, &mut of.mixture.grains.clone()),
        continuum: of.continuum.clone(),
        mixture: of.mixture.clone(),
        plates: of.plates.clone(),
        ..Impact::new(Some(RULE))
    }
}

fn device(of: &Impact) -> DeviceContinuum {
    DeviceContinuum::begin(&of.continuum, &of.plates, &vec![0.0; of.plates.len()], Some(&of.coarse()), None).expect("device")
}

/// Points that a breakage has made beside a moving grain: their overlaps without force shrink as on the processor, and give as much energy. Measured: 9 of 40 contacts have
/// one, off by 2e-8 of the largest; energy off by 2e-7.
#[test]
fn overlaps_without_force_shrink_as_on_the_processor() {
    if !adapter("overlaps_without_force_shrink_as_on_the_processor") {
        return;
    }
    const STEPS: u32 = 20;
    let mut here = Impact::new(Some(RULE));
    here.mixture.lose(&[Breakage::lost([0.503, 0.497, 0.455], 0.36, 40.0, [0.0; 3])]);
    here.forces();
    here.cycles(3);
    let number = here.mixture.fines.as_ref().map_or(0, |f| f.points);
    assert!(number > 5, "{number} points");
    let mut there = twin(&here);
    let begun = |of: &Impact| of.mixture.fines.as_ref().map_or(f64::NAN, |f| f.released);
    let at_start = begun(&here);
    here.cycles(STEPS);
    let mut gpu = device(&there);
    let mut released = 0.0;
    for _ in 0..2 {
        steps(&mut gpu, u64::from(STEPS) / 2);
        released += gpu.released();
    }
    there.take(&gpu);
    let (exact, found) = (here.contacts(), there.contacts());
    assert_eq!(exact.iter().map(|c| c.ends[1]).collect::<Vec<_>>(), found.iter().map(|c| c.ends[1]).collect::<Vec<_>>());
    let held = exact.iter().filter(|c| c.reference > 0.0).count();
    let most = |of: fn(&ExchangedContact) -> f64| exact.iter().map(of).fold(0.0, f64::max);
    let off = |of: fn(&ExchangedContact) -> f64| {
        exact.iter().zip(&found).map(|(e, f)| (of(e) - of(f)).abs()).fold(0.0, f64::max) / most(of)
    };
    let (of_reference, of_force) = (off(|c| c.reference), off(|c| c.touch.normal_force));
    let of_energy = released / (begun(&here) - at_start) - 1.0;
    println!(
        "{held} of {} contacts have overlaps without force, up to {:e} m, off by {of_reference:e}; force {of_force:e}; energy {:e} J, off by {of_energy:e}",
        exact.len(),
        most(|c| c.reference),
        begun(&here) - at_start,
    );
    assert!(held > 3 && begun(&here) > at_start);
    assert!(of_reference < 1e-6 && of_force < 3e-6 && of_energy.abs() < 1e-5);
}

/// Points from a breakage that fly through a soft platen: the device stops at the step in which the processor takes them out, the same ones are taken out, and the
/// run goes on with the others.
#[test]
fn points_behind_a_platen_are_taken_out() {
    if !adapter("points_behind_a_platen_are_taken_out") {
        return;
    }
    let mut here = Impact::new(Some(RULE));
    let top = LoadingPlate::new(&here.continuum, [0.5, 0.5, 0.8], [0.0, 0.0, -1.0], 1e2);
    here.plates.push(top);
    here.mixture.lose(&[Breakage::lost([0.4, 0.5, 0.72], 0.2, 1.0, [0.0, 0.0, 60.0])]);
    here.forces();
    here.cycles(1);
    let number = |of: &Impact| of.mixture.fines.as_ref().map_or(0, |f| f.points);
    let (start, mut there) = (number(&here), twin(&here));
    let mut gpu = device(&there);
    let mut taken = 0;
    for _ in 0..12 {
        here.cycles(1);
        let before = gpu.steps_done();
        steps(&mut gpu, 1);
        assert_eq!(gpu.steps_done(), before + 1);
        there.plates.clone_from_slice(gpu.plates());
        if gpu.passed() {
            there.take(&gpu);
            let before = number(&there);
            there.mixture.remove_fines_behind(&there.plates, &mut there.continuum);
            taken += before - number(&there);
            assert!(number(&there) < before);
            gpu.reload(&there.continuum, &there.plates, &[0.0], Some(&there.coarse()), None).expect("device");
        }
        // a point that is followed by its face is behind a step earlier or later
        assert!(number(&here).abs_diff(number(&there)) <= 2, "{} and {}", number(&here), number(&there));
    }
    there.take(&gpu);
    println!("{taken} of {start} points have been taken out; on the processor {}", start - number(&here));
    assert!(taken > 0 && number(&there) > 0 && RATES.grains > 1);
    let fines = |of: &Impact| of.mixture.fines.as_ref().map_or(0.0, |f| f.reserve.mass + f.entered.mass);
    assert!((fines(&there) - 1.0).abs() < 1e-12 && number(&there) == number(&here));
}
