//! The force of one contact: normal force, tangential spring with Coulomb's limit, viscous and rolling parts, and the work of each. Functions of numbers alone,
//! with no arrays and no grains; a number ([`Real`]) is one f64, or one per SIMD lane, which makes as many contacts at once.
//!
//! Signs: the two bodies in contact are its first and its second end. `normal` points from the first to the second; forces are those on the first end;
//! relative velocities are those of the first end less those of the second; the overlap is positive in contact.

use super::law::Law;
use super::pair::Pair;
use super::pairs::ContactForce;
use super::unloading::TangentialUnloading;
use crate::math::real::Real;
use crate::math::vector::{cross, dot, less, plus, scaled};

/// Relative motion of the two ends of a contact.
#[derive(Clone, Copy, Debug, Default)]
pub struct RelativeMotion<R = f64> {
    /// Velocity of the first centre less that of the second, or that of the wall, m/s.
    pub centres: [R; 3],
    /// Sum of radius times spin of both ends, r_1 ω_1 + r_2 ω_2, m/s; a wall adds nothing.
    pub turning: [R; 3],
    /// Mean of the spins of both ends, rad/s; on a wall the grain's spin.
    pub mean_spin: [R; 3],
    /// Spin of the first end less that of the second, rad/s; on a wall the grain's spin.
    pub spin_difference: [R; 3],
}

impl<R: Real> RelativeMotion<R> {
    /// Sum of arm times spin of both ends, m/s. The contact point lies in the middle of the overlap δ: (r_1 − δ/2) ω_1 + (r_2 − δ/2) ω_2; on a wall, which
    /// does not deform, (r − δ) ω.
    #[inline(always)]
    fn arms(&self, overlap: R) -> [R; 3] {
        less(self.turning, scaled(self.mean_spin, overlap))
    }

    /// Velocity of the first end less that of the second at the contact point, m/s.
    #[inline(always)]
    fn slip(&self, normal: [R; 3], overlap: R) -> [R; 3] {
        plus(self.centres, cross(self.arms(overlap), normal))
    }

    /// Power that the force of the contact gives to both ends together, W: (t − N n) · v, with the tangential force t, the normal force N and the relative
    /// velocity v at the contact point.
    #[inline(always)]
    pub fn power(&self, touch: &ContactForce<R>) -> R {
        let v = self.slip(touch.normal, touch.overlap);
        dot(touch.tangential, v) - touch.normal_force * dot(touch.normal, v)
    }
}

/// Geometry of a contact, and the relative motion of its ends.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactGeometry<R = f64> {
    /// Unit vector from the first to the second end.
    pub normal: [R; 3],
    /// Overlap, m, above 0.
    pub overlap: R,
    /// Reduced radius R* = r_1 r_2/(r_1 + r_2), m; on a wall the grain's radius.
    pub r_eff: R,
    /// Reduced mass m* = m_1 m_2/(m_1 + m_2), kg, of the inertial masses; only viscous laws read it.
    pub m_eff: R,
    /// Relative motion of the ends.
    pub motion: RelativeMotion<R>,
}

/// What is the same for all contacts of a sweep.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Time step, s.
    pub dt: f64,
    /// What happens to the tangential force when the normal force falls.
    pub unloading: TangentialUnloading,
    /// Whether weighted loads go with R* of the contact ([`crate::breakage::criterion::FailureCriterion::weighs_radius`]).
    pub weighs_radius: bool,
    /// Contacts per parallel task.
    pub task: usize,
    /// The instruction set in use.
    pub arch: pulp::Arch,
}

/// What a contact keeps from one step to the next. `None`: the run does not keep it.
#[derive(Clone, Copy)]
pub struct ContactHistory<R = f64> {
    /// Force and geometry; all zero while the ends are apart.
    pub touch: ContactForce<R>,
    /// Force of the tangential spring on the first end, N; kept for viscous laws, whose tangential force has a viscous part as well.
    pub spring: Option<[R; 3]>,
    /// Rolling moment on the first end, N m; kept with rolling friction.
    pub rolling: Option<[R; 3]>,
    /// Normal force times the weight of the failure criterion ([`crate::breakage::criterion::FailureCriterion::load_weight`]); kept where the weight is not 1.
    pub load: Option<R>,
    /// Largest overlap that the contact has had, m; kept for laws that yield.
    pub largest: Option<R>,
    /// Work of this step, J: the work of the contact's force against the motion of both ends, the part of it lost in slip, and the part lost in dashpots or,
    /// for laws that yield, in yielding. Kept with the energy ledger.
    pub work: Option<[R; 3]>,
}

/// Rotates a vector in the plane of the contact with the contact: about the normal by the mean spin of the ends, then into the new plane. The length stays the
/// same up to 3 θ⁴/8 for a rotation by the angle θ in this step: it is restored with the first two terms of the series of |v|/|u| about 1, which needs neither a
/// root nor a branch. A vector that would turn about the normal by more than 1.4 rad in one
/// step becomes zero.
#[inline(always)]
fn rotate_with_contact<R: Real>(v: [R; 3], m: &ContactGeometry<R>, dt: f64) -> [R; 3] {
    let n = m.normal;
    let twist = dot(m.motion.mean_spin, n) * dt;
    let u = plus(v, scaled(cross(n, v), twist));
    let u = less(u, scaled(n, dot(u, n)));
    let ratio = dot(u, u) / dot(v, v).at_least(f64::MIN_POSITIVE);
    scaled(u, (ratio.constant(1.5) - ratio * 0.5).at_least(0.0))
}

/// Shortens the vector `v` to the length `limit` where it is longer. Returns the vector, whether it was longer, and its length before where it was.
#[inline(always)]
fn limit_length<R: Real>(v: [R; 3], limit: R) -> ([R; 3], R::Mask, R) {
    let size2 = dot(v, v);
    let longer = size2.above(limit * limit);
    if R::may_skip(longer) {
        return (v, longer, limit);
    }
    let size = size2.sqrt();
    (scaled(v, (limit / size).where_else(longer, size.constant(1.0))), longer, size)
}

/// Force, history and work of a contact whose ends overlap. `LEDGER`: the run keeps the works of contacts. `EXTRA`: the run may have rolling friction, weighted
/// loads, or tangential forces that fall with the normal force.
///
/// The tangential spring is incremental: it turns with the contact, grows by −k_t times the tangential displacement of the step, and is at most μ F_n. The
/// work of the step is the mean of the old and the new force times the displacement of the contact point. The work of slip is the limiting force times that
/// part of the displacement that the spring does not take up.
#[inline(always)]
pub fn touching<R: Real, L: Law, const LEDGER: bool, const EXTRA: bool>(
    m: &ContactGeometry<R>,
    pair: &Pair<R>,
    rules: &Rules,
    old: &ContactHistory<R>,
) -> ContactHistory<R> {
    let n = m.normal;
    let dt = rules.dt;
    let v = m.motion.slip(n, m.overlap);
    // first loading where the overlap is the largest so far; otherwise unloading or reloading
    let before = old.largest.unwrap_or(m.overlap);
    let largest = m.overlap.where_else(m.overlap.above(before), before);
    let e = L::elastic(m.overlap, largest, m.r_eff, pair);
    let approach = dot(v, n);
    let slip = less(v, scaled(n, approach));
    let none = approach.constant(0.0);

    let mut normal_force = e.force;
    if L::VISCOUS {
        normal_force = normal_force + pair.viscous * (e.k_n * m.m_eff).sqrt() * approach;
        if !L::TENSION {
            normal_force = normal_force.at_least(0.0);
        }
    }

    let mut spring = rotate_with_contact(old.spring.unwrap_or(old.touch.tangential), m, dt);
    if EXTRA && rules.unloading == TangentialUnloading::Rescale {
        // a contact that begins has no tangential force to rescale
        let past = old.touch.overlap;
        let s = e.k_t / L::elastic(past, if L::PLASTIC { before } else { past }, m.r_eff, pair).k_t;
        spring = scaled(spring, s.where_else(past.above(m.overlap), s.constant(1.0)));
    }
    spring = less(spring, scaled(slip, e.k_t * dt));
    let limit = pair.friction * normal_force.at_least(0.0);
    let (spring, slides, size) = limit_length(spring, limit);

    let mut t = spring;
    let mut taken = none;
    if L::VISCOUS {
        // the limit is that of spring and dashpot together (Li et al. 2023, eq. 19); where the spring alone reaches it, the dashpot adds nothing
        let d = scaled(slip, -(pair.viscous * (e.k_t * m.m_eff).sqrt()));
        let damped = limit_length(plus(spring, d), limit).0;
        t = std::array::from_fn(|a| spring[a].where_else(slides, damped[a]));
        if LEDGER {
            taken = ((normal_force - e.force) * approach - dot(less(t, spring), slip)) * dt;
        }
    }
    if L::PLASTIC && LEDGER {
        taken = L::dissipated(largest, m.r_eff, pair) - L::dissipated(before, m.r_eff, pair);
    }
    let touch = ContactForce { tangential: t, normal_force, normal: n, overlap: m.overlap };
    let weight = if rules.weighs_radius { pair.e_eff / m.r_eff } else { pair.e_eff };
    ContactHistory {
        touch,
        spring: old.spring.map(|_| spring),
        rolling: if EXTRA { old.rolling.map(|moment| rolling_moment(m, pair, e.k_t, normal_force, dt, moment)) } else { None },
        load: if EXTRA { old.load.map(|_| normal_force * (weight * weight)) } else { None },
        largest: if L::PLASTIC { Some(largest) } else { None },
        work: if LEDGER {
            let power = m.motion.power(&old.touch) + (dot(t, v) - normal_force * approach);
            let slip_work = limit * (size - limit) / e.k_t;
            Some([power * -0.5 * dt, slip_work.where_else(slides, none), taken])
        } else {
            None
        },
    }
}

/// The new rolling moment on the first end, N m; the second end gets the opposite. An elastic–plastic spring (Iwashita & Oda 1998, without their dashpot) that
/// resists the relative rotation about axes in the plane of the contact: stiffness k_t R*², limit μ_r R* F_n. `moment`: that of the last step.
#[inline(always)]
fn rolling_moment<R: Real>(m: &ContactGeometry<R>, pair: &Pair<R>, k_t: R, normal_force: R, dt: f64, moment: [R; 3]) -> [R; 3] {
    let n = m.normal;
    let w = m.motion.spin_difference;
    let bending = less(w, scaled(n, dot(w, n)));
    let k = k_t * m.r_eff * m.r_eff * dt;
    let moment = less(rotate_with_contact(moment, m, dt), scaled(bending, k));
    limit_length(moment, pair.rolling * m.r_eff * normal_force.at_least(0.0)).0
}

/// The history of a pair whose ends do not overlap: empty, with the last work of a contact that has ended in this step.
#[inline(always)]
pub fn apart<const LEDGER: bool>(motion: impl Fn() -> RelativeMotion, dt: f64, old: &ContactHistory) -> ContactHistory {
    let ended = old.touch.overlap > 0.0;
    let path = if LEDGER && ended { -0.5 * motion().power(&old.touch) * dt } else { 0.0 };
    ContactHistory {
        touch: ContactForce::default(),
        spring: old.spring.map(|_| [0.0; 3]),
        rolling: old.rolling.map(|_| [0.0; 3]),
        load: old.load.map(|_| 0.0),
        largest: old.largest.map(|_| 0.0),
        work: LEDGER.then_some([path, 0.0, 0.0]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::law::{Coefficients, HertzViscous, viscous_coefficient};

    /// The dashpot alone, in the first step of a contact that slips fast, would be many times the limit (Li et al. 2023, eq. 19).
    #[test]
    fn spring_and_dashpot_together_slide() {
        let none = [0.0; 3];
        let viscous = viscous_coefficient(0.3);
        let pair = Pair::of(&Coefficients { normal: 4.4e7, tangential: 1e8, viscous, yield_overlap: 0.0 }, 0.3, 0.0, 0.0);
        let rules =
            Rules { dt: 1e-5, unloading: TangentialUnloading::Keep, weighs_radius: true, task: 1, arch: pulp::Arch::Scalar };
        let mut touch = ContactForce::default();
        for slip in [0.3, 3.0, 1e-7] {
            let motion = RelativeMotion { centres: [slip, 0.0, 0.0], turning: none, mean_spin: none, spin_difference: none };
            let geometry = ContactGeometry { normal: [0.0, 0.0, 1.0], overlap: 1e-5, r_eff: 0.01, m_eff: 0.03, motion };
            let old = ContactHistory {
                touch: ContactForce::default(),
                spring: Some(none),
                rolling: None,
                load: None,
                largest: None,
                work: Some(none),
            };
            let new = touching::<f64, HertzViscous, true, true>(&geometry, &pair, &rules, &old);
            touch = new.touch;
            let (size, limit) = (dot(touch.tangential, touch.tangential).sqrt(), 0.3 * touch.normal_force);
            if slip > 1e-3 {
                assert!((size / limit - 1.0).abs() < 1e-12 && touch.tangential[0] < 0.0, "{size} of {limit} N");
            }
            // what the dashpot takes is never negative
            assert!(new.work.is_some_and(|[_, _, viscous]| viscous >= 0.0));
        }
        assert!(dot(touch.tangential, touch.tangential).sqrt() < 0.3 * touch.normal_force, "it holds");
    }
}
