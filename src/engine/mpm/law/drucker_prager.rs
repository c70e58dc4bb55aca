//! Drucker-Prager plasticity with a tension cut-off, tension positive: f = J + alpha I1 - k c <= 0 and I1 <= 3 sigma_t, with J = sqrt(J2) and I1 = tr(sigma).
//!
//! - alpha, k - from the [`Cone`] and the friction angle phi, -; c - cohesion, Pa. Both may change with the accumulated plastic strain ([`Evolution`])
//! - sigma_t - largest mean tension, Pa; the apex of the cone, k c / (3 alpha), is a limit as well
//! - psi - dilation angle, rad; it stays, or falls with phi to 0 at the final phi ([`super::dilatancy`])
//!
//! The plastic potential is J + alpha_psi I1 on the cone. At the cut-off plastic strain is volumetric, and at the corner between cone and cut-off it is a sum of
//! both; the apex is the corner with J = 0.
//!
//! The return is implicit: the new stress lies on the surface of the new plastic strain. In (I1, J) it has a closed form if the surface does not change; if it
//! does ([`Surface`]), one equation in the plastic strain is solved. A dilation angle that falls is that of the new plastic strain as well, so that no step, however large,
//! dilates more than its end allows; over many steps the plastic volume strain is the integral over the plastic strain with an error of first order in the step.
//!
//! Holds for 0 <= psi <= phi (where psi falls with phi: at the largest phi): dissipation is then not negative. What material that is pulled apart does not follow is the opening of
//! its gap ([`super::gap`]).

use super::dilatancy::Dilatancy;
use super::surface::{Surface, SurfaceDefinition, SurfacePoint, YieldParameters};
use super::{Cone, ConstitutiveLaw, Elastic, Evolution, InternalVariables, Parameters, Sym, tensor};
use serde::{Deserialize, Serialize};

/// The law of Drucker and Prager, with constants that follow from its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Parameters", into = "Parameters")]
pub struct DruckerPrager {
    elastic: Elastic,
    /// A surface that lies inside of the yield surface at every plastic strain: stresses inside of it, with I1 up to `floor_cut`, are elastic.
    floor: YieldParameters,
    /// Largest I1, Pa, of such stresses.
    floor_cut: f64,
    /// Flow on the cone with the stated dilation angle.
    flow: Flow,
    /// How the dilation angle falls; `None` where it stays.
    dilatancy: Option<Dilatancy>,
    /// 3 sigma_t, Pa.
    cut: f64,
    surface: Surface,
    parameters: Parameters,
}

impl From<Parameters> for DruckerPrager {
    fn from(parameters: Parameters) -> DruckerPrager {
        DruckerPrager::new(parameters)
    }
}

impl From<DruckerPrager> for Parameters {
    fn from(law: DruckerPrager) -> Parameters {
        law.parameters
    }
}

impl ConstitutiveLaw for DruckerPrager {
    const KEYS: &'static [&'static str] = &[
        "cone",
        "friction_angle",
        "dilation_angle",
        "dilation",
        "cohesion",
        "tension",
        "friction_evolution",
        "cohesion_evolution",
    ];

    fn of(parameters: &Parameters) -> DruckerPrager {
        DruckerPrager::new(*parameters)
    }

    #[inline]
    fn update_closed(&self, stress: Sym, dstrain: Sym, internal: InternalVariables) -> (Sym, InternalVariables) {
        let trial = self.elastic.update(stress, dstrain);
        let i1 = tensor::trace(&trial);
        let j2 = tensor::j2(&trial);
        let room = self.floor.kappa - self.floor.alpha * i1;
        if i1 <= self.floor_cut && room >= 0.0 && j2 <= room * room {
            return (trial, internal);
        }
        self.plastic_correction(trial, i1, j2.sqrt(), internal)
    }

    fn elastic(&self) -> Elastic {
        self.elastic
    }

    fn cone(&self) -> Option<Cone> {
        Some(self.parameters.cone)
    }

    fn shear_strength(&self, plastic: f64) -> Option<[f64; 2]> {
        Some([self.parameters.friction.at(plastic).0, self.parameters.cohesion.at(plastic).0])
    }

    fn yield_line(&self, plastic: f64) -> Option<YieldParameters> {
        Some(self.strength(plastic))
    }

    fn q_compression(&self, cell: f64, plastic: f64) -> Option<f64> {
        Some(self.strength(plastic).q_compression(cell))
    }

    fn q_extension(&self, cell: f64, plastic: f64) -> Option<f64> {
        Some(self.strength(plastic).q_extension(cell))
    }

    /// At the largest friction angle; `None` where the cohesion changes as well.
    fn peak_q(&self, cell: f64, compression: bool) -> Option<f64> {
        let Evolution::Constant(cohesion) = self.parameters.cohesion else { return None };
        let cone = self.parameters.cone.at(self.parameters.friction.range().1);
        let strongest = YieldParameters { alpha: cone.alpha, kappa: cone.k * cohesion };
        Some(if compression { strongest.q_compression(cell) } else { strongest.q_extension(cell) })
    }
}

/// Plastic flow on the cone, per plastic multiplier.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Flow {
    /// 9 K alpha_psi, Pa: by how much I1 falls.
    volume_return: f64,
    /// Accumulated plastic strain, sqrt(1/3 + 2 alpha_psi²), -.
    per_multiplier: f64,
}

impl Flow {
    #[inline]
    fn new(bulk: f64, alpha_psi: f64) -> Flow {
        Flow { volume_return: 9.0 * bulk * alpha_psi, per_multiplier: (1.0 / 3.0 + 2.0 * (alpha_psi * alpha_psi)).sqrt() }
    }
}

/// The stress after the return to the yield surface: its invariants, Pa, and whether it lies on the cone (not at the cut-off or the apex).
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Returned {
    i1: f64,
    j: f64,
    on_cone: bool,
}

impl DruckerPrager {
    /// The law with these parameters. Angles must be in 0..pi/2, and the dilation angle not above any value of the friction angle; one that falls, not above the largest.
    pub fn new(parameters: Parameters) -> DruckerPrager {
        let Parameters { elastic, cone, friction, cohesion, dilation, tension, .. } = parameters;
        let alpha_psi = cone.at(dilation).alpha;
        let (least, most) = friction.range();
        let least_cohesion = cohesion.range().0;
        let surface = Surface::new(&SurfaceDefinition { cone, friction, cohesion });
        let (last, settled) = (surface.last(), surface.settled());
        let mut law = DruckerPrager {
            elastic,
            // k falls with the angle, so its smallest value is that of the largest angle
            floor: YieldParameters { alpha: cone.at(least).alpha, kappa: cone.at(most).k * least_cohesion },
            floor_cut: 0.0,
            flow: Flow::new(elastic.bulk, alpha_psi),
            dilatancy: Dilatancy::of(&parameters, cone),
            cut: 3.0 * tension,
            surface,
            parameters,
        };
        if settled == 0.0 {
            law.floor = last;
            law.floor_cut = law.cut_of(last);
        }
        law
    }

    /// The elastic part of the law.
    pub fn elastic(&self) -> Elastic {
        self.elastic
    }

    /// The parameters that the law was made from.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Slope alpha_psi of the plastic potential, -, at an accumulated plastic strain.
    pub fn potential_slope(&self, plastic: f64) -> f64 {
        let Some(dilatancy) = self.dilatancy else { return self.parameters.cone.at(self.parameters.dilation).alpha };
        dilatancy.at(self.strength(plastic).alpha).0
    }

    /// Flow at a slope of the cone.
    #[inline]
    fn flow_at(&self, alpha: f64) -> Flow {
        match &self.dilatancy {
            None => self.flow,
            Some(dilatancy) => Flow::new(self.elastic.bulk, dilatancy.at(alpha).0),
        }
    }

    /// The yield surface at an accumulated plastic strain.
    pub fn strength(&self, plastic: f64) -> YieldParameters {
        self.surface.value(plastic)
    }

    /// Largest I1, Pa, at an accumulated plastic strain: that of the cut-off or of the apex.
    pub fn largest_i1(&self, plastic: f64) -> f64 {
        self.cut_of(self.strength(plastic))
    }

    /// The yield function, Pa: by how much a stress lies outside of the cone or the cut-off, whichever is more; negative inside of both.
    pub fn yield_function(&self, stress: &Sym, internal: InternalVariables) -> f64 {
        let strength = self.strength(internal.plastic);
        let i1 = tensor::trace(stress);
        let cone = tensor::j2(stress).sqrt() + strength.alpha * i1 - strength.kappa;
        cone.max(i1 - self.cut_of(strength))
    }

    /// Stress, Pa, and internal variables for a trial stress with the invariants `i1` and `j`, Pa, that may lie outside of the yield surface.
    #[inline(never)]
    fn plastic_correction(&self, trial: Sym, i1: f64, j: f64, internal: InternalVariables) -> (Sym, InternalVariables) {
        let before = internal.plastic;
        let point = self.surface.point(before);
        let strength = point.map_or(self.surface.last(), |point| point.value());
        if self.inside(strength, i1, j) {
            return (trial, internal);
        }
        let (end, plastic) = match point {
            None => {
                let end = self.returned(strength, i1, j);
                (end, before + self.increment(i1, j, end))
            }
            Some(point) => self.newton_return(i1, j, before, point).unwrap_or_else(|| self.hardened(i1, j, before)),
        };
        let share = if j > 0.0 { end.j / j } else { 0.0 };
        let (before, after) = (i1 * (1.0 / 3.0), end.i1 * (1.0 / 3.0));
        let stress = [
            (trial[0] - before) * share + after,
            (trial[1] - before) * share + after,
            (trial[2] - before) * share + after,
            trial[3] * share,
            trial[4] * share,
            trial[5] * share,
        ];
        let opened = if end.on_cone { 0.0 } else { (i1 - end.i1) / (3.0 * self.elastic.bulk) };
        (stress, InternalVariables { plastic, gap: internal.gap + opened })
    }

    /// The return to the cone, and the new plastic strain, by Newton's method, for an increment so small that the surface changes smoothly over it
    /// ([`SurfacePoint::advanced_by`]). `None` for a larger one, where the surface jumps, at the cut-off and at the apex.
    #[inline]
    fn newton_return(&self, i1: f64, j: f64, before: f64, point: SurfacePoint<'_>) -> Option<(Returned, f64)> {
        const ROUNDS: u32 = 6;
        let (mut multiplier, mut increment, mut enough) = (0.0, 0.0, None);
        let mut at = point;
        for _ in 0..ROUNDS {
            let YieldParameters { alpha, kappa } = at.value();
            let Flow { volume_return, per_multiplier } = self.flow_at(alpha);
            if self.dilatancy.is_some() {
                // the unknown is the plastic strain
                multiplier = increment / per_multiplier;
            }
            let end = i1 - volume_return * multiplier;
            let excess = (j - self.elastic.shear * multiplier) + alpha * end - kappa;
            if excess.abs() <= *enough.get_or_insert(1e-11 * excess + 4.0 * f64::EPSILON * j) {
                let within = end <= self.cut && alpha * end < kappa;
                return within.then_some((Returned { i1: end, j: kappa - alpha * end, on_cone: true }, before + increment));
            }
            let slope = at.slope();
            let mut tangent = self.elastic.shear + volume_return * alpha - per_multiplier * (end * slope.alpha - slope.kappa);
            if let Some(dilatancy) = &self.dilatancy {
                // the flow changes with the plastic strain: alpha_psi by `change`, the accumulated strain per multiplier by 2 alpha_psi change / per_multiplier
                let (alpha_psi, per_alpha) = dilatancy.at(alpha);
                let change = per_alpha * slope.alpha;
                let stiffness = self.elastic.shear + volume_return * alpha;
                let fewer = stiffness * (2.0 * alpha_psi * change / per_multiplier);
                tangent += multiplier * (9.0 * self.elastic.bulk * alpha * change * per_multiplier - fewer);
            }
            if tangent <= 0.0 {
                return None;
            }
            multiplier += excess / tangent;
            increment = per_multiplier * multiplier;
            at = point.advanced_by(increment)?;
        }
        None
    }

    /// Largest I1, Pa: that of the cut-off or of the apex.
    #[inline]
    fn cut_of(&self, strength: YieldParameters) -> f64 {
        // without friction there is no apex: kappa / 0 is infinite, or NaN, of which `min` takes the other value
        self.cut.min(strength.kappa / strength.alpha)
    }

    /// Whether a stress lies inside of this yield surface.
    #[inline]
    fn inside(&self, strength: YieldParameters, i1: f64, j: f64) -> bool {
        j + strength.alpha * i1 <= strength.kappa && i1 <= self.cut_of(strength)
    }

    /// Return of a trial stress to a fixed surface: to the cone, or, where that ends beyond the cut-off, to the corner or to the cut-off.
    #[inline]
    fn returned(&self, strength: YieldParameters, i1: f64, j: f64) -> Returned {
        let YieldParameters { alpha, kappa } = strength;
        let cut = self.cut_of(strength);
        let excess = j + alpha * i1 - kappa;
        if i1 <= cut {
            if excess <= 0.0 {
                return Returned { i1, j, on_cone: false };
            }
        } else if j <= self.corner(strength, cut) {
            return Returned { i1: cut, j, on_cone: false };
        }
        let Flow { volume_return, .. } = self.flow_at(alpha);
        let multiplier = excess / (self.elastic.shear + volume_return * alpha);
        let end = i1 - volume_return * multiplier;
        if end > cut {
            return Returned { i1: cut, j: self.corner(strength, cut), on_cone: false };
        }
        Returned { i1: end, j: (kappa - alpha * end).max(0.0), on_cone: true }
    }

    /// J, Pa, at the corner between the cone and the cut-off at I1 = `cut`, which may be infinite without friction.
    #[inline]
    fn corner(&self, strength: YieldParameters, cut: f64) -> f64 {
        if strength.alpha > 0.0 { (strength.kappa - strength.alpha * cut).max(0.0) } else { strength.kappa }
    }

    /// Increment of the accumulated plastic strain in the return from (`i1`, `j`) to `end`: sqrt(2/3 de_p:de_p), with the deviator s and
    /// de_p = (s / 2J) (J_trial - J) / G + I (I1_trial - I1) / 9K.
    #[inline]
    fn increment(&self, i1: f64, j: f64, end: Returned) -> f64 {
        let shear = (j - end.j) / self.elastic.shear;
        let volume = (i1 - end.i1) / (3.0 * self.elastic.bulk);
        ((shear * shear) * (1.0 / 3.0) + (volume * volume) * (2.0 / 9.0)).sqrt()
    }

    /// Return to a surface that changes with the plastic strain. Solves e = before + (increment of the return to the surface at e) for the new plastic strain e,
    /// by Newton's method within bounds, and by bisection where that does not converge. Where the strength jumps upwards there may be no solution: e is then just
    /// beyond the jump, and the stress lies between the two surfaces, as that plastic strain demands.
    fn hardened(&self, i1: f64, j: f64, before: f64) -> (Returned, f64) {
        const NEWTON: u32 = 10;
        const MOST: u32 = 100;
        let mut low = before;
        let mut high = before + self.largest_increment(i1, j);
        let mut at = before;
        for round in 0..MOST {
            let point = self.surface.point(at);
            let (strength, slope) =
                point.map_or((self.surface.last(), YieldParameters::default()), |point| (point.value(), point.slope()));
            let end = self.returned(strength, i1, j);
            let increment = self.increment(i1, j, end);
            let rest = at - before - increment;
            // the stress lies on the surface at `at` in any case; `rest` is how far `at` is from the plastic strain of the return
            if rest.abs() <= 1e-10 * increment + 4.0 * f64::EPSILON * at {
                return (end, at);
            }
            if rest < 0.0 {
                low = at;
            } else {
                high = at;
            }
            let tangent = if end.on_cone {
                let Flow { volume_return, per_multiplier } = self.flow_at(strength.alpha);
                let stiffness = self.elastic.shear + volume_return * strength.alpha;
                1.0 - per_multiplier * (end.i1 * slope.alpha - slope.kappa) / stiffness
            } else {
                1.0
            };
            let next = at - rest / tangent;
            let useful = round < NEWTON && next > low && next < high;
            at = if useful { next } else { low + 0.5 * (high - low) };
            if at <= low || at >= high {
                break;
            }
        }
        (self.at_jump(i1, j, high - before, self.strength(high)), high)
    }

    /// The stress after plastic flow on the cone by `increment`, if it lies inside of `strength`, the surface beyond a jump; otherwise the return to that surface.
    fn at_jump(&self, i1: f64, j: f64, increment: f64, strength: YieldParameters) -> Returned {
        let Flow { volume_return, per_multiplier } = self.flow_at(strength.alpha);
        let multiplier = increment / per_multiplier;
        let end = Returned { i1: i1 - volume_return * multiplier, j: j - self.elastic.shear * multiplier, on_cone: true };
        if end.j >= 0.0 && self.inside(strength, end.i1, end.j) { end } else { self.returned(strength, i1, j) }
    }

    /// An upper bound of the increment of any return: that of a return that removes all of J, and of I1 the more of what cone and cut-off may remove.
    fn largest_increment(&self, i1: f64, j: f64) -> f64 {
        let multiplier = j / self.elastic.shear;
        let volume = (self.flow.volume_return * multiplier).max(i1) / (3.0 * self.elastic.bulk);
        let most = ((multiplier * multiplier) * (1.0 / 3.0) + (volume * volume) * (2.0 / 9.0)).sqrt();
        most * 1.000_000_1 + f64::MIN_POSITIVE
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::laws;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// The bracket of the iteration is the plastic strain of a return that removes all shear, with the volume of dilation or of the cut-off, and hardly more.
    #[test]
    fn the_largest_increment_removes_all_shear() {
        for law in &laws() {
            let (g, k) = (law.elastic.shear, law.elastic.bulk);
            for (i1, j) in [(-1e5, 3e4), (2e4, 3e4), (5e6, 10.0)] {
                let (shear, volume) = (j / g, f64::max(law.flow.volume_return * (j / g), i1) / (3.0 * k));
                let plastic = (shear * shear / 3.0 + 2.0 / 9.0 * volume * volume).sqrt();
                let found = law.largest_increment(i1, j);
                assert!(found > plastic && found < plastic * (1.0 + 1e-6), "{found} {plastic}");
            }
        }
    }

    /// Newton's method alone does for nearly all small increments, never over a jump, and gives what the guarded iteration gives.
    #[test]
    fn small_increments_need_no_iteration() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for law in laws().iter().filter(|l| l.surface.settled() > 0.0) {
            let (mut used, mut asked) = (0, 0);
            for _ in 0..20_000 {
                let before = law.surface.settled() * rng.random::<f64>() * rng.random::<f64>();
                let point = law.surface.point(before).expect("a surface that changes");
                let i1 = -1e5 * (0.01 + rng.random::<f64>());
                let on = point.value().kappa - point.value().alpha * i1;
                let j = on + law.elastic.shear * 10f64.powf(rng.random_range(-9.0..-3.0));
                let (full, at) = law.hardened(i1, j, before);
                asked += u32::from(j - on < 1e-6 * law.elastic.shear);
                if let Some((end, plastic)) = law.newton_return(i1, j, before, point) {
                    used += u32::from(j - on < 1e-6 * law.elastic.shear);
                    let close = |a: f64, b: f64, scale: f64| (a - b).abs() <= 2e-8 * scale.abs();
                    assert!(close(plastic - before, at - before, at - before + 1e-8 * at), "{law:?} {before}: {plastic} {at}");
                    assert!(close(end.j, full.j, j) && close(end.i1, full.i1, i1), "{end:?} {full:?}");
                    let p = &law.parameters;
                    assert!(!p.friction.ends().chain(p.cohesion.ends()).any(|end| before < end && end < plastic));
                }
            }
            assert!(used * 10 > asked * 9, "{law:?}: {used} of {asked}");
        }
    }
}
