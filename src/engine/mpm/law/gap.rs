//! Gaps in soil that was pulled apart: soil without tension that is stretched beyond its apex opens, and bears nothing until the gap has closed.
//!
//! The part of a strain that the soil itself does not follow, the plastic volume strain of the return to the apex or to the cut-off, is the opening of the gap
//! ([`InternalVariables::gap`]). The volume of a point is that of its soil without the gap: only so do its internal forces, −V σ, and the speed of waves in it
//! stay those of soil, however far it is scattered. Dunatunga & Kamrin (2015), J. Fluid Mech. 779, 483-513, let granular matter below its critical density bear nothing in the
//! same way; Tampubolon et al. (2017), ACM Trans. Graph. 36, 105, take back the volume that the return to the apex adds. Li et al. (2023) and Zhang et al. do not say what they do.

use super::{ConstitutiveLaw, InternalVariables, Sym, tensor};

/// Mean tension over bulk modulus up to which a stress is none: rounding in single precision.
const NO_TENSION: f64 = 1e-7;

/// [`ConstitutiveLaw::update`] of soil with a gap: it opens or closes without stress, and the part of the increment after it has closed acts on the soil. Soil with
/// tension that is stretched goes on at its apex.
#[cold]
pub fn update_open<L: ConstitutiveLaw>(
    law: &L,
    stress: Sym,
    dstrain: Sym,
    internal: InternalVariables,
) -> (Sym, InternalVariables) {
    let growth = tensor::trace(&dstrain);
    if growth >= 0.0 && tensor::trace(&stress) > 3.0 * NO_TENSION * law.elastic().bulk {
        return law.update_closed(stress, dstrain, internal);
    }
    let gap = internal.gap + growth;
    if gap > 0.0 {
        return ([0.0; 6], InternalVariables { gap, ..internal });
    }
    let left = gap / growth;
    law.update_closed([0.0; 6], dstrain.map(|e| e * left), InternalVariables { gap: 0.0, ..internal })
}

#[cfg(test)]
mod tests {
    use super::super::{CamClay, Clay, Cone, DruckerPrager, Elastic, Evolution, Law, MohrCoulomb, Parameters, Shear};
    use super::*;

    fn parameters(cohesion: f64) -> Parameters {
        Parameters {
            cone: Cone::Outer,
            friction: Evolution::Constant(0.5),
            cohesion: Evolution::Constant(cohesion),
            dilation: 0.2,
            ..Parameters::of_elastic(Elastic::of_young(1e7, 0.3))
        }
    }

    fn frictional(cohesion: f64) -> [Law; 2] {
        let p = parameters(cohesion);
        [Law::DruckerPrager(DruckerPrager::from(p)), Law::MohrCoulomb(MohrCoulomb::from(p))]
    }

    fn clay() -> CamClay {
        let clay =
            Clay { virgin_slope: 0.2, swelling_slope: 0.04, virgin_volume: 2.0, preconsolidation: 1e5, shear: Shear::Poisson(0.3) };
        CamClay::from(Parameters { clay, ..parameters(0.0) })
    }

    /// Strain increments of a volume strain `e` in `n` parts of unequal size, each with a shear that is not small.
    fn steps(e: f64, n: usize) -> Vec<Sym> {
        let all: f64 = (1..=n).map(|k| k as f64).sum();
        let part = |k: usize| e * k as f64 / all;
        (1..=n).map(|k| [0.5 * part(k), 0.2 * part(k), 0.3 * part(k), 0.4 * part(k), -0.1 * part(k), 0.2 * part(k)]).collect()
    }

    /// The volume strain `e`, alike in all directions.
    fn even(e: f64) -> Sym {
        [e / 3.0, e / 3.0, e / 3.0, 0.0, 0.0, 0.0]
    }

    fn go(law: &Law, state: (Sym, InternalVariables), steps: &[Sym]) -> (Sym, InternalVariables) {
        steps.iter().fold(state, |(stress, internal), step| law.update(stress, *step, internal))
    }

    /// Sand under 100 kPa that is stretched until nothing is left, then by 5 %, then squeezed: nothing before it is as wide as when it opened, then the elastic pressure of what
    /// is left; in one step or many.
    #[test]
    fn a_gap_must_close_before_sand_bears_load() {
        for law in frictional(0.0) {
            let bulk = law.bulk_modulus();
            let start = ([-1e5, -1e5, -1e5, 0.0, 0.0, 0.0], InternalVariables::default());
            let release = 1e5 / bulk;
            for n in [1, 7, 100] {
                let parts = |e: f64| vec![even(e / n as f64); n];
                let (stress, internal) = go(&law, start, &parts(release + 0.05));
                assert!(stress.iter().all(|s| s.abs() < 1e-4), "{stress:?}");
                assert!((internal.gap - 0.05).abs() < 1e-12, "{}", internal.gap);
                // shear and volume of any kind in a gap
                let (stress, internal) = go(&law, (stress, internal), &steps(-0.03, n));
                assert_eq!(stress, [0.0; 6]);
                assert!((internal.gap - 0.02).abs() < 1e-12, "{}", internal.gap);
                let (stress, closed) = go(&law, (stress, internal), &parts(-0.02 - 1e-3));
                assert!(closed.gap == 0.0 && stress.iter().take(3).all(|s| (s / (-1e-3 * bulk) - 1.0).abs() < 1e-9), "{stress:?}");
                assert_eq!(closed.plastic, internal.plastic);
            }
        }
    }

    /// Soil with cohesion keeps its tension at the apex while it is stretched; once it is squeezed it bears nothing until the gap has closed.
    #[test]
    fn bonds_hold_while_stretched_and_are_gone_when_the_gap_closes() {
        for law in frictional(2e4) {
            let apex = 2e4 / 0.5_f64.tan();
            let stretched = vec![even(0.001); 50];
            let (stress, internal) = go(&law, ([0.0; 6], InternalVariables::default()), &stretched);
            assert!((tensor::trace(&stress) / (3.0 * apex) - 1.0).abs() < 1e-9, "{stress:?}");
            assert!((internal.gap - (0.05 - apex / law.bulk_modulus())).abs() < 1e-9, "{}", internal.gap);
            let (stress, left) = law.update(stress, steps(-0.01, 1)[0], internal);
            assert!(stress == [0.0; 6] && (internal.gap - left.gap - 0.01).abs() < 1e-12);
            let (stress, closed) = law.update(stress, even(-left.gap - 3e-4), left);
            assert!(closed.gap == 0.0 && (tensor::trace(&stress) / (-9e-4 * law.bulk_modulus()) - 1.0).abs() < 1e-6, "{stress:?}");
        }
    }

    /// Clay opens at its smallest pressure, and has that when the gap has closed.
    #[test]
    fn clay_opens_at_its_smallest_pressure() {
        let own = clay();
        let law = Law::CamClay(own.clone());
        let start = ([-5e4, -5e4, -5e4, 0.0, 0.0, 0.0], InternalVariables::default());
        let v = own.specific_volume(&start.0, start.1);
        let release = own.clay().swelling_slope * (5e4_f64 / own.floor()).ln() / v;
        let (stress, internal) = law.update(start.0, even(release + 0.1), start.1);
        assert!((internal.gap - 0.1).abs() < 1e-12 && (-stress[0] / own.floor() - 1.0).abs() < 1e-12, "{internal:?} {stress:?}");
        let (stress, internal) = law.update(stress, even(-0.06), internal);
        assert!(stress == [0.0; 6] && (internal.gap - 0.04).abs() < 1e-12);
        let (stress, internal) = law.update(stress, even(-0.04 - 0.5 * release), internal);
        let there = own.floor() * (0.5 * release * own.specific_volume(&[0.0; 6], internal) / own.clay().swelling_slope).exp();
        assert!(internal.gap == 0.0 && (-stress[0] / there - 1.0).abs() < 1e-9, "{stress:?} {there}");
    }
}
