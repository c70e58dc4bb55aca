//! Stress increments of the laws in f32, for tests. Twin of `law.wgsl`; what the functions compute is said in `mpm::law`, which has the same names.
//!
//! All results are increments: of the stress, the plastic strain and the gap. They are added up in compensated sums. A new stress computed as a whole would have the
//! rounding error of its size in each step, which is larger than the increment of a small step.

use super::cam_clay::cam_clay;
use super::layout::{Evolution32, Law32};
use super::mohr_coulomb::mohr_coulomb;

/// Components in the order of `mpm::law::Sym`.
pub type Sym32 = [f32; 6];

#[derive(Clone, Copy)]
struct YieldParameters {
    alpha: f32,
    kappa: f32,
}

/// Changes of I1 and J in the return, Pa, and whether it ends on the cone.
#[derive(Clone, Copy)]
struct Returned {
    di1: f32,
    dj: f32,
    on_cone: bool,
}

/// Flow on the cone, as `drucker_prager::Flow`; besides the slope of the potential, and its change per change of the slope of the cone, both 0 where the dilation angle
/// stays.
struct Flow {
    volume_return: f32,
    per_multiplier: f32,
    alpha: f32,
    per_alpha: f32,
}

const NONE: Returned = Returned { di1: 0.0, dj: 0.0, on_cone: false };

/// Increments of stress, Pa, of plastic strain, and of the gap by what the soil does not follow.
pub struct Step {
    pub stress: Sym32,
    pub plastic: f32,
    pub gap: f32,
}

/// The increments for the strain increment `strain` of soil without a gap, or with one that its tension opens further; `before`, Pa: stress, already rotated with the
/// material.
pub fn stress_step(law: &Law32, before: Sym32, strain: Sym32, plastic: f32) -> Step {
    if law.kind == 3 {
        return cam_clay(law, &before, &strain, plastic);
    }
    let two_g = 2.0 * law.shear;
    let lame = law.bulk - two_g * 0.333_333_33;
    let volume = lame * (strain[0] + strain[1] + strain[2]);
    let elastic: Sym32 = std::array::from_fn(|k| two_g * strain[k] + if k < 3 { volume } else { 0.0 });
    if law.kind == 0 {
        return Step { stress: elastic, plastic: 0.0, gap: 0.0 };
    }
    let trial: Sym32 = std::array::from_fn(|k| before[k] + elastic[k]);
    let i1 = trial[0] + trial[1] + trial[2];
    let d = [trial[0] - trial[1], trial[1] - trial[2], trial[2] - trial[0]];
    let across = trial[3] * trial[3] + trial[4] * trial[4] + trial[5] * trial[5];
    let j = ((d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) * 0.166_666_67 + across).sqrt();
    // the deviator from differences of normal stresses, so that a large pressure does not spoil its digits
    let deviator = [(d[0] - d[2]) * 0.333_333_33, (d[1] - d[0]) * 0.333_333_33, (d[2] - d[1]) * 0.333_333_33];
    if law.kind == 2 {
        if inside(law, YieldParameters { alpha: law.last_alpha, kappa: law.last_kappa }, i1, j) {
            return Step { stress: elastic, plastic: 0.0, gap: 0.0 };
        }
        let [a, b, c] = deviator;
        return mohr_coulomb(law, elastic, &[a, b, c, trial[3], trial[4], trial[5]], i1 * 0.333_333_33, plastic);
    }
    let (strength, slope) = surface(law, plastic);
    if inside(law, strength, i1, j) {
        return Step { stress: elastic, plastic: 0.0, gap: 0.0 };
    }
    let (end, plastic) = if plastic >= law.settled {
        let end = returned(law, strength, i1, j);
        (end, increment_of(law, end))
    } else {
        hardened(law, i1, j, plastic, (strength, slope))
    };
    let share = if j > 0.0 { end.dj / j } else { 0.0 };
    let mean = end.di1 * 0.333_333_33;
    let stress = std::array::from_fn(|k| elastic[k] + if k < 3 { deviator[k] * share + mean } else { trial[k] * share });
    let gap = if end.on_cone { 0.0 } else { -end.di1 / (3.0 * law.bulk) };
    Step { stress, plastic, gap }
}

/// Sine of an angle in −π/2..π/2 by its Taylor series: the sine of the device may have errors up to 2⁻¹¹.
pub fn sine(angle: f32) -> f32 {
    let q = angle * angle;
    let sum = ((((1.605_904_4e-10 * q - 2.505_210_8e-8) * q + 2.755_731_9e-6) * q - 1.984_127e-4) * q + 8.333_333e-3) * q
        - 1.666_666_7e-1;
    angle + angle * (q * sum)
}

/// exp(x) for |x| ≤ 80, as a power of 2 and a rest: power (1 + rest).
pub fn exponential(x: f32) -> [f32; 2] {
    // halvings
    let n = (0.5 - x * std::f32::consts::LOG2_E).floor();
    let r = (x + n * 0.693_145_75) + n * 1.428_606_8e-6;
    let sum = (((((1.984_127e-4 * r + 1.388_888_9e-3) * r + 8.333_333e-3) * r + 4.166_666_7e-2) * r + 1.666_666_7e-1) * r + 0.5)
        * r
        + 1.0;
    [f32::from_bits(((127 - n as i32) as u32) << 23), r * sum]
}

/// exp(−x) for x ≥ 0.
fn decay_of(x: f32) -> f32 {
    if x > 80.0 {
        return 0.0;
    }
    let [power, rest] = exponential(-x);
    (1.0 + rest) * power
}

/// The value and its derivative.
pub fn evolution_at(e: &Evolution32, x: f32) -> (f32, f32) {
    match e.kind {
        0 => (e.last, 0.0),
        1 if x < e.strain => {
            let slope = (e.last - e.initial) / e.strain;
            (e.initial + slope * x, slope)
        }
        1 => (e.last, 0.0),
        _ => {
            let [a, b, c, d] = e.cubic;
            if x <= 0.0 {
                (e.initial, c)
            } else if x <= e.peak_strain {
                (((a * x + b) * x + c) * x + d, (3.0 * a * x + 2.0 * b) * x + c)
            } else {
                let left = (e.peak - e.residual) * decay_of(e.decay * (x - e.peak_strain));
                (e.residual + left, -e.decay * left)
            }
        }
    }
}

/// The yield surface at a plastic strain, and its derivative.
fn surface(law: &Law32, plastic: f32) -> (YieldParameters, YieldParameters) {
    if plastic >= law.settled {
        return (YieldParameters { alpha: law.last_alpha, kappa: law.last_kappa }, YieldParameters { alpha: 0.0, kappa: 0.0 });
    }
    let (angle, dangle) = evolution_at(&law.friction, plastic);
    let (cohesion, dcohesion) = evolution_at(&law.cohesion, plastic);
    let s = sine(angle);
    let c = (1.0 - s * s).max(0.0).sqrt();
    let (alpha, k, dalpha, dk) = if law.cone == 2 {
        let below = 1.0 / (9.0 + 3.0 * s * s).sqrt();
        let cube = below * below * below;
        (s * below, 3.0 * c * below, 9.0 * c * cube, -3.0 * s * below - 9.0 * s * c * c * cube)
    } else {
        let sign = if law.cone == 0 { -1.0 } else { 1.0 };
        let root = 1.154_700_5;
        let below = 1.0 / (3.0 + sign * s);
        let dk = 3.0 * root * (-s * below - sign * (c * c) * (below * below));
        (root * s * below, 3.0 * root * c * below, 3.0 * root * c * (below * below), dk)
    };
    (
        YieldParameters { alpha, kappa: k * cohesion },
        YieldParameters { alpha: dalpha * dangle, kappa: dk * dangle * cohesion + k * dcohesion },
    )
}

fn cut_of(law: &Law32, s: YieldParameters) -> f32 {
    if s.alpha > 0.0 { law.cut.min(s.kappa / s.alpha) } else { law.cut }
}

fn corner(s: YieldParameters, cut: f32) -> f32 {
    if s.alpha > 0.0 { (s.kappa - s.alpha * cut).max(0.0) } else { s.kappa }
}

fn inside(law: &Law32, s: YieldParameters, i1: f32, j: f32) -> bool {
    j + s.alpha * i1 <= s.kappa && i1 <= cut_of(law, s)
}

/// Slope of the potential of dilation that ends, as `Dilatancy::at`.
pub fn potential_slope(law: &Law32, alpha: f32) -> f32 {
    law.dilation_factor * (alpha - law.critical).max(0.0)
}

fn flow_at(law: &Law32, alpha: f32) -> Flow {
    if law.dilation_factor > 0.0 {
        let slope = potential_slope(law, alpha);
        let per_alpha = if alpha > law.critical { law.dilation_factor } else { 0.0 };
        let per_multiplier = (0.333_333_33 + 2.0 * (slope * slope)).sqrt();
        return Flow { volume_return: 9.0 * law.bulk * slope, per_multiplier, alpha: slope, per_alpha };
    }
    Flow { volume_return: law.volume_return, per_multiplier: law.per_multiplier, alpha: 0.0, per_alpha: 0.0 }
}

fn returned(law: &Law32, s: YieldParameters, i1: f32, j: f32) -> Returned {
    let cut = cut_of(law, s);
    let excess = j + s.alpha * i1 - s.kappa;
    if i1 <= cut {
        if excess <= 0.0 {
            return NONE;
        }
    } else if j <= corner(s, cut) {
        return Returned { di1: cut - i1, ..NONE };
    }
    let volume_return = flow_at(law, s.alpha).volume_return;
    let multiplier = excess / (law.shear + volume_return * s.alpha);
    let di1 = -volume_return * multiplier;
    if i1 + di1 > cut {
        return Returned { di1: cut - i1, dj: corner(s, cut) - j, on_cone: false };
    }
    Returned { di1, dj: (-law.shear * multiplier).max(-j), on_cone: true }
}

fn increment_of(law: &Law32, end: Returned) -> f32 {
    let shear = end.dj / law.shear;
    let volume = end.di1 / (3.0 * law.bulk);
    ((shear * shear) * 0.333_333_33 + (volume * volume) * 0.222_222_22).sqrt()
}

fn largest_increment(law: &Law32, i1: f32, j: f32) -> f32 {
    let multiplier = j / law.shear;
    let volume = (law.volume_return * multiplier).max(i1) / (3.0 * law.bulk);
    ((multiplier * multiplier) * 0.333_333_33 + (volume * volume) * 0.222_222_22).sqrt() * 1.00001 + 1e-30
}

fn at_jump(law: &Law32, i1: f32, j: f32, increment: f32, s: YieldParameters) -> Returned {
    let Flow { volume_return, per_multiplier, .. } = flow_at(law, s.alpha);
    let multiplier = increment / per_multiplier;
    let end = Returned { di1: -volume_return * multiplier, dj: -law.shear * multiplier, on_cone: true };
    if j + end.dj >= 0.0 && inside(law, s, i1 + end.di1, j + end.dj) { end } else { returned(law, s, i1, j) }
}

/// As `DruckerPrager::hardened`; the unknown is the increment of the plastic strain.
fn hardened(law: &Law32, i1: f32, j: f32, before: f32, first: (YieldParameters, YieldParameters)) -> (Returned, f32) {
    // error of the plastic strain from the rounding of the stress
    let noise = 2e-7 * (j + i1.abs()) / law.shear;
    let (mut low, mut high, mut at) = (0.0, largest_increment(law, i1, j), 0.0);
    let mut now = first;
    for round in 0..40 {
        let (strength, slope) = now;
        let end = returned(law, strength, i1, j);
        let increment = increment_of(law, end);
        let rest = at - increment;
        if rest.abs() <= 1e-6 * increment + noise {
            return (end, increment);
        }
        if rest < 0.0 {
            low = at;
        } else {
            high = at;
        }
        let tangent = if end.on_cone {
            let Flow { volume_return, per_multiplier, alpha, per_alpha } = flow_at(law, strength.alpha);
            let stiffness = law.shear + volume_return * strength.alpha;
            let change = per_alpha * slope.alpha;
            let multiplier = increment / per_multiplier;
            let stiffer = 9.0 * law.bulk * strength.alpha * per_multiplier / stiffness;
            1.0 - per_multiplier * ((i1 + end.di1) * slope.alpha - slope.kappa) / stiffness
                + multiplier * change * (stiffer - 2.0 * alpha / per_multiplier)
        } else {
            1.0
        };
        let next = at - rest / tangent;
        at = if round < 10 && next > low && next < high { next } else { low + 0.5 * (high - low) };
        if at <= low || at >= high {
            break;
        }
        now = surface(law, before + at);
    }
    (at_jump(law, i1, j, high, surface(law, before + high).0), high)
}
