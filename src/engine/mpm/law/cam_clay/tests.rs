//! Modified Cam-clay against its closed forms at a point.

use super::super::Evolution;
use super::*;
use proptest::prelude::*;

const M: f64 = 1.2;
const LAMBDA: f64 = 0.16;
const KAPPA: f64 = 0.03;
const P_C: f64 = 100e3;
const V_C: f64 = 2.1;

/// M 1.2 in triaxial compression.
fn clay(shear: Shear) -> CamClay {
    let sine: f64 = 3.0 * M / (6.0 + M);
    CamClay::of(&Parameters {
        friction: Evolution::Constant(sine.asin()),
        clay: Clay { virgin_slope: LAMBDA, swelling_slope: KAPPA, preconsolidation: P_C, virgin_volume: V_C, shear },
        ..Parameters::of_elastic(Elastic { bulk: 0.0, shear: 0.0 })
    })
}

fn kinds() -> [CamClay; 2] {
    [clay(Shear::Poisson(0.25)), clay(Shear::Modulus(4e6))]
}

/// A point at rest under an isotropic pressure p, Pa.
#[derive(Clone, Copy)]
struct Point {
    stress: Sym,
    internal: InternalVariables,
}

impl Point {
    fn at(p: f64) -> Point {
        Point { stress: [-p, -p, -p, 0.0, 0.0, 0.0], internal: InternalVariables::default() }
    }

    fn after(self, law: &CamClay, dstrain: Sym) -> Point {
        let (stress, internal) = law.update(self.stress, dstrain, self.internal);
        Point { stress, internal }
    }

    fn p(&self) -> f64 {
        -tensor::trace(&self.stress) / 3.0
    }

    fn q(&self) -> f64 {
        (3.0 * tensor::j2(&self.stress)).sqrt()
    }

    fn v(&self, law: &CamClay) -> f64 {
        law.specific_volume(&self.stress, self.internal)
    }

    fn p_c(&self, law: &CamClay) -> f64 {
        law.preconsolidation(self.internal.plastic)
    }

    /// A step of drained triaxial compression by the axial strain `da` (negative) at the cell pressure at which the point is.
    fn drained(self, law: &CamClay, da: f64, cell: f64) -> Point {
        let trial = |lateral: f64| self.after(law, [lateral, lateral, da, 0.0, 0.0, 0.0]);
        let (mut low, mut high) = (2.0 * da, -2.0 * da);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if trial(middle).stress[0] < -cell { low = middle } else { high = middle }
        }
        trial(0.5 * (low + high))
    }
}

/// f/(M p_c)², 0 on the ellipse.
fn outside(law: &CamClay, point: &Point) -> f64 {
    let (p, q, p_c) = (point.p(), point.q(), point.p_c(law));
    (q * q / (M * M) + p * (p - p_c)) / (p_c * p_c)
}

/// Slope κ below the preconsolidation pressure and on the way back, λ above, in (ln p, v), whatever the step; v is what the strains make of it.
#[test]
fn isotropic_compression_follows_its_lines() {
    for law in kinds() {
        for step in [1e-5, 1e-3, 0.02] {
            let mut point = Point::at(20e3);
            let mut v = V_C + KAPPA * 5f64.ln();
            assert!((point.v(&law) - v).abs() < 1e-14);
            let mut strain = |point: &mut Point, by: f64| {
                *point = point.after(&law, [by, by, by, 0.0, 0.0, 0.0]);
                v *= 1.0 + 3.0 * by;
                assert!((point.v(&law) - v).abs() < 1e-12, "{step}: {} {v}", point.v(&law));
                v
            };
            while point.p() < 1e6 {
                let now = strain(&mut point, -step / 3.0);
                let p = point.p();
                let line = if p < P_C { V_C - KAPPA * (p / P_C).ln() } else { V_C - LAMBDA * (p / P_C).ln() };
                assert!((now - line).abs() < 1e-11, "{step}: {now} for {line} at {p}");
                assert!(p < P_C || (point.p_c(&law) / p - 1.0).abs() < 1e-11);
            }
            let (p_c, turn) = (point.p(), point.v(&law));
            while point.p() > 50e3 {
                let now = strain(&mut point, step / 3.0);
                assert!((now - turn + KAPPA * (point.p() / p_c).ln()).abs() < 1e-11);
            }
            assert!((point.p_c(&law) / p_c - 1.0).abs() < 1e-14);
        }
    }
}

/// At constant volume p ends at p₀ (R/2)^Λ with Λ = 1 − κ/λ, on the critical state line; on the way, where the soil yields, p/p₀ = (R M²/(M² + η²))^Λ.
#[test]
fn undrained_paths_are_the_closed_form() {
    let big_lambda = 1.0 - KAPPA / LAMBDA;
    for law in kinds() {
        for ratio in [1.0, 1.5, 2.0, 4.0, 10.0] {
            for step in [1e-5, 1e-3] {
                let start = P_C / ratio;
                let mut point = Point::at(start);
                let mut yielded = 0;
                for _ in 0..(0.4 / step) as u32 {
                    let before = point.internal.plastic;
                    point = point.after(&law, [0.5 * step, 0.5 * step, -step, 0.0, 0.0, 0.0]);
                    if point.internal.plastic != before {
                        yielded += 1;
                        let eta = point.q() / point.p();
                        let path = (ratio * M * M / (M * M + eta * eta)).powf(big_lambda);
                        assert!((point.p() / start / path - 1.0).abs() < 1e-9, "{ratio} {step}: {} {path}", point.p() / start);
                        assert!(outside(&law, &point).abs() < 1e-12);
                    } else if yielded == 0 {
                        assert!((point.p() / start - 1.0).abs() < 1e-12, "elastic shear keeps p");
                    }
                }
                assert!(yielded > 100 || ratio == 2.0, "{ratio}: {yielded}");
                let end = start * (ratio / 2.0).powf(big_lambda);
                assert!((point.p() / end - 1.0).abs() < 1e-6, "{ratio} {step}: {} for {end}", point.p());
                assert!((point.q() / point.p() - M).abs() < 1e-6, "{ratio} {step}: {}", point.q() / point.p());
            }
        }
    }
}

/// Drained compression, from normally to heavily consolidated, ends at q = M p with v on the critical state line, and then neither changes. The peak of a dry specimen is where
/// its path, q = 3 (p − p₀), meets the first ellipse.
#[test]
fn drained_compression_ends_at_the_critical_state() {
    for law in kinds() {
        for ratio in [1.0, 2.0, 8.0] {
            let cell = P_C / ratio;
            let mut point = Point::at(cell);
            let mut peak: f64 = 0.0;
            for _ in 0..3000 {
                point = point.drained(&law, -5e-4, cell);
                peak = peak.max(point.q());
            }
            let p = cell / (1.0 - M / 3.0);
            assert!(
                (point.p() / p - 1.0).abs() < 1e-4 && (point.q() / (M * p) - 1.0).abs() < 2e-4,
                "{ratio}: {} {}",
                point.p() / p,
                point.q() / p
            );
            let v = V_C - LAMBDA * (2.0 * p / P_C).ln() + KAPPA * 2f64.ln();
            assert!((point.v(&law) - v).abs() < 1e-4, "{ratio}: {} for {v}", point.v(&law));
            let later = (0..100).fold(point, |point, _| point.drained(&law, -5e-4, cell));
            assert!((later.v(&law) - point.v(&law)).abs() < 1e-5 && (later.q() / point.q() - 1.0).abs() < 1e-4);
            // 9 (p − p₀)² = M² p (p_c0 − p)
            let (a, b, c) = (9.0 + M * M, -18.0 * cell - M * M * P_C, 9.0 * cell * cell);
            let first = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
            if first < 0.5 * P_C {
                assert!((peak / (3.0 * (first - cell)) - 1.0).abs() < 0.01, "{ratio}: {peak}");
            } else {
                assert!(peak <= point.q() * (1.0 + 1e-9));
            }
        }
    }
}

/// One-dimensional compression approaches the k₀ at which η (1 + ν)(1 − Λ)/(3 (1 − 2ν)) + 3 η Λ/(M² − η²) = 1, k₀ = (3 − η)/(3 + 2η), with slope λ.
#[test]
fn oedometer_paths_approach_their_k0() {
    for nu in [0.1, 0.25, 0.35] {
        let law = clay(Shear::Poisson(nu));
        let big_lambda = 1.0 - KAPPA / LAMBDA;
        let rest = |eta: f64| {
            eta * (1.0 + nu) * (1.0 - big_lambda) / (3.0 * (1.0 - 2.0 * nu)) + 3.0 * eta * big_lambda / (M * M - eta * eta) - 1.0
        };
        let (mut low, mut high) = (0.0, M);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if rest(middle) < 0.0 { low = middle } else { high = middle }
        }
        let k0 = (3.0 - low) / (3.0 + 2.0 * low);
        let mut point = Point::at(20e3);
        let mut seen = None;
        while point.p() < 5e6 {
            point = point.after(&law, [0.0, 0.0, -1e-5, 0.0, 0.0, 0.0]);
            if seen.is_none() && point.p() > 2e6 {
                seen = Some((point.p(), point.v(&law)));
            }
        }
        let found = point.stress[0] / point.stress[2];
        assert!((found - k0).abs() < 2e-4, "{nu}: {found} for {k0}");
        let (p, v) = seen.expect("on the way");
        let slope = (v - point.v(&law)) / (point.p() / p).ln();
        assert!((slope / LAMBDA - 1.0).abs() < 1e-3, "{nu}: {slope}");
    }
}

/// Halving the step halves the error against fine steps, along a path that compresses, shears and turns.
#[test]
fn steps_are_of_first_order() {
    for law in kinds() {
        let run = |n: u32| {
            let mut point = Point::at(40e3);
            for leg in
                [[-0.01, -0.01, -0.03, 0.0, 0.0, 0.0], [0.01, 0.0, -0.03, 0.02, 0.0, 0.01], [0.0, 0.01, -0.01, -0.02, 0.01, 0.0]]
            {
                let part: Sym = leg.map(|x| x / f64::from(n));
                point = (0..n).fold(point, |point, _| point.after(&law, part));
            }
            point.stress
        };
        let exact = run(40_000);
        let error = |n: u32| {
            let stress = run(n);
            let apart: Sym = std::array::from_fn(|k| stress[k] - exact[k]);
            (tensor::contract(&apart, &apart) / tensor::contract(&exact, &exact)).sqrt()
        };
        let (coarse, middle, fine) = (error(10), error(100), error(1000));
        assert!(coarse < 0.1 && middle < 0.2 * coarse && fine < 0.2 * middle, "{coarse:e} {middle:e} {fine:e}");
    }
}

/// What is pulled apart keeps a small pressure; pressed again it bears.
#[test]
fn it_bears_no_tension() {
    for law in kinds() {
        let mut point = Point::at(50e3);
        for _ in 0..500 {
            point = point.after(&law, [2e-3, 1e-3, 3e-3, 1e-3, 0.0, 0.0]);
            // in a gap it has no stress
            let apart = point.internal.gap > 0.0 && point.stress == [0.0; 6];
            assert!((apart || point.p() / law.floor() > 1.0 - 1e-12) && point.q() <= M * point.p_c(&law), "{:?}", point.stress);
        }
        assert!(point.internal.gap > 0.1 && point.p() < 2.0 * law.floor(), "{}", point.p());
        for _ in 0..4000 {
            point = point.after(&law, [-1e-3 / 3.0, -1e-3 / 3.0, -1e-3 / 3.0, 0.0, 0.0, 0.0]);
        }
        assert!(point.p() > 10.0 * law.floor());
        // a point without stress starts at the smallest pressure
        let still = law.update([0.0; 6], [0.0; 6], InternalVariables::default());
        assert!((tensor::trace(&still.0) / (-3.0 * law.floor()) - 1.0).abs() < 1e-14);
    }
}

/// Soil that is pulled apart and sheared in the same step dilates: where that takes the whole volume, it ends on the ellipse above the smallest pressure, without a gap; where it does
/// not, at that pressure, and the rest is a gap.
#[test]
fn soil_that_is_pulled_apart_dilates_before_it_opens() {
    let law = clay(Shear::Poisson(0.25));
    let start = Point::at(1e3);
    let dstrain = [0.49603790344067983, 0.5597523327158622, 0.0, 0.0, 0.0, -0.6777232886143225].map(|x| x * 10f64.powf(-1.3));
    let end = start.after(&law, dstrain);
    let asked = start.v(&law) * (1.0 + tensor::trace(&dstrain));
    assert!(outside(&law, &end).abs() < 1e-12 && end.p() > 2.0 * law.floor(), "{:?}", end.stress);
    assert!(end.p_c(&law) < P_C && end.internal.plastic < 0.0 && end.internal.gap == 0.0);
    assert!((end.v(&law) - asked).abs() < 1e-11, "{} {asked}", end.v(&law));
    // as much shear, more volume
    let dstrain = [dstrain[0] + 0.1, dstrain[1] + 0.1, dstrain[2] + 0.1, 0.0, 0.0, dstrain[5]];
    let end = start.after(&law, dstrain);
    let asked = start.v(&law) * (1.0 + tensor::trace(&dstrain));
    assert!(outside(&law, &end).abs() < 1e-12 && (end.p() / law.floor() - 1.0).abs() < 1e-12, "{:?}", end.stress);
    assert!(end.p_c(&law) < P_C && end.internal.gap > 0.0, "{:?}", end.internal);
    assert!((end.v(&law) + end.internal.gap * start.v(&law) - asked).abs() < 1e-11, "{} {asked}", end.v(&law));
    // little more than what the smallest pressure allows, along one axis: no gap, and a step without strain changes nothing
    let end = start.after(&law, [0.0, 0.0, 0.8647095337233238 * 10f64.powf(-1.3), 0.0, 0.0, 0.0]);
    let still = end.after(&law, [0.0; 6]);
    assert!(end.internal.gap == 0.0 && end.p() > law.floor() && (0..6).all(|k| (still.stress[k] - end.stress[k]).abs() < 1e-6));
}

/// The law says what it is: moduli at a stress, energy, strength at the critical state.
#[test]
fn moduli_and_strength_are_those_of_the_state() {
    for law in kinds() {
        let point = Point::at(25e3);
        let v = V_C + KAPPA * 4f64.ln();
        let at = law.stiffness(&point.stress, point.internal);
        assert!((at.bulk / (v * 25e3 / KAPPA) - 1.0).abs() < 1e-14);
        assert!((law.elastic().bulk / (V_C * P_C / KAPPA) - 1.0).abs() < 1e-14);
        // the stiffness is what a small strain finds
        let d = 1e-8;
        let after = point.after(&law, [-d, -d, -d, 0.0, 0.0, 0.0]);
        assert!(((after.p() - point.p()) / (3.0 * d * at.bulk) - 1.0).abs() < 1e-5);
        let after = point.after(&law, [0.0, 0.0, 0.0, d, 0.0, 0.0]);
        assert!((after.stress[3] / (2.0 * d * at.shear) - 1.0).abs() < 1e-9);
        // energy: its growth with compression is p dε_v
        let grown = law.elastic_energy(&after.stress, after.internal) - law.elastic_energy(&point.stress, point.internal);
        assert!(grown >= 0.0);
        let q = law.q_compression(1e5, 0.0).expect("a strength");
        assert!((q / (1e5 + q / 3.0) - M).abs() < 1e-12);
        let q = law.q_extension(1e5, 0.0).expect("a strength");
        assert!((q / (1e5 - q / 3.0) - M).abs() < 1e-12);
        assert!((law.yield_line(0.0).expect("a line").q_at(1e5) - M * 1e5).abs() < 1e-6);
        assert_eq!(law.critical_slope().to_bits(), law.slope.to_bits());
    }
    let ratio = clay(Shear::Poisson(0.25)).stiffness(&Point::at(3e4).stress, InternalVariables::default());
    assert!((ratio.poisson() - 0.25).abs() < 1e-14);
}

proptest! {
    /// From anywhere, with any step: the end is inside or on the ellipse, volume is what the strain makes of it, plastic flow dissipates and follows the normal, and a still step
    /// changes nothing.
    #[test]
    fn returns_end_on_the_ellipse(
        p in 1e3..1e5f64, share in 0.0..1.0f64, direction in prop::array::uniform6(-1.0..1.0f64), dstrain in prop::array::uniform6(-1.0..1.0f64),
        size in -9.0..-1.3f64, plastic in -0.05..0.2f64, kind in 0..2usize,
    ) {
        let law = &kinds()[kind];
        let internal = InternalVariables { plastic, gap: 0.0 };
        let p_c = law.preconsolidation(plastic);
        let p = (p * p_c / P_C).max(law.floor());
        let s = tensor::deviator(&direction);
        let scale = share * M * (p * (p_c - p)).max(0.0).sqrt() / (3.0 * tensor::j2(&s)).sqrt().max(1e-9);
        let start = Point { stress: std::array::from_fn(|k| s[k] * scale - if k < 3 { p } else { 0.0 }), internal };
        let dstrain = dstrain.map(|x| x * 10f64.powf(size));
        let end = start.after(law, dstrain);
        prop_assert!(end.stress.iter().all(|x| x.is_finite()));
        let f = outside(law, &end);
        prop_assert!(f <= 1e-12, "{f:e} {end:?}", end = end.stress);
        let v = start.v(law) * (1.0 + tensor::trace(&dstrain));
        // what the soil does not follow is its gap, which opens at the smallest pressure alone
        let gap = end.internal.gap;
        prop_assert!((end.v(law) + gap * start.v(law) - v).abs() < 1e-11, "{} {gap} {v}", end.v(law));
        prop_assert!(gap == 0.0 || end.p() <= law.floor() * (1.0 + 1e-12), "{gap} {}", end.p());
        if end.internal.plastic != plastic && gap == 0.0 {
            prop_assert!(f.abs() < 1e-12, "{f:e}");
            // Δ from the volume; q and q of the trial state give the same
            let (p, p_c, q) = (end.p(), end.p_c(law), end.q());
            let x = law.per_plastic * (end.internal.plastic - plastic);
            let w = 2.0 * p - p_c;
            let volume = (LAMBDA - KAPPA) * x / v;
            prop_assert!(volume * w >= 0.0, "flow along the normal: {volume} {w}");
            let shear = law.stiffness(&start.stress, internal).shear;
            let (s, e) = (tensor::deviator(&start.stress), tensor::deviator(&dstrain));
            let trial: Sym = std::array::from_fn(|k| s[k] + 2.0 * shear * e[k]);
            let gone = (3.0 * tensor::j2(&trial)).sqrt() - q;
            // q_trial − q = 6 G Δ q/M², with Δ = volume/w
            let (left, right) = (gone * w, 6.0 * shear * volume * q / (M * M));
            prop_assert!((left - right).abs() <= 1e-8 * (left.abs() + right.abs()) + 1e-10 * p_c * (gone.abs() + 1e-6 * p_c), "{left} {right}");
            let work = p * volume + q * gone / (3.0 * shear);
            prop_assert!(work >= -1e-12 * p_c, "dissipation {work}");
        }
        let again = end.after(law, [0.0; 6]);
        if gap > 0.0 {
            prop_assert!(again.stress == [0.0; 6] && again.internal == end.internal);
            return Ok(());
        }
        let moved = (0..6).map(|k| (again.stress[k] - end.stress[k]).abs()).fold(0.0, f64::max);
        prop_assert!(moved <= 1e-9 * end.p_c(law), "{moved}");
    }
}
