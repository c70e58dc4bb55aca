//! Modified Cam-clay in f32, for tests. Twin of `cam_clay.wgsl`; the method is that of `mpm::law::cam_clay`, with what f32 asks for: the change of pressure from that of
//! its logarithm, and what the return takes from the deviator from the flow, where the surface gives it as a small difference. So rounding neither adds up in the
//! volume, which ties the pressure to the preconsolidation pressure, nor in the flow; how far a stress is from the ellipse is rounding and does not add up.

use super::law::{Step, Sym32, exponential};
use super::layout::Law32;
use std::f32::consts::LN_2;

/// Smallest mean pressure over the preconsolidation pressure at the start, and its logarithm.
const LEAST: f32 = 1e-3;
const LN_LEAST: f32 = -6.907_755_3;
/// Largest exponent.
const MOST: f32 = 40.0;

/// A state before the return.
struct Trial {
    /// ln(2 p/p_c), with the preconsolidation pressure p_c of before.
    critical: f32,
    /// As `CamClay::stretch`.
    stretch: f32,
    /// q/(M p_c).
    ratio: f32,
    /// M² v with the specific volume of the end.
    elastic: f32,
    /// 6 G (λ − κ)/p_c.
    plastic: f32,
}

/// What a return does: growth of ln p_c, and by which share of the trial's deviator the deviator changes.
struct Returned {
    growth: f32,
    less: f32,
}

/// exp(x) − 1, without loss of digits near 0.
pub fn less_one(x: f32) -> f32 {
    let [power, rest] = exponential(x);
    power * rest + (power - 1.0)
}

/// ln x for x > 0.
pub fn logarithm(x: f32) -> f32 {
    let bits = x.to_bits();
    let mut exponent = (bits >> 23) as i32 - 127;
    let mut part = f32::from_bits((bits & 0x007f_ffff) | 0x3f80_0000);
    if part > std::f32::consts::SQRT_2 {
        part *= 0.5;
        exponent += 1;
    }
    let f = (part - 1.0) / (part + 1.0);
    let q = f * f;
    let sum = (((0.111_111_11 * q + 0.142_857_14) * q + 0.2) * q + 0.333_333_33) * q;
    let n = exponent as f32;
    n * 0.693_145_75 + (n * 1.428_606_8e-6 + 2.0 * (f + f * sum))
}

/// Specific volume at a pressure, whose logarithm over the preconsolidation pressure at the start is `height`.
fn volume(law: &Law32, height: f32, plastic: f32) -> f32 {
    let c = &law.clay;
    (c.virgin_volume * (1.0 - plastic) - c.swelling_slope * height).max(1.0)
}

/// Shear modulus, Pa, at a mean pressure, Pa, and a specific volume.
fn shear_modulus(law: &Law32, p: f32, v: f32) -> f32 {
    if law.clay.shear_ratio > 0.0 { law.clay.shear_ratio * (v * p / law.clay.swelling_slope) } else { law.shear }
}

/// As `CamClay::returned`; `found` there is the last state here.
fn returned(trial: &Trial) -> Returned {
    let Trial { critical, stretch, .. } = *trial;
    let (mut inside, mut outside) = (0.0, critical.min(LN_2));
    let mut z = outside;
    // E and 1 + E, which is small at low pressures
    let (mut e, mut over) = (0.0_f32, 1.0);
    let (mut x, mut larger, mut gone) = (0.0_f32, 1.0, 1.0);
    for _ in 0..40 {
        x = (critical - z) * stretch;
        let [power, rest] = exponential(z);
        (e, over) = (power * rest + (power - 1.0), power * rest + power);
        larger = less_one(x.clamp(-MOST, MOST)) + 1.0;
        gone = 1.0;
        if z == 0.0 {
            break;
        }
        let flow = trial.elastic * e;
        let g = trial.plastic / larger;
        let sum = flow + g * x;
        let share = flow / sum;
        gone = g * x / sum;
        let ratio = trial.ratio / larger;
        let rest = (share * ratio) * (share * ratio) - 0.25 * (over * (1.0 - e));
        if rest.abs() <= 5e-8 * over {
            break;
        }
        if rest > 0.0 {
            outside = z;
        } else {
            inside = z;
        }
        let share_slope = trial.elastic * (over * g * x - e * g * (x - 1.0) * stretch) / (sum * sum);
        let slope = 2.0 * share * (ratio * ratio) * (share_slope + share * stretch) + 0.5 * e * over;
        let next = z - rest / slope;
        z = if (next - inside) * (next - outside) < 0.0 { next } else { inside + 0.5 * (outside - inside) };
        if z == inside || z == outside {
            break;
        }
    }
    // close to the critical state the flow is a quotient of small numbers; elsewhere the errors of the surface, though small, would add up along it
    if e <= 0.8 && gone >= e.abs() && trial.ratio > 0.0 {
        gone = 1.0 - 0.5 * larger * (over * (1.0 - e)).max(0.0).sqrt() / trial.ratio;
    }
    Returned { growth: x, less: -gone }
}

/// The increments of stress, plastic compression and gap; `before`: stress, Pa, already rotated with the material.
pub fn cam_clay(law: &Law32, before: &Sym32, strain: &Sym32, plastic: f32) -> Step {
    let c = &law.clay;
    let mean = (before[0] + before[1] + before[2]) * -0.333_333_33;
    let p = mean.max(LEAST * c.preconsolidation);
    let height = logarithm(p / c.preconsolidation);
    let v = volume(law, height, plastic);
    let trace = strain[0] + strain[1] + strain[2];
    // the elastic change of ln p, from that of the specific volume, which is not below 1
    let asked = ((-v * trace).min(v - 1.0) / c.swelling_slope).clamp(-MOST, MOST);
    let least = LN_LEAST - height;
    // what is pulled further apart opens
    let mut opens = asked < least;
    let mut rise = if opens { least } else { asked };
    let mut followed = if opens { -least * c.swelling_slope / v } else { trace };
    let shear = shear_modulus(law, p, v);
    let elastic = deviator(strain).map(|e| 2.0 * shear * e);
    let own = deviator(before);
    let deviator: Sym32 = std::array::from_fn(|k| own[k] + elastic[k]);
    let [a, b, d, x, y, z] = deviator;
    let q2 = 1.5 * ((a * a + b * b + d * d) + 2.0 * (x * x + y * y + z * z));
    let hardening = plastic * c.per_plastic;
    let p_c = c.preconsolidation * (less_one(hardening.clamp(-MOST, MOST)) + 1.0);
    let mut end = Returned { growth: 0.0, less: 0.0 };
    let ratio = q2.sqrt() / (c.slope * p_c);
    let high = (p + p * less_one(rise)) / p_c;
    if ratio * ratio > high * (1.0 - high) {
        let trial = |rise: f32, followed: f32, stretch: f32| Trial {
            critical: (height - hardening + LN_2) + rise,
            stretch,
            ratio,
            elastic: c.slope * c.slope * (v + v * followed).max(1.0),
            plastic: 6.0 * shear * c.swelling_slope * c.ratio / p_c,
        };
        let stretch = 1.0 / (1.0 + c.ratio);
        end = returned(&trial(rise, followed, if opens { 1.0 } else { stretch }));
        if opens {
            followed -= c.swelling_slope * c.ratio * end.growth / v;
            if followed >= trace {
                (opens, rise, followed) = (false, asked, trace);
                end = returned(&trial(rise, followed, stretch));
            }
        }
    }
    let lifted = if opens { least } else { (rise - c.ratio * end.growth).max(least) };
    let pressure = p * less_one(lifted) + (p - mean);
    let stress = std::array::from_fn(|k| elastic[k] + (deviator[k] * end.less - if k < 3 { pressure } else { 0.0 }));
    Step { stress, plastic: end.growth / c.per_plastic, gap: trace - followed }
}

/// The deviator, from differences of normal components, so that a large mean does not spoil its digits.
fn deviator(a: &Sym32) -> Sym32 {
    let d = [a[0] - a[1], a[1] - a[2], a[2] - a[0]];
    [(d[0] - d[2]) * 0.333_333_33, (d[1] - d[0]) * 0.333_333_33, (d[2] - d[1]) * 0.333_333_33, a[3], a[4], a[5]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Within some units in the last place of f64, the difference from 1 relative to itself.
    #[test]
    fn exponential_and_logarithm_are_those_of_f64() {
        for k in 0..20_000 {
            let x = 10_f32.powf(-6.0 + 7.9 * k as f32 / 20_000.0);
            for x in [x, -x] {
                let exact = f64::from(x).exp_m1();
                let far = f64::from(x.abs()).max(1.0);
                assert!((f64::from(less_one(x)) / exact - 1.0).abs() < 3e-7 * far, "{x}: {} {exact}", less_one(x));
            }
            let exact = f64::from(x).ln();
            assert!((f64::from(logarithm(x)) - exact).abs() < 1.5e-7 * (exact.abs() + 1e-3), "{x}: {} {exact}", logarithm(x));
        }
        let near = [0.999_f32, 0.999_999_9, 1.0, 1.000_000_1, 1.001];
        assert!(near.iter().all(|&x| (f64::from(logarithm(x)) - f64::from(x).ln()).abs() <= 2e-7 * f64::from(x).ln().abs()));
    }
}
