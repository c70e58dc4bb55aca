//! Drucker-Prager plasticity, tension positive: f = J + alpha I1 - k c <= 0 and I1 <= 3 sigma_t, with J = sqrt(J2) and I1 = tr(sigma).
//! alpha, k by the [`Cone`] and the friction angle, c cohesion, Pa; sigma_t the largest mean tension, Pa, never beyond the apex
//! k c / (3 alpha). Flow by g = J + alpha_psi I1 on the cone (psi the dilation angle), along the hydrostatic axis at the
//! cut-off, both at the corner between them; the apex is the corner with J = 0. Friction and cohesion may follow the
//! accumulated plastic strain ([`Evolution`]).
//!
//! The return is implicit: the new stress lies on the surface of the new plastic strain. In (I1, J) it has a closed form
//! where the surface stays; where it changes ([`Surface`]), one equation in the plastic strain remains.
//!
//! Holds for 0 <= psi <= phi: dissipation is then not negative. Material that was pulled apart does not remember its gap.

use super::surface::{Origin, Place, Surface, YieldParameters};
use super::{Cone, ConstitutiveLaw, Elastic, Evolution, InternalVariables, Sym, tensor};
use serde::{Deserialize, Serialize};

/// What makes a law: a law reads those of its keys ([`ConstitutiveLaw::KEYS`]).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    pub elastic: Elastic,
    pub cone: Cone,
    /// Friction angle, rad
    pub friction: Evolution,
    /// Cohesion, Pa
    pub cohesion: Evolution,
    /// Dilation angle, rad
    pub dilation: f64,
    /// Largest mean tension, Pa; infinite: up to the apex
    pub tension: f64,
}

/// The law, with what follows from its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Parameters", into = "Parameters")]
pub struct DruckerPrager {
    elastic: Elastic,
    /// Stress below this surface and below I1 = `floor_cut` is inside at any plastic strain.
    floor: YieldParameters,
    floor_cut: f64,
    /// 9 K alpha_psi: change of I1 with the plastic multiplier
    volume_return: f64,
    /// Accumulated plastic strain over the plastic multiplier on the cone, sqrt(1/3 + 2 alpha_psi²)
    per_multiplier: f64,
    /// 3 sigma_t, Pa
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
    const KEYS: &'static [&'static str] =
        &["cone", "friction_angle", "dilation_angle", "cohesion", "tension", "friction_evolution", "cohesion_evolution"];

    fn of(parameters: &Parameters) -> DruckerPrager {
        DruckerPrager::new(*parameters)
    }

    #[inline]
    fn update(&self, stress: Sym, dstrain: Sym, memory: InternalVariables) -> (Sym, InternalVariables) {
        DruckerPrager::update(self, stress, dstrain, memory)
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

    /// With the largest friction angle; none where cohesion changes as well.
    fn peak_q(&self, cell: f64, compression: bool) -> Option<f64> {
        let Evolution::Constant(cohesion) = self.parameters.cohesion else { return None };
        let cone = self.parameters.cone.at(self.parameters.friction.range().1);
        let strongest = YieldParameters { alpha: cone.alpha, kappa: cone.k * cohesion };
        Some(if compression { strongest.q_compression(cell) } else { strongest.q_extension(cell) })
    }
}

/// A returned state: invariants, Pa, and whether it lies on the cone.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Returned {
    i1: f64,
    j: f64,
    on_cone: bool,
}

impl DruckerPrager {
    /// The law of these parameters; angles within 0..pi/2, the dilation angle not above any friction angle.
    pub fn new(parameters: Parameters) -> DruckerPrager {
        let Parameters { elastic, cone, friction, cohesion, dilation, tension } = parameters;
        let alpha_psi = cone.at(dilation).alpha;
        let (least, most) = friction.range();
        let least_cohesion = cohesion.range().0;
        let surface = Surface::new(&Origin { cone, friction, cohesion });
        let (last, settled) = (surface.last(), surface.settled());
        let mut law = DruckerPrager {
            elastic,
            // k falls as the angle rises
            floor: YieldParameters { alpha: cone.at(least).alpha, kappa: cone.at(most).k * least_cohesion },
            floor_cut: 0.0,
            volume_return: 9.0 * elastic.bulk * alpha_psi,
            per_multiplier: (1.0 / 3.0 + 2.0 * (alpha_psi * alpha_psi)).sqrt(),
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

    pub fn elastic(&self) -> Elastic {
        self.elastic
    }

    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The surface at a plastic strain.
    pub fn strength(&self, plastic: f64) -> YieldParameters {
        self.surface.value(plastic)
    }

    /// Largest I1, Pa, at a plastic strain: the cut-off or the apex.
    pub fn largest_i1(&self, plastic: f64) -> f64 {
        self.cut_of(self.strength(plastic))
    }

    /// How far a stress is outside of the surface, Pa; negative inside.
    pub fn outside(&self, stress: &Sym, memory: InternalVariables) -> f64 {
        let strength = self.strength(memory.plastic);
        let i1 = tensor::trace(stress);
        let cone = tensor::j2(stress).sqrt() + strength.alpha * i1 - strength.kappa;
        cone.max(i1 - self.cut_of(strength))
    }

    /// Stress and memory after a strain increment.
    #[inline]
    pub fn update(&self, stress: Sym, dstrain: Sym, memory: InternalVariables) -> (Sym, InternalVariables) {
        let trial = self.elastic.update(stress, dstrain);
        let i1 = tensor::trace(&trial);
        let j2 = tensor::j2(&trial);
        let room = self.floor.kappa - self.floor.alpha * i1;
        if i1 <= self.floor_cut && room >= 0.0 && j2 <= room * room {
            return (trial, memory);
        }
        self.corrected(trial, i1, j2.sqrt(), memory)
    }

    #[inline(never)]
    fn corrected(&self, trial: Sym, i1: f64, j: f64, memory: InternalVariables) -> (Sym, InternalVariables) {
        let before = memory.plastic;
        let place = self.surface.place(before);
        let strength = place.map_or(self.surface.last(), |place| place.value());
        if self.inside(strength, i1, j) {
            return (trial, memory);
        }
        let (end, plastic) = match place {
            None => {
                let end = self.returned(strength, i1, j);
                (end, before + self.increment(i1, j, end))
            }
            Some(place) => self.small(i1, j, before, place).unwrap_or_else(|| self.hardened(i1, j, before)),
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
        (stress, InternalVariables { plastic })
    }

    /// The return to the cone by Newton's method, for an increment over which the surface hardly bends ([`Place::onward`]); `None` for a larger
    /// one, where the surface jumps, and at the cut-off or the apex.
    #[inline]
    fn small(&self, i1: f64, j: f64, before: f64, place: Place<'_>) -> Option<(Returned, f64)> {
        const ROUNDS: u32 = 6;
        let (mut multiplier, mut increment, mut enough) = (0.0, 0.0, None);
        let mut at = place;
        for _ in 0..ROUNDS {
            let YieldParameters { alpha, kappa } = at.value();
            let end = i1 - self.volume_return * multiplier;
            let outside = (j - self.elastic.shear * multiplier) + alpha * end - kappa;
            if outside.abs() <= *enough.get_or_insert(1e-11 * outside + 4.0 * f64::EPSILON * j) {
                let within = end <= self.cut && alpha * end < kappa;
                return within.then_some((Returned { i1: end, j: kappa - alpha * end, on_cone: true }, before + increment));
            }
            let slope = at.slope();
            let tangent = self.elastic.shear + self.volume_return * alpha - self.per_multiplier * (end * slope.alpha - slope.kappa);
            if tangent <= 0.0 {
                return None;
            }
            multiplier += outside / tangent;
            increment = self.per_multiplier * multiplier;
            at = place.onward(increment)?;
        }
        None
    }

    #[inline]
    fn cut_of(&self, strength: YieldParameters) -> f64 {
        // without friction there is no apex; of 0 / 0 `min` takes the other
        self.cut.min(strength.kappa / strength.alpha)
    }

    #[inline]
    fn inside(&self, strength: YieldParameters, i1: f64, j: f64) -> bool {
        j + strength.alpha * i1 <= strength.kappa && i1 <= self.cut_of(strength)
    }

    /// Return of a trial state to a surface that stays. The cone's return is the result unless it ends beyond the cut-off.
    #[inline]
    fn returned(&self, strength: YieldParameters, i1: f64, j: f64) -> Returned {
        let YieldParameters { alpha, kappa } = strength;
        let cut = self.cut_of(strength);
        let outside = j + alpha * i1 - kappa;
        if i1 <= cut {
            if outside <= 0.0 {
                return Returned { i1, j, on_cone: false };
            }
        } else if j <= self.corner(strength, cut) {
            return Returned { i1: cut, j, on_cone: false };
        }
        let multiplier = outside / (self.elastic.shear + self.volume_return * alpha);
        let end = i1 - self.volume_return * multiplier;
        if end > cut {
            return Returned { i1: cut, j: self.corner(strength, cut), on_cone: false };
        }
        Returned { i1: end, j: (kappa - alpha * end).max(0.0), on_cone: true }
    }

    /// J where cone and cut-off meet; without friction `cut` may be infinite.
    #[inline]
    fn corner(&self, strength: YieldParameters, cut: f64) -> f64 {
        if strength.alpha > 0.0 { (strength.kappa - strength.alpha * cut).max(0.0) } else { strength.kappa }
    }

    /// Accumulated plastic strain of a return, sqrt(2/3 de_p:de_p), with de_p = (s / 2J) (J_trial - J) / G + I (I1_trial - I1) / 9K.
    #[inline]
    fn increment(&self, i1: f64, j: f64, end: Returned) -> f64 {
        let shear = (j - end.j) / self.elastic.shear;
        let volume = (i1 - end.i1) / (3.0 * self.elastic.bulk);
        ((shear * shear) * (1.0 / 3.0) + (volume * volume) * (2.0 / 9.0)).sqrt()
    }

    /// Return to a surface that changes: finds the plastic strain e = e_before + increment(return to the surface of e) by Newton
    /// steps kept between bounds, and by halving where they do not help. A plastic strain at which the strength jumps upwards may
    /// have no such e; it is then taken just beyond the jump, with the stress between both surfaces that the plastic strain asks for.
    fn hardened(&self, i1: f64, j: f64, before: f64) -> (Returned, f64) {
        const NEWTON: u32 = 10;
        const MOST: u32 = 100;
        let mut low = before;
        let mut high = before + self.largest_increment(i1, j);
        let mut at = before;
        for round in 0..MOST {
            let place = self.surface.place(at);
            let (strength, slope) =
                place.map_or((self.surface.last(), YieldParameters::default()), |place| (place.value(), place.slope()));
            let end = self.returned(strength, i1, j);
            let increment = self.increment(i1, j, end);
            let rest = at - before - increment;
            // the stress lies on the surface of `at` in any case; this is how well `at` counts what was made
            if rest.abs() <= 1e-10 * increment + 4.0 * f64::EPSILON * at {
                return (end, at);
            }
            if rest < 0.0 {
                low = at;
            } else {
                high = at;
            }
            let tangent = if end.on_cone {
                let stiffness = self.elastic.shear + self.volume_return * strength.alpha;
                1.0 - self.per_multiplier * (end.i1 * slope.alpha - slope.kappa) / stiffness
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

    /// The state at which the plastic strain has grown by `increment`, if it lies within the surface; else the return to it.
    fn at_jump(&self, i1: f64, j: f64, increment: f64, strength: YieldParameters) -> Returned {
        let multiplier = increment / self.per_multiplier;
        let end = Returned { i1: i1 - self.volume_return * multiplier, j: j - self.elastic.shear * multiplier, on_cone: true };
        if end.j >= 0.0 && self.inside(strength, end.i1, end.j) { end } else { self.returned(strength, i1, j) }
    }

    /// No return makes more plastic strain: all of J, and the larger of what the cone and the cut-off take of I1.
    fn largest_increment(&self, i1: f64, j: f64) -> f64 {
        let multiplier = j / self.elastic.shear;
        let volume = (self.volume_return * multiplier).max(i1) / (3.0 * self.elastic.bulk);
        let most = ((multiplier * multiplier) * (1.0 / 3.0) + (volume * volume) * (2.0 / 9.0)).sqrt();
        most * 1.000_000_1 + f64::MIN_POSITIVE
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::laws;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Newton's method alone does for nearly all small increments, never over a jump, and gives what the guarded iteration gives.
    #[test]
    fn small_increments_need_no_iteration() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for law in laws().iter().filter(|l| l.surface.settled() > 0.0) {
            let (mut used, mut asked) = (0, 0);
            for _ in 0..20_000 {
                let before = law.surface.settled() * rng.random::<f64>() * rng.random::<f64>();
                let place = law.surface.place(before).expect("a surface that changes");
                let i1 = -1e5 * (0.01 + rng.random::<f64>());
                let on = place.value().kappa - place.value().alpha * i1;
                let j = on + law.elastic.shear * 10f64.powf(rng.random_range(-9.0..-3.0));
                let (full, at) = law.hardened(i1, j, before);
                asked += u32::from(j - on < 1e-6 * law.elastic.shear);
                if let Some((end, plastic)) = law.small(i1, j, before, place) {
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
