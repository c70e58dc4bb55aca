//! Mohr–Coulomb plasticity, tension positive, principal stresses σ1 ≥ σ2 ≥ σ3: f = (σ1 − σ3) + (σ1 + σ3) sin φ − 2 c cos φ ≤ 0. The plastic potential is f with the dilation
//! angle ψ in place of φ.
//!
//! - φ, ψ — friction and dilation angle, rad; c — cohesion, Pa. φ and c may change with the accumulated plastic strain ([`super::Evolution`]); ψ stays, or falls with φ to 0
//!   at its final value ([`super::dilatancy`], in slopes of the cone through the edges of triaxial compression)
//!
//! The return is exact. In the space of principal stresses the surface is a pyramid of planes: a trial stress returns to one of its planes, to an edge between two
//! of them or to the apex c cot φ in closed form, and its principal directions do not change (de Souza Neto, Perić & Owen 2008, Computational Methods for Plasticity,
//! section 8.2). Where the pyramid changes it is that of the end of the step: one equation in the plastic strain is solved by false position between bounds. Where the
//! strength jumps upwards there may be no solution; the plastic strain is then that of the jump, and the stress on the pyramid beyond it or, where that is larger than the
//! trial stress, the trial stress.
//!
//! Without cohesion triaxial compression and extension fail at the same ratio of the largest to the smallest stress, (1 + sin φ)/(1 − sin φ).
//!
//! Holds for 0 ≤ ψ ≤ φ (where ψ falls with φ: at the largest φ): dissipation is then not negative.

use super::dilatancy::Dilatancy;
use super::surface::{Surface, SurfaceDefinition};
use super::{Cone, ConstitutiveLaw, Elastic, Evolution, InternalVariables, Parameters, Sym, YieldParameters, tensor};
use crate::math::eigen::principal;
use crate::math::portable::sin;
use serde::{Deserialize, Serialize};

/// The law of Mohr and Coulomb, with constants that follow from its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Parameters", into = "Parameters")]
pub struct MohrCoulomb {
    parameters: Parameters,
    /// The final pyramid.
    last: Pyramid,
    /// Its change with the plastic strain, as that of the cone through its edges of triaxial compression.
    surface: Surface,
    /// How the dilation angle falls; `None` where it stays.
    dilatancy: Option<Dilatancy>,
    /// A cone inside the pyramid at every plastic strain, which touches all planes of one that stays: stresses inside it, with I1 up to `inscribed_cut`, are elastic, which
    /// saves the computation of their principal values.
    inscribed: YieldParameters,
    /// Largest I1, Pa, of such stresses.
    inscribed_cut: f64,
}

/// The pyramid and its potential at one plastic strain.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pyramid {
    /// sin φ.
    sin_friction: f64,
    /// sin ψ.
    sin_dilation: f64,
    /// 2 c cos φ, Pa.
    strength: f64,
}

/// Sine of the angle for which the cone through the edges of triaxial compression has this slope.
fn sine_of(slope: f64) -> f64 {
    let rise = ROOT_3 * slope;
    3.0 * rise / (2.0 + rise)
}

const ROOT_3: f64 = 1.732_050_807_568_877_2;

impl From<Parameters> for MohrCoulomb {
    fn from(parameters: Parameters) -> MohrCoulomb {
        let Parameters { friction, cohesion, dilation, .. } = parameters;
        let surface = Surface::new(&SurfaceDefinition { cone: Cone::Outer, friction, cohesion });
        let dilatancy = Dilatancy::of(&parameters, Cone::Outer);
        let sin_friction = sin(friction.last());
        let cosine = (1.0 - sin_friction * sin_friction).max(0.0).sqrt();
        let ((least, most), stays) = (friction.range(), surface.settled() == 0.0);
        MohrCoulomb {
            parameters,
            last: Pyramid {
                sin_friction,
                sin_dilation: if dilatancy.is_some() { 0.0 } else { sin(dilation) },
                strength: 2.0 * cohesion.last() * cosine,
            },
            surface,
            dilatancy,
            // k falls with the angle, so its smallest value is that of the largest angle
            inscribed: YieldParameters {
                alpha: Cone::PlaneStrain.at(least).alpha,
                kappa: Cone::PlaneStrain.at(most).k * cohesion.range().0,
            },
            inscribed_cut: if stays { f64::INFINITY } else { 0.0 },
        }
    }
}

impl From<MohrCoulomb> for Parameters {
    fn from(law: MohrCoulomb) -> Parameters {
        law.parameters
    }
}

impl ConstitutiveLaw for MohrCoulomb {
    const KEYS: &'static [&'static str] =
        &["friction_angle", "dilation_angle", "dilation", "cohesion", "friction_evolution", "cohesion_evolution"];

    fn of(parameters: &Parameters) -> MohrCoulomb {
        (*parameters).into()
    }

    fn elastic(&self) -> Elastic {
        self.parameters.elastic
    }

    #[inline]
    fn update_closed(&self, stress: Sym, dstrain: Sym, internal: InternalVariables) -> (Sym, InternalVariables) {
        let trial = self.parameters.elastic.update(stress, dstrain);
        let i1 = tensor::trace(&trial);
        let room = self.inscribed.kappa - self.inscribed.alpha * i1;
        if i1 <= self.inscribed_cut && room >= 0.0 && tensor::j2(&trial) <= room * room {
            return (trial, internal);
        }
        self.plastic_correction(trial, internal)
    }

    fn shear_strength(&self, plastic: f64) -> Option<[f64; 2]> {
        Some([self.parameters.friction.at(plastic).0, self.parameters.cohesion.at(plastic).0])
    }

    fn yield_line(&self, plastic: f64) -> Option<YieldParameters> {
        Some(self.surface.value(plastic))
    }

    fn q_compression(&self, cell: f64, plastic: f64) -> Option<f64> {
        Some(self.pyramid(plastic).q_compression(cell))
    }

    fn q_extension(&self, cell: f64, plastic: f64) -> Option<f64> {
        Some(self.pyramid(plastic).q_extension(cell))
    }

    /// At the largest friction angle; `None` where the cohesion changes as well.
    fn peak_q(&self, cell: f64, compression: bool) -> Option<f64> {
        let Evolution::Constant(cohesion) = self.parameters.cohesion else { return None };
        let cone = Cone::Outer.at(self.parameters.friction.range().1);
        let strongest = self.of_cone(YieldParameters { alpha: cone.alpha, kappa: cone.k * cohesion });
        Some(if compression { strongest.q_compression(cell) } else { strongest.q_extension(cell) })
    }
}

impl MohrCoulomb {
    /// Sines of the final friction and dilation angle.
    pub fn sines(&self) -> [f64; 2] {
        [self.last.sin_friction, self.last.sin_dilation]
    }

    /// 2 c cos φ of the final pyramid, Pa.
    pub fn strength(&self) -> f64 {
        self.last.strength
    }

    /// Mean stress at the apex of the final pyramid, c cot φ, Pa; infinite without friction.
    pub fn apex(&self) -> f64 {
        self.last.apex()
    }

    /// A cone inside the pyramid at every plastic strain, which touches all planes of one that stays, and the largest I1, Pa, up to which stresses inside of it are elastic.
    pub fn inscribed(&self) -> (YieldParameters, f64) {
        (self.inscribed, self.inscribed_cut)
    }

    /// The parameters that the law was made from.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The pyramid at an accumulated plastic strain.
    fn pyramid(&self, plastic: f64) -> Pyramid {
        self.surface.point(plastic).map_or(self.last, |point| self.of_cone(point.value()))
    }

    /// The pyramid whose edges of triaxial compression are on this cone.
    fn of_cone(&self, YieldParameters { alpha, kappa }: YieldParameters) -> Pyramid {
        let sin_friction = sine_of(alpha);
        Pyramid {
            sin_friction,
            sin_dilation: self.dilatancy.map_or(self.last.sin_dilation, |dilatancy| sine_of(dilatancy.at(alpha).0)),
            strength: kappa * (3.0 - sin_friction) * (1.0 / ROOT_3),
        }
    }

    /// Plastic strain of the return from these principal stresses, Pa, to those, and its size, -.
    fn increment(&self, before: &[f64; 3], after: &[f64; 3]) -> f64 {
        let Elastic { bulk, shear } = self.parameters.elastic;
        let gone: [f64; 3] = std::array::from_fn(|k| before[k] - after[k]);
        let mean = (gone[0] + gone[1] + gone[2]) * (1.0 / 3.0);
        let plastic = gone.map(|g| (g - mean) / (2.0 * shear) + mean / (3.0 * bulk));
        let square = plastic[0] * plastic[0] + plastic[1] * plastic[1] + plastic[2] * plastic[2];
        (2.0 / 3.0 * square).sqrt()
    }

    /// Stress and internal variables for a trial stress that may lie outside of the pyramid.
    #[inline(never)]
    fn plastic_correction(&self, trial: Sym, internal: InternalVariables) -> (Sym, InternalVariables) {
        let (before, directions) = principal(trial);
        let pyramid = self.pyramid(internal.plastic);
        // a stress on the surface may be outside by rounding
        let scale = before[0].abs().max(before[2].abs());
        if pyramid.yield_function(before[0], before[2]) <= 4.0 * f64::EPSILON * scale {
            return (trial, internal);
        }
        let (after, plastic) = if internal.plastic >= self.surface.settled() {
            let after = pyramid.returned(self.parameters.elastic, before);
            (after, internal.plastic + self.increment(&before, &after))
        } else {
            self.hardened(before, internal.plastic)
        };
        let mut stress = [0.0; 6];
        for (value, d) in after.iter().zip(directions) {
            for (k, (i, j)) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)].into_iter().enumerate() {
                stress[k] += value * (d[i] * d[j]);
            }
        }
        // of stresses that return all are equal at the apex alone
        let at_apex = after[0] == after[2] && after != before;
        let over = if at_apex { (tensor::trace(&trial) - 3.0 * after[0]).max(0.0) } else { 0.0 };
        (stress, InternalVariables { plastic, gap: internal.gap + over / (3.0 * self.parameters.elastic.bulk) })
    }

    /// Return to a pyramid that changes with the plastic strain: principal stresses, Pa, and the new plastic strain e, which is `start` and the size of the return to the pyramid
    /// at e.
    fn hardened(&self, trial: [f64; 3], start: f64) -> ([f64; 3], f64) {
        const ROUNDS: u32 = 100;
        let at = |plastic: f64| {
            let pyramid = self.pyramid(plastic);
            // inside of a pyramid nothing returns
            let yields = pyramid.yield_function(trial[0], trial[2]) > 0.0;
            let after = if yields { pyramid.returned(self.parameters.elastic, trial) } else { trial };
            let increment = self.increment(&trial, &after);
            (after, increment, plastic - start - increment)
        };
        let close = |(_, increment, rest): &([f64; 3], f64, f64), plastic: f64| {
            rest.abs() <= 1e-11 * increment + 4.0 * f64::EPSILON * plastic
        };
        let (mut low, mut low_rest) = (start, -at(start).1);
        let mut stride = -low_rest;
        let mut high = start + stride;
        let mut found = at(high);
        // an upper bound: beyond the whole return
        for _ in 0..ROUNDS {
            // a rest that is rounding is none: twice the plastic strain would be beyond it
            if found.2 >= 0.0 || close(&found, high) {
                break;
            }
            (low, low_rest) = (high, found.2);
            stride *= 2.0;
            high = start + stride;
            found = at(high);
        }
        let mut high_rest = found.2;
        // false position; the weight of an end that stays is halved (Illinois)
        let mut stayed = 0;
        for round in 0..ROUNDS {
            if close(&found, high) {
                break;
            }
            let share = if round % 8 == 7 { 0.5 } else { low_rest / (low_rest - high_rest) };
            let middle = low + share * (high - low);
            if middle <= low || middle >= high {
                break;
            }
            let there = at(middle);
            if close(&there, middle) {
                return (there.0, middle);
            }
            if there.2 < 0.0 {
                (low, low_rest) = (middle, there.2);
                high_rest *= if stayed == 1 { 0.5 } else { 1.0 };
                stayed = 1;
            } else {
                (high, high_rest, found) = (middle, there.2, there);
                low_rest *= if stayed == -1 { 0.5 } else { 1.0 };
                stayed = -1;
            }
        }
        (found.0, high)
    }
}

impl Pyramid {
    /// Mean stress at the apex, c cot φ, Pa; infinite without friction.
    fn apex(&self) -> f64 {
        if self.sin_friction > 0.0 { self.strength / (2.0 * self.sin_friction) } else { f64::INFINITY }
    }

    /// Axial less radial stress, Pa, at failure in triaxial compression at a cell pressure, Pa: σ1 (1 − sin φ) = σ3 (1 + sin φ) + 2 c cos φ.
    fn q_compression(&self, cell: f64) -> f64 {
        (cell * (1.0 + self.sin_friction) + self.strength) / (1.0 - self.sin_friction) - cell
    }

    /// Radial less axial stress, Pa, at failure in triaxial extension.
    fn q_extension(&self, cell: f64) -> f64 {
        cell - (cell * (1.0 - self.sin_friction) - self.strength) / (1.0 + self.sin_friction)
    }

    /// The yield function, Pa, of the largest and the smallest principal stress, Pa; negative inside of the pyramid.
    fn yield_function(&self, largest: f64, smallest: f64) -> f64 {
        (largest - smallest) + (largest + smallest) * self.sin_friction - self.strength
    }

    /// Principal stresses, Pa, after the return from the trial ones, which lie outside of the pyramid. The return to the plane is tried first, then that to the edge
    /// beside it; where that ends beyond the apex, the result is the apex.
    fn returned(&self, elastic: Elastic, trial: [f64; 3]) -> [f64; 3] {
        let (s, d) = (self.sin_friction, self.sin_dilation);
        let Elastic { bulk, shear } = elastic;
        // change per plastic multiplier of the largest, the middle and the smallest principal stress, for the flow of one plane; `own` is the change of its yield
        // function
        let largest = -(2.0 * shear * (1.0 + d * (1.0 / 3.0)) + 2.0 * bulk * d);
        let other = (4.0 / 3.0 * shear - 2.0 * bulk) * d;
        let smallest = 2.0 * shear * (1.0 - d * (1.0 / 3.0)) - 2.0 * bulk * d;
        let own = 4.0 * shear * (1.0 + s * d * (1.0 / 3.0)) + 4.0 * bulk * s * d;
        let ordered = |x: [f64; 3]| {
            let rounding = 8.0 * f64::EPSILON * (trial[0].abs() + trial[2].abs());
            x[0] >= x[1] - rounding && x[1] >= x[2] - rounding
        };

        let main = self.yield_function(trial[0], trial[2]);
        let m = main / own;
        let plane = [trial[0] + largest * m, trial[1] + other * m, trial[2] + smallest * m];
        if ordered(plane) {
            return plane;
        }
        // the return to the plane ends beyond one of its two edges: that of triaxial extension, σ2 = σ3, or that of triaxial compression, σ1 = σ2
        let extension = (1.0 - d) * trial[0] - 2.0 * trial[1] + (1.0 + d) * trial[2] > 0.0;
        let sign = if extension { 1.0 } else { -1.0 };
        let across = 2.0 * shear * (1.0 + sign * (s + d) - s * d * (1.0 / 3.0)) + 4.0 * bulk * s * d;
        let beside = if extension { self.yield_function(trial[0], trial[1]) } else { self.yield_function(trial[1], trial[2]) };
        let determinant = own * own - across * across;
        let (a, b) = ((own * main - across * beside) / determinant, (own * beside - across * main) / determinant);
        let edge = if extension {
            [trial[0] + largest * (a + b), trial[1] + other * a + smallest * b, trial[2] + smallest * a + other * b]
        } else {
            [trial[0] + largest * a + other * b, trial[1] + other * a + largest * b, trial[2] + smallest * (a + b)]
        };
        let apex = self.apex();
        let mean = (edge[0] + edge[1] + edge[2]) * (1.0 / 3.0);
        // on an edge the largest stress is above the smallest one only where their mean is below the apex
        if mean <= apex { edge } else { [apex; 3] }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Dilation;
    use super::super::evolution::tests::LI;
    use super::*;
    use proptest::prelude::*;

    const DEGREE: f64 = std::f64::consts::PI / 180.0;

    fn soil(phi: f64, psi: f64, cohesion: f64) -> MohrCoulomb {
        MohrCoulomb::of(&Parameters {
            cone: Cone::Outer,
            friction: Evolution::Constant(phi * DEGREE),
            cohesion: Evolution::Constant(cohesion),
            dilation: psi * DEGREE,
            ..Parameters::of_elastic(Elastic::of_young(20e6, 0.25))
        })
    }

    /// Friction that rises by a third and falls again, cohesion that fades, and a dilation angle that is a share of the smallest friction angle, or of the largest one and ends with it.
    fn changing(phi: f64, share: f64, cohesion: f64, ends: bool) -> MohrCoulomb {
        let (first, peak) = (0.75 * phi * DEGREE, phi * DEGREE);
        // through `first` at 0 and with the slope 0 through `peak` at 0.02
        let cubic = [0.0, (first - peak) / 4e-4, (peak - first) / 1e-2, first];
        let friction =
            Evolution::CubicExponential { initial: first, cubic, peak_strain: 0.02, peak, residual: 0.8 * peak, decay: 40.0 };
        MohrCoulomb::of(&Parameters {
            friction,
            cohesion: Evolution::Linear { initial: cohesion, last: 0.3 * cohesion, strain: 0.04 },
            dilation: share * if ends { peak } else { 0.999 * first },
            dilation_rule: if ends { Dilation::Mobilised } else { Dilation::Constant },
            ..Parameters::of_elastic(Elastic::of_young(20e6, 0.25))
        })
    }

    /// In the tail of the softening, where the pyramid changes by less than rounding, and at a jump upwards the plastic strain is no more than that of the return, and no stress leaves
    /// its trial outwards.
    #[test]
    fn tails_and_jumps_add_no_plastic_strain() {
        let law = changing(30.0, 0.5, 1e4, false);
        for k in 0..2000 {
            let (plastic, e) = (0.75 + 1e-4 * f64::from(k), -1e-4 * (1.0 + 1e-3 * f64::from(k)));
            let before = InternalVariables { plastic, gap: 0.0 };
            let start = [-5e4, -5e4, -5e4 - law.q_compression(5e4, plastic).expect("a strength"), 0.0, 0.0, 0.0];
            let (stress, after) = law.update(start, [0.0, 0.0, e, 0.0, 0.0, 0.0], before);
            let trial = law.elastic().update(start, [0.0, 0.0, e, 0.0, 0.0, 0.0]);
            let made = law.increment(&[trial[0], trial[1], trial[2]], &[stress[0], stress[1], stress[2]]);
            assert!((after.plastic - plastic) < made * (1.0 + 1e-9) && made > 0.0, "{plastic}: {made} {}", after.plastic - plastic);
        }
        let parameters = Parameters { friction: LI, ..*law.parameters() };
        let jumps = MohrCoulomb::of(&Parameters { cohesion: Evolution::Constant(0.0), dilation: 0.1, ..parameters });
        let before = InternalVariables { plastic: 0.022 - 1e-9, gap: 0.0 };
        let q = jumps.q_compression(5e4, before.plastic).expect("a strength");
        let start = [-5e4, -5e4, -5e4 - q, 0.0, 0.0, 0.0];
        let (stress, after) = jumps.update(start, [0.0, 0.0, -1e-6, 0.0, 0.0, 0.0], before);
        let trial = jumps.elastic().update(start, [0.0, 0.0, -1e-6, 0.0, 0.0, 0.0]);
        assert!(after.plastic > 0.022 && after.plastic < 0.022 + 1e-6, "{}", after.plastic);
        assert!(stress[0] - stress[2] <= (trial[0] - trial[2]) * (1.0 + 1e-12), "{stress:?} {trial:?}");
    }

    /// Strains axially at a constant cell pressure (compression negative here), the lateral strain found so that the lateral stress stays.
    fn triaxial(law: &MohrCoulomb, cell: f64, axial: f64) -> (Sym, [f64; 2]) {
        let (mut stress, mut internal) = ([-cell, -cell, -cell, 0.0, 0.0, 0.0], InternalVariables::default());
        let mut lateral_sum = 0.0;
        for _ in 0..400 {
            let da = axial / 400.0;
            let trial = |lateral: f64| law.update(stress, [lateral, lateral, da, 0.0, 0.0, 0.0], internal);
            let (mut low, mut high) = (-2.0 * da.abs(), 2.0 * da.abs());
            for _ in 0..200 {
                let middle = 0.5 * (low + high);
                if trial(middle).0[0] < -cell { low = middle } else { high = middle }
            }
            lateral_sum += low;
            (stress, internal) = trial(low);
        }
        (stress, [axial, lateral_sum])
    }

    /// Compression and extension fail at σ_largest = N σ_smallest + 2 c √N, and dilate by dε_v = −2 sin ψ/(1 − sin ψ) dε_a (compression) per plastic axial strain.
    #[test]
    fn triaxial_tests_fail_and_dilate_as_in_closed_form() {
        for (phi, psi, c) in [(35.0, 10.0, 0.0), (30.0, 30.0, 5e3), (25.0, 0.0, 20e3)] {
            let law = soil(phi, psi, c);
            let n = (1.0 + (phi * DEGREE).sin()) / (1.0 - (phi * DEGREE).sin());
            let cell = 100e3;
            let (stress, [axial, lateral]) = triaxial(&law, cell, -0.1);
            assert!((-stress[2] / (n * cell + 2.0 * c * n.sqrt()) - 1.0).abs() < 1e-9, "{phi} {psi}: {stress:?}");
            assert!((-stress[2] - cell - law.q_compression(cell, 0.0).unwrap()).abs() < 1e-4);
            // the elastic part stays what it was at failure
            let young = law.elastic().young();
            let q = -stress[2] - cell;
            let (plastic_axial, plastic_lateral) = (axial + q / young, lateral - 0.25 * q / young);
            let sine = (psi * DEGREE).sin();
            let volume = plastic_axial + 2.0 * plastic_lateral;
            assert!((volume / -plastic_axial - 2.0 * sine / (1.0 - sine)).abs() < 1e-6, "{phi} {psi}: {volume} {plastic_axial}");
            let (stress, _) = triaxial(&law, cell, 0.1);
            assert!(((n * -stress[2] + 2.0 * c * n.sqrt()) / cell - 1.0).abs() < 1e-9, "extension {phi} {psi}: {stress:?}");
            assert!((cell + stress[2] - law.q_extension(cell, 0.0).unwrap()).abs() < 1e-4);
        }
    }

    /// Where friction softens, drained compression passes the peak, ends at the residual ratio, and with dilation that ends keeps its volume there: over the whole test the plastic
    /// volume is the integral of the dilation over the plastic strain.
    #[test]
    fn volume_ends_with_the_softening() {
        let law = changing(36.0, 0.4, 0.0, true);
        let (cell, steps, last) = (100e3, 30_000, 0.3);
        let (mut stress, mut internal) = ([-cell, -cell, -cell, 0.0, 0.0, 0.0], InternalVariables::default());
        let (mut peak, mut volumes) = (0.0_f64, Vec::new());
        let mut volume = 0.0;
        for _ in 0..steps {
            let da = -last / f64::from(steps);
            let trial = |lateral: f64| law.update(stress, [lateral, lateral, da, 0.0, 0.0, 0.0], internal);
            let (mut low, mut high) = (2.0 * da, -20.0 * da);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if trial(middle).0[0] < -cell { low = middle } else { high = middle }
            }
            let after = trial(low);
            let elastic = (tensor::trace(&after.0) - tensor::trace(&stress)) / (9.0 * law.elastic().bulk) * 3.0;
            volume += 2.0 * low + da - elastic;
            (stress, internal) = after;
            peak = peak.max(stress[2] / stress[0]);
            volumes.push((internal.plastic, volume));
        }
        let ratio = |phi: f64| (1.0 + (phi * DEGREE).sin()) / (1.0 - (phi * DEGREE).sin());
        assert!((peak / ratio(36.0) - 1.0).abs() < 1e-3, "{peak}");
        assert!((stress[2] / stress[0] / ratio(0.8 * 36.0) - 1.0).abs() < 1e-3);
        let (at, before) = (volumes[volumes.len() - 1], volumes[volumes.len() - 3000]);
        assert!(at.1 > 0.01 && (at.1 - before.1).abs() < 1e-3 * at.1, "{at:?} {before:?}");
        // on the edge of triaxial compression: axial strain −1, lateral ones (1 + sin ψ)/(2 (1 − sin ψ)) each
        const N: u32 = 20_000;
        let rate = |e: f64| {
            let d = law.pyramid(e).sin_dilation;
            let lateral = 0.5 * (1.0 + d) / (1.0 - d);
            (2.0 * lateral - 1.0) / (2.0 / 3.0 * (1.0 + 2.0 * lateral * lateral)).sqrt()
        };
        let h = at.0 / f64::from(N);
        let integral: f64 = (0..N).map(|k| rate(h * (f64::from(k) + 0.5)) * h).sum();
        assert!((at.1 / integral - 1.0).abs() < 2e-3, "{} for {integral}", at.1);
    }

    /// Plane strain with ψ = 0: the middle stress is between the others and does not count.
    #[test]
    fn plane_strain_fails_at_the_same_ratio() {
        let law = soil(30.0, 0.0, 0.0);
        let (mut stress, mut internal) = ([-1e5, -1e5, -1e5, 0.0, 0.0, 0.0], InternalVariables::default());
        for _ in 0..4000 {
            (stress, internal) = law.update(stress, [1e-5, 0.0, -1e-5, 0.0, 0.0, 0.0], internal);
        }
        assert!((stress[2] / stress[0] - 3.0).abs() < 1e-9, "{stress:?}");
        assert!(stress[1] < stress[0] && stress[1] > stress[2]);
    }

    proptest! {
        /// With ψ = φ the return is the nearest admissible stress in the norm of the elastic energy: towards no other one does the plastic strain do more work.
        #[test]
        fn associated_returns_are_nearest(
            e in prop::array::uniform6(-0.02..0.02f64), p in 0.0..2e5f64, phi in 1.0..50.0f64, c in 0.0..3e4f64,
            others in prop::collection::vec(prop::array::uniform3(-4e5..1e5f64), 12),
        ) {
            let law = soil(phi, phi, c);
            let before = principal(law.elastic().update([-p, -p, -p, 0.0, 0.0, 0.0], e)).0;
            prop_assume!(law.last.yield_function(before[0], before[2]) > 0.0);
            let after = law.last.returned(law.elastic(), before);
            let size = before.iter().chain(&after).map(|x| x.abs()).sum::<f64>();
            prop_assert!(after[0] >= after[1] - 1e-12 * size && after[1] >= after[2] - 1e-12 * size, "{after:?}");
            let Elastic { bulk, shear } = law.elastic();
            let gone: [f64; 3] = std::array::from_fn(|k| before[k] - after[k]);
            let mean = (gone[0] + gone[1] + gone[2]) / 3.0;
            let plastic = gone.map(|g| (g - mean) / (2.0 * shear) + mean / (3.0 * bulk));
            let strain = plastic.iter().map(|x| x.abs()).sum::<f64>();
            for mut other in others {
                other.sort_by(|a, b| b.total_cmp(a));
                if law.last.yield_function(other[0], other[2]) > 0.0 {
                    other = law.last.returned(law.elastic(), other);
                }
                let work: f64 = (0..3).map(|k| plastic[k] * (other[k] - after[k])).sum();
                prop_assert!(work <= 1e-9 * (size + 1e6) * strain, "{before:?} {after:?} {other:?}: {work}");
            }
        }

        /// From anywhere the return ends on the surface, dissipates, keeps its directions and does not move again; so it does where the surface hardens or softens, with dilation that
        /// stays or ends.
        #[test]
        fn returns_end_on_the_surface(
            e in prop::array::uniform6(-0.02..0.02f64), p in 0.0..2e5f64, phi in 1.0..50.0f64, share in 0.0..1.0f64, c in 0.0..3e4f64, kind in 0..3usize,
            plastic in 0.0..0.06f64,
        ) {
            let law = match kind {
                0 => soil(phi, share * phi, c),
                kind => changing(phi, share, c, kind == 2),
            };
            let start = [-p, -p, -p, 0.0, 0.0, 0.0];
            let before = InternalVariables { plastic: if kind == 0 { 0.0 } else { plastic }, gap: 0.0 };
            let (stress, internal) = law.update(start, e, before);
            let trial = law.elastic().update(start, e);
            let ([a, b, z], size) = (principal(stress).0, tensor::j2(&trial).sqrt() + tensor::trace(&trial).abs());
            prop_assert!(law.pyramid(internal.plastic).yield_function(a, z) <= 1e-10 * size, "{} of {size}", law.pyramid(internal.plastic).yield_function(a, z));
            let _ = b;
            if internal.plastic > before.plastic {
                // work of the plastic strain: σ : C (trial − σ) >= 0
                let gone: Sym = std::array::from_fn(|k| trial[k] - stress[k]);
                let mean = tensor::trace(&gone) / 3.0;
                let Elastic { bulk, shear } = law.elastic();
                let strain: Sym = std::array::from_fn(|k| if k < 3 { (gone[k] - mean) / (2.0 * shear) + mean / (3.0 * bulk) } else { gone[k] / (2.0 * shear) });
                prop_assert!(tensor::contract(&stress, &strain) >= -1e-9 * size * tensor::equivalent(&strain));
                let made = internal.plastic - before.plastic;
                prop_assert!((made / tensor::equivalent(&strain) - 1.0).abs() < 1e-6 + 1e-14 / made, "{made} {strain:?}");
                let again = law.update(stress, [0.0; 6], internal);
                let moved: Sym = std::array::from_fn(|k| again.0[k] - stress[k]);
                prop_assert!(moved.iter().all(|m| m.abs() <= 1e-9 * size), "{moved:?}");
            } else {
                prop_assert_eq!(stress, trial);
            }
        }
    }
}
