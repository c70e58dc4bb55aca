//! Mohr–Coulomb plasticity with constant friction, cohesion and dilation, tension positive, principal stresses σ1 ≥ σ2 ≥ σ3:
//! f = (σ1 − σ3) + (σ1 + σ3) sin φ − 2 c cos φ ≤ 0. The plastic potential is f with the dilation angle ψ in place of φ.
//!
//! - φ, ψ — friction and dilation angle, rad; c — cohesion, Pa
//!
//! The return is exact. In the space of principal stresses the surface is a pyramid of planes: a trial stress returns to one of its planes, to an edge between two
//! of them or to the apex c cot φ in closed form, and its principal directions do not change (de Souza Neto, Perić & Owen 2008, Computational Methods for Plasticity,
//! section 8.2).
//!
//! Without cohesion triaxial compression and extension fail at the same ratio of the largest to the smallest stress, (1 + sin φ)/(1 − sin φ).
//!
//! Holds for 0 ≤ ψ ≤ φ: dissipation is then not negative.

use super::{Cone, ConstitutiveLaw, Elastic, InternalVariables, Parameters, Sym, YieldParameters, tensor};
use crate::math::eigen::principal;
use crate::math::portable::sin;
use serde::{Deserialize, Serialize};

/// The law of Mohr and Coulomb, with constants that follow from its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Parameters", into = "Parameters")]
pub struct MohrCoulomb {
    parameters: Parameters,
    friction_angle: f64,
    cohesion: f64,
    /// sin φ.
    sin_friction: f64,
    /// sin ψ.
    sin_dilation: f64,
    /// 2 c cos φ, Pa.
    strength: f64,
    /// The cone inside the pyramid that touches all of its planes: stresses inside it are elastic, which saves the computation of their principal values.
    inscribed: YieldParameters,
}

impl From<Parameters> for MohrCoulomb {
    fn from(parameters: Parameters) -> MohrCoulomb {
        let (friction_angle, cohesion) = (parameters.friction.at(0.0).0, parameters.cohesion.at(0.0).0);
        let sin_friction = sin(friction_angle);
        let cosine = (1.0 - sin_friction * sin_friction).max(0.0).sqrt();
        let cone = Cone::PlaneStrain.at(friction_angle);
        MohrCoulomb {
            parameters,
            friction_angle,
            cohesion,
            sin_friction,
            sin_dilation: sin(parameters.dilation),
            strength: 2.0 * cohesion * cosine,
            inscribed: YieldParameters { alpha: cone.alpha, kappa: cone.k * cohesion },
        }
    }
}

impl From<MohrCoulomb> for Parameters {
    fn from(law: MohrCoulomb) -> Parameters {
        law.parameters
    }
}

impl ConstitutiveLaw for MohrCoulomb {
    const KEYS: &'static [&'static str] = &["friction_angle", "dilation_angle", "cohesion"];

    fn of(parameters: &Parameters) -> MohrCoulomb {
        (*parameters).into()
    }

    fn elastic(&self) -> Elastic {
        self.parameters.elastic
    }

    #[inline]
    fn update(&self, stress: Sym, dstrain: Sym, internal: InternalVariables) -> (Sym, InternalVariables) {
        let trial = self.parameters.elastic.update(stress, dstrain);
        let room = self.inscribed.kappa - self.inscribed.alpha * tensor::trace(&trial);
        if room >= 0.0 && tensor::j2(&trial) <= room * room {
            return (trial, internal);
        }
        self.plastic_correction(trial, internal)
    }

    fn shear_strength(&self, _: f64) -> Option<[f64; 2]> {
        Some([self.friction_angle, self.cohesion])
    }

    fn yield_line(&self, _: f64) -> Option<YieldParameters> {
        let cone = Cone::Outer.at(self.friction_angle);
        Some(YieldParameters { alpha: cone.alpha, kappa: cone.k * self.cohesion })
    }

    fn q_compression(&self, cell: f64, _: f64) -> Option<f64> {
        // σ1 (1 − sin φ) = σ3 (1 + sin φ) + 2 c cos φ
        Some((cell * (1.0 + self.sin_friction) + self.strength) / (1.0 - self.sin_friction) - cell)
    }

    fn q_extension(&self, cell: f64, _: f64) -> Option<f64> {
        Some(cell - (cell * (1.0 - self.sin_friction) - self.strength) / (1.0 + self.sin_friction))
    }

    fn peak_q(&self, cell: f64, compression: bool) -> Option<f64> {
        if compression { self.q_compression(cell, 0.0) } else { self.q_extension(cell, 0.0) }
    }
}

impl MohrCoulomb {
    /// The yield function, Pa, of the largest and the smallest principal stress, Pa; negative inside of the pyramid.
    fn yield_function(&self, largest: f64, smallest: f64) -> f64 {
        (largest - smallest) + (largest + smallest) * self.sin_friction - self.strength
    }

    /// Stress and internal variables for a trial stress that may lie outside of the pyramid.
    #[inline(never)]
    fn plastic_correction(&self, trial: Sym, internal: InternalVariables) -> (Sym, InternalVariables) {
        let (before, directions) = principal(trial);
        // a stress on the surface may be outside by rounding
        let scale = before[0].abs().max(before[2].abs());
        if self.yield_function(before[0], before[2]) <= 4.0 * f64::EPSILON * scale {
            return (trial, internal);
        }
        let after = self.returned(before);
        let mut stress = [0.0; 6];
        for (value, d) in after.iter().zip(directions) {
            for (k, (i, j)) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)].into_iter().enumerate() {
                stress[k] += value * (d[i] * d[j]);
            }
        }
        let Elastic { bulk, shear } = self.parameters.elastic;
        let gone: [f64; 3] = std::array::from_fn(|k| before[k] - after[k]);
        let mean = (gone[0] + gone[1] + gone[2]) * (1.0 / 3.0);
        let plastic = gone.map(|g| (g - mean) / (2.0 * shear) + mean / (3.0 * bulk));
        let square = plastic[0] * plastic[0] + plastic[1] * plastic[1] + plastic[2] * plastic[2];
        (stress, InternalVariables { plastic: internal.plastic + (2.0 / 3.0 * square).sqrt() })
    }

    /// Principal stresses, Pa, after the return from the trial ones, which lie outside of the pyramid. The return to the plane is tried first, then that to the edge
    /// beside it; where that ends beyond the apex, the result is the apex.
    fn returned(&self, trial: [f64; 3]) -> [f64; 3] {
        let (s, d) = (self.sin_friction, self.sin_dilation);
        let Elastic { bulk, shear } = self.parameters.elastic;
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
        let apex = if s > 0.0 { self.strength / (2.0 * s) } else { f64::INFINITY };
        let mean = (edge[0] + edge[1] + edge[2]) * (1.0 / 3.0);
        // on an edge the largest stress is above the smallest one only where their mean is below the apex
        if mean <= apex { edge } else { [apex; 3] }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Evolution;
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
            prop_assume!(law.yield_function(before[0], before[2]) > 0.0);
            let after = law.returned(before);
            let size = before.iter().chain(&after).map(|x| x.abs()).sum::<f64>();
            prop_assert!(after[0] >= after[1] - 1e-12 * size && after[1] >= after[2] - 1e-12 * size, "{after:?}");
            let Elastic { bulk, shear } = law.elastic();
            let gone: [f64; 3] = std::array::from_fn(|k| before[k] - after[k]);
            let mean = (gone[0] + gone[1] + gone[2]) / 3.0;
            let plastic = gone.map(|g| (g - mean) / (2.0 * shear) + mean / (3.0 * bulk));
            let strain = plastic.iter().map(|x| x.abs()).sum::<f64>();
            for mut other in others {
                other.sort_by(|a, b| b.total_cmp(a));
                if law.yield_function(other[0], other[2]) > 0.0 {
                    other = law.returned(other);
                }
                let work: f64 = (0..3).map(|k| plastic[k] * (other[k] - after[k])).sum();
                prop_assert!(work <= 1e-9 * (size + 1e6) * strain, "{before:?} {after:?} {other:?}: {work}");
            }
        }

        /// From anywhere the return ends on the surface, dissipates, keeps its directions and does not move again.
        #[test]
        fn returns_end_on_the_surface(
            e in prop::array::uniform6(-0.02..0.02f64), p in 0.0..2e5f64, phi in 1.0..50.0f64, share in 0.0..1.0f64, c in 0.0..3e4f64,
        ) {
            let law = soil(phi, share * phi, c);
            let start = [-p, -p, -p, 0.0, 0.0, 0.0];
            let (stress, internal) = law.update(start, e, InternalVariables::default());
            let trial = law.elastic().update(start, e);
            let ([a, b, z], size) = (principal(stress).0, tensor::j2(&trial).sqrt() + tensor::trace(&trial).abs());
            prop_assert!(law.yield_function(a, z) <= 1e-10 * size, "{} of {size}", law.yield_function(a, z));
            let _ = b;
            if internal.plastic > 0.0 {
                // work of the plastic strain: σ : C (trial − σ) >= 0
                let gone: Sym = std::array::from_fn(|k| trial[k] - stress[k]);
                let mean = tensor::trace(&gone) / 3.0;
                let Elastic { bulk, shear } = law.elastic();
                let strain: Sym = std::array::from_fn(|k| if k < 3 { (gone[k] - mean) / (2.0 * shear) + mean / (3.0 * bulk) } else { gone[k] / (2.0 * shear) });
                prop_assert!(tensor::contract(&stress, &strain) >= -1e-9 * size * tensor::equivalent(&strain));
                prop_assert!((internal.plastic / tensor::equivalent(&strain) - 1.0).abs() < 1e-6, "{} {strain:?}", internal.plastic);
                let again = law.update(stress, [0.0; 6], internal);
                let moved: Sym = std::array::from_fn(|k| again.0[k] - stress[k]);
                prop_assert!(moved.iter().all(|m| m.abs() <= 1e-9 * size), "{moved:?}");
            } else {
                prop_assert_eq!(stress, trial);
            }
        }
    }
}
