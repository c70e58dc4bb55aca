//! Modified Cam-clay (Roscoe & Burland 1968): an elastic law with pressure-dependent stiffness up to an ellipse that grows with plastic compression and shrinks with plastic
//! dilation, f = q²/M² + p (p − p_c) ≤ 0, with associated flow. Here p and p_c are positive in compression; stresses are tension positive as in every law.
//!
//! - p = −tr(σ)/3, q = √(3 J2), p_c: preconsolidation pressure, Pa
//! - M = 6 sin φ/(3 − sin φ), -: slope of the critical state line in triaxial compression; the same in all directions, so extension fails at a larger angle
//! - v = 1 + e: specific volume; λ, κ: slopes of the virgin line and of swelling lines in (ln p, v)
//!
//! Every state lies on its swelling line, v = v_c0 − (λ − κ) ln(p_c/p_c0) − κ ln(p/p_c0), with v_c0 on the virgin line at p_c0. So p and p_c give v, and v after a step, which
//! is that before times 1 + tr(dε) as on the grid, ties p to p_c: slopes λ and κ are met to rounding whatever the step.
//!
//! K = v p/κ; G is constant, or has a constant ratio to K, then with K of the start of the step (an error of first order in the step).
//!
//! The return is implicit. With x = ln(p_c/p_c before), E = 2p/p_c − 1, v at the end of the step and the plastic multiplier Δ:
//!
//! - volume: (λ − κ) x/v = Δ p_c E, and p p_c^((λ − κ)/κ) stays
//! - shear: q = q_trial/(1 + 6 G Δ/M²)
//! - surface: q²/M² = p_c² (1 − E²)/4
//!
//! which leaves one unknown, ln(1 + E), between the critical state, E = 0, and the trial state or the tip of the ellipse, E = 1: Newton's method within these bounds
//! (unknowns as in Borja & Lee 1990, Comput. Methods Appl. Mech. Eng. 78, 49-72; de Souza Neto, Perić & Owen 2008, section 10.1, have another hardening law).
//!
//! The internal variable `plastic` is the plastic compression of volume over the volume at v_c0, (λ − κ)/v_c0 ln(p_c/p_c0): p_c follows from it. It is negative after
//! dilation.
//!
//! Dissipation is Δ p p_c, so never negative. The mean pressure stays above a thousandth of p_c0 ([`CamClay::floor`]). What is pulled further apart has that pressure, in the return
//! as well, and what remains of the volume after its plastic dilation is a gap ([`super::gap`]); where nothing remains, dilation keeps the pressure above the smallest, and there is no
//! gap. v is not below 1.

use super::{Clay, Cone, ConstitutiveLaw, Elastic, InternalVariables, Parameters, Shear, Sym, YieldParameters, tensor};
use crate::math::portable::{exp, ln, sin};
use serde::{Deserialize, Serialize};

/// Smallest mean pressure over the preconsolidation pressure at the start.
const FLOOR: f64 = 1e-3;
/// Largest ln of the change of pressure in one step: what is beyond it is no soil, and must not overflow.
const MOST: f64 = 200.0;
const LN_2: f64 = std::f64::consts::LN_2;

/// The law of Modified Cam-clay, with constants that follow from its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Parameters", into = "Parameters")]
pub struct CamClay {
    parameters: Parameters,
    clay: Clay,
    /// M, -.
    slope: f64,
    /// (λ − κ)/κ, -.
    ratio: f64,
    /// ln(p_c/p_c0) per plastic compression, v_c0/(λ − κ), -.
    per_plastic: f64,
    /// G/K; NaN where G is constant.
    shear_ratio: f64,
}

impl From<Parameters> for CamClay {
    fn from(parameters: Parameters) -> CamClay {
        let clay = parameters.clay;
        let sine = sin(parameters.friction.at(0.0).0);
        CamClay {
            parameters,
            clay,
            slope: 6.0 * sine / (3.0 - sine),
            ratio: (clay.virgin_slope - clay.swelling_slope) / clay.swelling_slope,
            per_plastic: clay.virgin_volume / (clay.virgin_slope - clay.swelling_slope),
            shear_ratio: match clay.shear {
                Shear::Poisson(nu) => 1.5 * (1.0 - 2.0 * nu) / (1.0 + nu),
                Shear::Modulus(_) => f64::NAN,
            },
        }
    }
}

impl From<CamClay> for Parameters {
    fn from(law: CamClay) -> Parameters {
        law.parameters
    }
}

impl ConstitutiveLaw for CamClay {
    const KEYS: &'static [&'static str] = &["friction_angle", "lambda", "kappa", "virgin_specific_volume", "preconsolidation"];
    const PLASTIC_FALLS: bool = true;
    const STIFFENS: bool = true;

    fn of(parameters: &Parameters) -> CamClay {
        (*parameters).into()
    }

    /// At the preconsolidation pressure of the start.
    fn elastic(&self) -> Elastic {
        self.moduli(self.clay.preconsolidation, self.clay.virgin_volume)
    }

    fn stiffness(&self, stress: &Sym, internal: InternalVariables) -> Elastic {
        let p = self.pressure(stress);
        self.moduli(p, self.volume(p, internal.plastic))
    }

    /// ∫ p dε_v along the swelling line from no pressure, κ p/v, and that of shear.
    fn elastic_energy(&self, stress: &Sym, internal: InternalVariables) -> f64 {
        let p = self.pressure(stress);
        let v = self.volume(p, internal.plastic);
        self.clay.swelling_slope * p / v + tensor::j2(stress) / (2.0 * self.moduli(p, v).shear)
    }

    #[inline]
    fn update_closed(&self, stress: Sym, dstrain: Sym, mut internal: InternalVariables) -> (Sym, InternalVariables) {
        let kappa = self.clay.swelling_slope;
        let before = self.pressure(&stress);
        let v = self.volume(before, internal.plastic);
        let asked = (v * (1.0 + tensor::trace(&dstrain))).max(1.0);
        let free = before * exp(((v - asked) / kappa).clamp(-MOST, MOST));
        let opens = free < self.floor();
        let (p, v_end) = if opens { (self.floor(), v + kappa * ln(before / self.floor())) } else { (free, asked) };
        let shear = self.moduli(before, v).shear;
        let (s, e) = (tensor::deviator(&stress), tensor::deviator(&dstrain));
        let deviator: Sym = std::array::from_fn(|k| s[k] + 2.0 * shear * e[k]);
        let q2 = 3.0 * tensor::j2(&deviator);
        let p_c = self.preconsolidation(internal.plastic);
        if q2 <= self.slope * self.slope * (p * (p_c - p)) {
            internal.gap += (asked - v_end) / v;
            return (with_pressure(&deviator, 1.0, p), internal);
        }
        let trial = Trial { p, p_c, q: q2.sqrt(), shear, v: v_end };
        let mut end = self.returned(trial, if opens { 1.0 } else { self.stretch() });
        if opens {
            let followed = v_end - (self.clay.virgin_slope - kappa) * end.growth;
            if followed < asked {
                internal.gap += (asked - followed) / v;
            } else {
                end = self.returned(Trial { p: free, v: asked, ..trial }, self.stretch());
            }
        }
        internal.plastic += end.growth / self.per_plastic;
        let share = if trial.q > 0.0 { end.q / trial.q } else { 0.0 };
        (with_pressure(&deviator, share, end.p), internal)
    }

    fn shear_strength(&self, _: f64) -> Option<[f64; 2]> {
        Some([self.parameters.friction.at(0.0).0, 0.0])
    }

    /// The critical state line.
    fn yield_line(&self, _: f64) -> Option<YieldParameters> {
        Some(YieldParameters { alpha: Cone::Outer.at(self.parameters.friction.at(0.0).0).alpha, kappa: 0.0 })
    }

    /// At the critical state.
    fn q_compression(&self, cell: f64, _: f64) -> Option<f64> {
        Some(self.slope * cell / (1.0 - self.slope * (1.0 / 3.0)))
    }

    /// At the critical state.
    fn q_extension(&self, cell: f64, _: f64) -> Option<f64> {
        Some(self.slope * cell / (1.0 + self.slope * (1.0 / 3.0)))
    }
}

/// A state before the return: pressures, deviatoric stress and shear modulus, Pa, and the specific volume at the end of the step.
#[derive(Clone, Copy)]
struct Trial {
    p: f64,
    p_c: f64,
    q: f64,
    shear: f64,
    v: f64,
}

/// The state after the return: p and q, Pa, and ln of the growth of the preconsolidation pressure.
struct Returned {
    p: f64,
    q: f64,
    growth: f64,
}

impl CamClay {
    /// Smallest mean pressure, Pa.
    pub fn floor(&self) -> f64 {
        FLOOR * self.clay.preconsolidation
    }

    /// Slope M of the critical state line in (p, q), -.
    pub fn critical_slope(&self) -> f64 {
        self.slope
    }

    /// Compression lines and elasticity.
    pub fn clay(&self) -> &Clay {
        &self.clay
    }

    /// (λ − κ)/κ, -.
    pub fn ratio(&self) -> f64 {
        self.ratio
    }

    /// Growth of ln(p_c) per plastic compression, -.
    pub fn per_plastic(&self) -> f64 {
        self.per_plastic
    }

    /// G/K, -; `None` where G is constant.
    pub fn shear_ratio(&self) -> Option<f64> {
        (!self.shear_ratio.is_nan()).then_some(self.shear_ratio)
    }

    /// Preconsolidation pressure, Pa, at the internal variable `plastic`.
    pub fn preconsolidation(&self, plastic: f64) -> f64 {
        self.clay.preconsolidation * exp((plastic * self.per_plastic).clamp(-MOST, MOST))
    }

    /// Specific volume v = 1 + e, -, of a state.
    pub fn specific_volume(&self, stress: &Sym, internal: InternalVariables) -> f64 {
        self.volume(self.pressure(stress), internal.plastic)
    }

    /// Mean pressure, Pa, not below the smallest.
    fn pressure(&self, stress: &Sym) -> f64 {
        (tensor::trace(stress) * (-1.0 / 3.0)).max(self.floor())
    }

    /// Specific volume at a mean pressure, Pa, and an internal variable.
    fn volume(&self, p: f64, plastic: f64) -> f64 {
        let Clay { swelling_slope, preconsolidation, virgin_volume, .. } = self.clay;
        (virgin_volume * (1.0 - plastic) - swelling_slope * ln(p / preconsolidation)).max(1.0)
    }

    /// Moduli at a mean pressure, Pa, and a specific volume.
    fn moduli(&self, p: f64, v: f64) -> Elastic {
        let bulk = v * p / self.clay.swelling_slope;
        let shear = match self.clay.shear {
            Shear::Poisson(_) => self.shear_ratio * bulk,
            Shear::Modulus(shear) => shear,
        };
        Elastic { bulk, shear }
    }

    /// Growth of ln p_c in a return at constant volume over the fall of ln(p/p_c), -; in one at constant pressure that is 1.
    fn stretch(&self) -> f64 {
        1.0 / (1.0 + self.ratio)
    }

    /// Return of a trial state to the ellipse, at its volume or at its pressure ([`Self::stretch`]).
    #[inline(never)]
    fn returned(&self, trial: Trial, stretch: f64) -> Returned {
        const ROUNDS: u32 = 100;
        const CLOSE: f64 = 1e-14;
        let Trial { p, p_c, q, shear, v } = trial;
        let critical = ln(p / p_c) + LN_2;
        // the unknown z = ln(1 + E)
        let growth = |z: f64| (critical - z) * stretch;
        let outer = critical.min(LN_2);
        let (mut inside, mut outside, mut z) = (0.0, outer, outer);
        let elastic = self.slope * self.slope * v;
        let plastic = 6.0 * shear * (self.clay.virgin_slope - self.clay.swelling_slope);
        let mut share = 0.0;
        let mut found = State::at(0.0, p_c, growth(0.0));
        for _ in 0..ROUNDS {
            if z == 0.0 {
                found = State::at(0.0, p_c, growth(0.0));
                break;
            }
            let state = State::at(z, p_c, growth(z));
            let State { e, x, p_c } = state;
            let g = plastic / p_c;
            let sum = elastic * e + g * x;
            // q over that of the trial state, and the yield function over p_c²
            share = elastic * e / sum;
            let trial_ratio = q / (self.slope * p_c);
            let rest = (share * trial_ratio) * (share * trial_ratio) - 0.25 * (1.0 - e * e);
            found = state;
            if rest.abs() <= CLOSE {
                break;
            }
            if rest > 0.0 {
                outside = z
            } else {
                inside = z
            }
            let share_slope = elastic * ((1.0 + e) * g * x - e * g * (x - 1.0) * stretch) / (sum * sum);
            let slope = 2.0 * share * (trial_ratio * trial_ratio) * (share_slope + share * stretch) + 0.5 * e * (1.0 + e);
            let next = z - rest / slope;
            let useful = (next - inside) * (next - outside) < 0.0;
            let middle = inside + 0.5 * (outside - inside);
            z = if useful { next } else { middle };
            if z == inside || z == outside {
                break;
            }
        }
        let State { e, x, p_c } = found;
        // near the tip of the ellipse q is a small difference there, but not in the flow; at the critical state it is the other way round
        let q = if e > 0.8 { share * q } else { 0.5 * self.slope * p_c * (1.0 - e * e).max(0.0).sqrt() };
        Returned { p: (0.5 * p_c * (1.0 + e)).max(self.floor()), q, growth: x }
    }
}

/// A state on its way back: E = 2p/p_c − 1, x = ln of the growth of p_c, and p_c, Pa.
#[derive(Clone, Copy)]
struct State {
    e: f64,
    x: f64,
    p_c: f64,
}

impl State {
    /// At z = ln(1 + E) and the growth x, with the preconsolidation pressure `before`, Pa.
    #[inline]
    fn at(z: f64, before: f64, x: f64) -> State {
        State { e: less_one(z), x, p_c: before * exp(x.clamp(-MOST, MOST)) }
    }
}

/// exp(z) − 1, without loss of digits near 0.
#[inline]
fn less_one(z: f64) -> f64 {
    if z.abs() < 1e-3 {
        z * (1.0 + z * (0.5 + z * (1.0 / 6.0 + z * (1.0 / 24.0 + z * (1.0 / 120.0)))))
    } else {
        exp(z.clamp(-MOST, MOST)) - 1.0
    }
}

/// The stress with this share of a deviator, Pa, and this mean pressure, Pa.
#[inline]
fn with_pressure(deviator: &Sym, share: f64, p: f64) -> Sym {
    std::array::from_fn(|k| deviator[k] * share - if k < 3 { p } else { 0.0 })
}

#[cfg(test)]
mod tests;
