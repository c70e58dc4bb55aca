//! Grains that are pressed until they break.

use crate::change::{AREA, Change, ENERGY, FORCE, LENGTH, MASS, MOMENTUM, NONE, STRESS, VELOCITY, Within, same};
use crate::grains::{Ball, Scene, materials};
use comminute::boundary::{Drive, WallShape, WallSpec};
use comminute::breakage::criterion::HertzArea;
use comminute::breakage::lost_mass::{Fines, excluded_grains};
use comminute::breakage::pattern::{Azimuth, Pattern};
use comminute::breakage::strength::{Distribution, StrengthModel, Truncation};
use comminute::breakage::{Birth, Criterion, CrushModel};
use comminute::dem::event::{Breakage, arm_grain};
use comminute::math::random::lineage_root;
use comminute::{ContactLaw, Physics, State, Workspace, step};
use std::convert::Infallible;

/// Two pairs of grains of different sizes, each pair one upon the other, between two platens that approach each other along z, with a fifth grain beside.
fn pressed(law: ContactLaw, criterion: Criterion, birth: Birth, keeps_mass: bool) -> Scene {
    let mut physics = Physics::of(materials(law, 1e9), law);
    let strength = StrengthModel {
        // above the stress of the first contact and below that of the last step, for each kind of stress
        sigma_lim0: match criterion.word() {
            "fixed_angle" => 3e6,
            "hertz_area" => 4e7,
            _ => 0.6e6,
        },
        d0: 2e-3,
        m: 5.0,
        distribution: Distribution::Normal,
        var: 0.3,
        truncation: Truncation::Redraw,
        min_ratio: 0.2,
    };
    let pattern = Pattern::new(14).expect("a pattern");
    let azimuth = Azimuth::Random;
    let crush = CrushModel {
        criterion,
        strength,
        seed: 11,
        pattern,
        cells: Vec::new(),
        azimuth,
        d_limit: 0.9e-3,
        birth,
        keeps_mass,
        interval: 1,
    };
    physics.crush = Some(crush);
    let still = Ball { at: [0.0; 3], radius: 1e-3, velocity: [0.0; 3], spin: [0.0; 3], material: 0 };
    let balls = vec![
        Ball { at: [-2e-3, 0.0, 1.1e-3], radius: 1.1e-3, ..still },
        Ball { at: [-1.95e-3, 0.05e-3, 3.1e-3], radius: 0.9e-3, material: 1, ..still },
        Ball { at: [2e-3, 0.4e-3, 1e-3], ..still },
        Ball { at: [2.1e-3, 0.35e-3, 3e-3], ..still },
        Ball { at: [0.05e-3, 0.3e-3, 0.85e-3], radius: 0.85e-3, velocity: [0.05, 0.01, 0.0], ..still },
    ];
    let platen = |at: f64, side: f64, speed: f64| WallSpec {
        shape: WallShape::Plane { point: [0.0, 0.0, at], normal: [0.0, 0.0, side] },
        friction: 0.3,
        drive: Drive::Velocity(speed),
        material: None,
    };
    Scene { physics, balls, walls: vec![platen(0.0, 1.0, 0.1), platen(4e-3, -1.0, 0.2)] }
}

/// As [`Scene::changed`], the constants of breakage included.
fn changed(scene: &Scene, change: &Change) -> Scene {
    let mut scene = scene.changed(change);
    if let Some(crush) = &mut scene.physics.crush {
        crush.strength.sigma_lim0 = change.scalar(crush.strength.sigma_lim0, STRESS);
        crush.strength.d0 = change.scalar(crush.strength.d0, LENGTH);
        crush.d_limit = change.scalar(crush.d_limit, LENGTH);
    }
    scene
}

/// When pressing ends.
#[derive(Clone, Copy)]
enum Until {
    /// With the first breakage.
    Broken,
    /// After so many steps.
    Steps(u64),
}

/// Presses for a while. A grain draws its strength as the one that the scene names in its place, whatever the order.
fn press(scene: &Scene, order: &[usize], until: Until) -> (State, Vec<Breakage>) {
    let crush = scene.physics.crush.as_ref().expect("grains that break");
    let mut state = scene.start(order);
    state.crushing = true;
    for (i, &k) in order.iter().enumerate() {
        state.grains.lineage[i] = lineage_root(k as u32);
        arm_grain(crush, &mut state, i);
    }
    let mut work = Workspace::new(&scene.physics, &mut state);
    let mut events = Vec::new();
    while match until {
        Until::Broken => state.crush_events == 0,
        Until::Steps(steps) => state.step < steps,
    } {
        let Ok(()) = step(&scene.physics, &mut state, &mut work, |_, _| Ok::<(), Infallible>(()));
        events.extend_from_slice(&work.breakages);
        assert!(state.step < 20_000, "nothing breaks");
    }
    (state, events)
}

const ORDER: [usize; 5] = [0, 1, 2, 3, 4];

const OVERLAPPING: Birth = Birth::Overlapping;
const GRADUAL: Birth = Birth::Gradual { release: 50, growth: 80 };

fn criteria() -> Vec<Criterion> {
    Criterion::WORDS.iter().map(|word| Criterion::named(word, &[0.35, 0.0, 0.0, 0.0]).expect("a criterion")).collect()
}

/// Masses of a mother's daughters, from the largest to the smallest.
fn daughters(state: &State) -> Vec<[f64; 1]> {
    let g = &state.grains;
    let mut masses: Vec<[f64; 1]> = (0..g.len()).filter(|&i| g.generation[i] > 0).map(|i| [g.mass[i]]).collect();
    masses.sort_by(|a, b| b[0].total_cmp(&a[0]));
    masses
}

/// Checks the first breakage of a changed scene: the same grain breaks in the same step at the changed force, loses the changed mass, and leaves
/// daughters of the changed masses. How they are turned about the axis is drawn at random in a frame of its own, which is not changed.
#[track_caller]
fn check(what: &str, found: &(State, Vec<Breakage>), expected: &(State, Vec<Breakage>), change: &Change, within: Within) {
    let (a, b) = (&found.1[0], &expected.1[0]);
    assert_eq!((a.lineage, a.step, a.generation, a.age), (b.lineage, b.step, b.generation, b.age), "{what}");
    let numbers = |name: &str, pairs: &[(f64, f64, [i32; 3])]| {
        for (found, expected, unit) in pairs {
            same(&format!("{what}: {name}"), &[[*found]], &[[change.scalar(*expected, *unit)]], within);
        }
    };
    numbers("force", &[(a.force, b.force, FORCE), (a.limit_force, b.limit_force, FORCE)]);
    numbers("strength", &[(a.strength, b.strength, STRESS), (a.before, b.before, NONE)]);
    numbers("size", &[(a.diameter, b.diameter, LENGTH), (a.smallest, b.smallest, LENGTH), (a.lost_mass, b.lost_mass, MASS)]);
    numbers("stored energy", &[(a.stored_before, b.stored_before, ENERGY)]);
    same(&format!("{what}: place"), &[a.position], &[change.vector(b.position, LENGTH)], within);
    let axis = change.vector(b.axis, NONE);
    let sign = comminute::math::vector::dot(a.axis, axis).signum();
    same(&format!("{what}: axis"), &[a.axis], &[axis.map(|x| sign * x)], within);
    let masses: Vec<[f64; 1]> = daughters(&expected.0).iter().map(|m| [change.scalar(m[0], MASS)]).collect();
    assert_eq!(masses.len(), 14, "{what}");
    same(&format!("{what}: daughters"), &daughters(&found.0), &masses, within);
    assert_eq!(found.0.lost.len(), expected.0.lost.len(), "{what}");
}

/// Rounding of the two hundred steps before the breakage; the force grows by a hundredth in each of them.
const ROUNDING: Within = Within::Share(1e-9);

/// Mirrors, across the platens and along them: the same grain breaks, to the bit.
#[test]
fn a_mirrored_grain_breaks_at_the_same_load() {
    for criterion in criteria() {
        let scene = pressed(ContactLaw::Hertz, criterion, OVERLAPPING, false);
        let here = press(&scene, &ORDER, Until::Broken);
        for axis in 0..3 {
            let mirror = Change::mirror(axis);
            let there = press(&changed(&scene, &mirror), &ORDER, Until::Broken);
            check(&format!("{} {axis}", criterion.word()), &there, &here, &mirror, MIRROR);
        }
    }
}

/// Principal values of a mean stress and the momentum of daughters are sums in another order.
const MIRROR: Within = Within::Share(1e-14);

/// Turns by any angle.
#[test]
fn a_turned_grain_breaks_at_the_same_load() {
    for criterion in criteria() {
        for (birth, keeps_mass) in [(OVERLAPPING, false), (GRADUAL, true)] {
            let scene = pressed(ContactLaw::Linear, criterion, birth, keeps_mass);
            let here = press(&scene, &ORDER, Until::Broken);
            for turn in [Change::quarter(0), Change::quarter(2), Change::turned([0.6, -0.3, 0.5, 0.2])] {
                let there = press(&changed(&scene, &turn), &ORDER, Until::Broken);
                check(criterion.word(), &there, &here, &turn, ROUNDING);
            }
        }
    }
}

/// Enters the grains in another order.
#[test]
fn the_order_of_grains_does_not_choose_the_one_that_breaks() {
    for criterion in criteria() {
        let scene = pressed(ContactLaw::HertzViscous, criterion, OVERLAPPING, false);
        let here = press(&scene, &ORDER, Until::Broken);
        let there = press(&scene, &[3, 1, 4, 0, 2], Until::Broken);
        check(criterion.word(), &there, &here, &Change::NOTHING, ROUNDING);
    }
}

/// A fixed azimuth goes with the force alone: neither the seed of the draws nor the order of the grains turns the daughters, which a random one does.
#[test]
fn a_fixed_azimuth_goes_with_the_force_alone() {
    let places = |azimuth: Azimuth, seed: u64, order: &[usize]| {
        let criterion = Criterion::named("fixed_angle", &[0.35, 0.0, 0.0, 0.0]).expect("a criterion");
        let mut scene = pressed(ContactLaw::Hertz, criterion, OVERLAPPING, false);
        let crush = scene.physics.crush.as_mut().expect("grains that break");
        (crush.azimuth, crush.seed, crush.strength.var) = (azimuth, seed, 0.0);
        let (state, events) = press(&scene, order, Until::Broken);
        let g = &state.grains;
        let mut places: Vec<(u64, [f64; 3])> = (0..g.len())
            .filter(|&i| g.generation[i] > 0)
            .map(|i| (g.lineage[i], [g.pos[i][0], g.pos[i][1], g.pos[i][2]]))
            .collect();
        places.sort_by_key(|p| p.0);
        (places.into_iter().map(|p| p.1).collect::<Vec<_>>(), events[0].axis)
    };
    let (fixed, axis) = places(Azimuth::Fixed, 11, &ORDER);
    assert!(axis[0].abs() > 0.01 && axis[1].abs() > 0.01, "{axis:?}");
    assert_eq!(places(Azimuth::Fixed, 12, &ORDER).0, fixed);
    same("order", &places(Azimuth::Fixed, 11, &[3, 1, 4, 0, 2]).0, &fixed, ROUNDING);
    let random = [11, 12].map(|seed| places(Azimuth::Random, seed, &ORDER).0);
    assert!(random[0] != random[1] && random[0] != fixed);
}

/// A grain that is judged by its own radius breaks at a force that one of its contacts has then. The same scene with grains that do not break tells it.
#[test]
fn a_grain_breaks_by_its_own_radius_at_the_force_of_a_contact() {
    let own = Criterion::HertzArea(HertzArea { own_radius: true });
    let scene = |criterion: Criterion, strength: f64| {
        let mut scene = pressed(ContactLaw::Hertz, criterion, OVERLAPPING, false);
        scene.physics.crush.as_mut().expect("grains that break").strength.sigma_lim0 *= strength;
        scene
    };
    let (_, events) = press(&scene(own, 1.0), &ORDER, Until::Broken);
    let event = &events[0];
    assert!((1.0..1.05).contains(&event.utilisation()), "{event:?}");
    // forces of the step of the breakage are there when the next one begins
    let (whole, none) = press(&scene(own, 100.0), &ORDER, Until::Steps(event.step + 1));
    assert!(none.is_empty());
    let k = whole.grains.id.iter().position(|id| *id == event.mother).expect("the grain");
    let mut forces = Vec::new();
    for (pairs, walls) in [(&whole.pairs, false), (&whole.wall_pairs, true)] {
        for (ends, touch) in pairs.ends.iter().zip(&*pairs.touch) {
            if ends[0] as usize == k || (!walls && ends[1] as usize == k) {
                forces.push(touch.normal_force);
            }
        }
    }
    let largest = forces.iter().copied().fold(0.0, f64::max);
    assert!((event.force / largest - 1.0).abs() < 1e-9, "{} N, contacts {forces:?}", event.force);
}

/// Changes units: every contact law breaks the same grains in the same steps, through daughters that break as well, and leaves the same numbers to the bit.
/// Only the area of a Hertzian contact, which has a cube root, is rounded.
#[test]
fn other_units_change_the_units_of_breakages() {
    let units = Change::UNITS;
    let mut by_generation = [0; 2];
    for (k, criterion) in criteria().into_iter().enumerate() {
        for (j, &law) in ContactLaw::ALL.iter().enumerate() {
            let birth = if (k + j) % 2 == 0 { OVERLAPPING } else { GRADUAL };
            let scene = pressed(law, criterion, birth, (k + j) % 3 == 0);
            let what = format!("{} {}", criterion.word(), law.word());
            let (here, events) = press(&scene, &ORDER, Until::Steps(2500));
            let (there, changed_events) = press(&changed(&scene, &units), &ORDER, Until::Steps(2500));
            assert!(!events.is_empty(), "{what}");
            events.iter().for_each(|e| by_generation[usize::from(e.generation.min(1))] += 1);
            let key = |e: &Breakage| (e.event, e.step, e.mother, e.generation, e.lineage, e.age, e.before, e.axis);
            assert_eq!(changed_events.iter().map(key).collect::<Vec<_>>(), events.iter().map(key).collect::<Vec<_>>(), "{what}");
            for (a, b) in changed_events.iter().zip(&events) {
                // twenty contacts with the decisive force and overlaps as large as the grain would not hold that much
                assert!(b.stored_before < 20.0 * b.force * b.diameter, "{what}: {b:?}");
                for (name, found, expected, unit) in [
                    ("force", a.force, b.force, FORCE),
                    ("limit", a.limit_force, b.limit_force, FORCE),
                    ("strength", a.strength, b.strength, STRESS),
                    ("diameter", a.diameter, b.diameter, LENGTH),
                    ("smallest", a.smallest, b.smallest, LENGTH),
                    ("lost mass", a.lost_mass, b.lost_mass, MASS),
                    ("lost energy", a.lost_kinetic, b.lost_kinetic, ENERGY),
                    ("stored before", a.stored_before, b.stored_before, ENERGY),
                    ("stored after", a.stored_after, b.stored_after, ENERGY),
                ] {
                    assert_eq!(found, units.scalar(expected, unit), "{what}: {name}");
                }
                assert_eq!(a.lost_momentum, units.vector(b.lost_momentum, MOMENTUM), "{what}");
                same(&what, &[[a.area]], &[[units.scalar(b.area, AREA)]], Within::Share(1e-14));
            }
            let of = |v: &[[f64; 4]], unit: [i32; 3]| v.iter().map(|v| units.vector([v[0], v[1], v[2]], unit)).collect::<Vec<_>>();
            let lead = |v: &[[f64; 4]]| v.iter().map(|v| [v[0], v[1], v[2]]).collect::<Vec<_>>();
            same(&what, &lead(&there.grains.pos), &of(&here.grains.pos, LENGTH), Within::Nothing);
            same(&what, &lead(&there.grains.vel), &of(&here.grains.vel, VELOCITY), Within::Nothing);
            let lost = here.lost.iter().map(|l| [units.scalar(l.0, MASS), units.scalar(l.1, LENGTH)]).collect::<Vec<_>>();
            assert_eq!(there.lost.iter().map(|l| [l.0, l.1]).collect::<Vec<_>>(), lost, "{what}");
        }
    }
    assert!(by_generation[1] > 10, "daughters break as well: {by_generation:?}");
}

/// Measures the sizes of lost mass in other units: shares do not change, and neither do numbers of excluded grains.
#[test]
fn lost_mass_has_no_unit_of_its_own() {
    for alpha in [1.2, 2.6, 3.0] {
        let fines = Fines { alpha, d_min: 0.1e-3 };
        let scaled = Fines { alpha, d_min: Change::UNITS.scalar(0.1e-3, LENGTH) };
        for d in [0.05e-3, 0.12e-3, 0.3e-3, 0.9e-3, 2e-3] {
            let at = |d: f64| Change::UNITS.scalar(d, LENGTH);
            assert_eq!(scaled.finer(at(d), at(1e-3)), fines.finer(d, 1e-3));
            assert_eq!(scaled.mean_log_above(at(d), at(1e-3)), fines.mean_log_above(d, 1e-3));
        }
    }
    // as many breakages twice are twice as many grains
    let pattern = Pattern::new(14).expect("a pattern");
    let (one, eight) = (excluded_grains(1, &pattern), excluded_grains(8, &pattern));
    assert_eq!((8.0 * one.paper, 8.0 * one.smallest), (eight.paper, eight.smallest));
}
