//! The force of one contact, or of several side by side: normal law, tangential spring with Coulomb limit, viscous and rolling parts,
//! and the work of each. Pure functions of numbers ([`Real`]); they know neither arrays nor grains.
//!
//! Signs: `normal` points from the first end to the second; forces are those on the first end; the relative velocity is that
//! of the first end's surface against the second's; compression is positive overlap.

use super::law::Law;
use super::pair::Pair;
use super::pairs::ContactForce;
use super::unloading::TangentialUnloading;
use crate::math::real::Real;
use crate::math::vector::{cross, dot, less, plus, scaled};

/// Relative motion of two bodies near each other.
#[derive(Clone, Copy, Debug, Default)]
pub struct RelativeMotion<R = f64> {
    /// Velocity of the first centre relative to the second (or to the wall), m/s.
    pub centres: [R; 3],
    /// r_1 ω_1 + r_2 ω_2, m/s.
    pub turning: [R; 3],
    /// Mean spin of the two ends, rad/s (on a wall: the grain's spin).
    pub mean_spin: [R; 3],
    /// Spin of the first end less that of the second, rad/s.
    pub spin_difference: [R; 3],
}

impl<R: Real> RelativeMotion<R> {
    /// Σ arm × spin, with arms that end in the middle of the overlap: (r_1 − δ/2) ω_1 + (r_2 − δ/2) ω_2; on a wall (r − δ) ω.
    #[inline(always)]
    fn arms(&self, overlap: R) -> [R; 3] {
        less(self.turning, scaled(self.mean_spin, overlap))
    }

    /// Velocity of the first surface against the second at the contact point.
    #[inline(always)]
    fn slip(&self, normal: [R; 3], overlap: R) -> [R; 3] {
        plus(self.centres, cross(self.arms(overlap), normal))
    }

    /// Power of a contact's force and torque on both ends, W: (t − N n) · (velocity at the contact point).
    #[inline(always)]
    pub fn power(&self, touch: &ContactForce<R>) -> R {
        let v = self.slip(touch.normal, touch.overlap);
        dot(touch.tangential, v) - touch.normal_force * dot(touch.normal, v)
    }
}

/// Where and how two bodies touch.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactGeometry<R = f64> {
    /// Unit vector from the first to the second end.
    pub normal: [R; 3],
    /// Overlap, m (> 0).
    pub overlap: R,
    /// R*, m.
    pub r_eff: R,
    /// Reduced inertial mass, kg (viscous laws only).
    pub m_eff: R,
    pub motion: RelativeMotion<R>,
}

/// What does not change during one sweep.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    pub dt: f64,
    pub unloading: TangentialUnloading,
    /// Contacts per parallel task.
    pub task: usize,
    /// The instruction set in use.
    pub arch: pulp::Arch,
}

/// What a contact has kept from the last step, or leaves to the next. `None`: the run does not keep it.
#[derive(Clone, Copy)]
pub struct ContactHistory<R = f64> {
    pub touch: ContactForce<R>,
    /// Tangential spring force (viscous laws), N.
    pub spring: Option<[R; 3]>,
    pub rolling: Option<[R; 3]>,
    /// Weighted load (Hertzian contact area).
    pub load: Option<R>,
    /// Largest overlap so far (laws that yield), m.
    pub largest: Option<R>,
    /// Path, slip, viscous work of this step, J; the third is what yielding takes of laws that yield.
    pub work: Option<[R; 3]>,
}

/// Turns a vector of the contact plane with the contact: about the normal with the mean spin, then into the new plane,
/// keeping its length. The length is restored by the series of (|v|/|u|) about 1, which needs no root and no branch; a turn by θ in one
/// step leaves an error of θ⁴/8, and a contact that turns by more than a radian lets go.
#[inline(always)]
fn carried<R: Real>(v: [R; 3], m: &ContactGeometry<R>, dt: f64) -> [R; 3] {
    let n = m.normal;
    let twist = dot(m.motion.mean_spin, n) * dt;
    let u = plus(v, scaled(cross(n, v), twist));
    let u = less(u, scaled(n, dot(u, n)));
    let ratio = dot(u, u) / dot(v, v).at_least(f64::MIN_POSITIVE);
    scaled(u, (ratio.constant(1.5) - ratio * 0.5).at_least(0.0))
}

/// Shortens a vector to a length, where it is longer: the vector, where it was, and its length before (where it was).
#[inline(always)]
fn capped<R: Real>(v: [R; 3], limit: R) -> ([R; 3], R::Mask, R) {
    let size2 = dot(v, v);
    let longer = size2.above(limit * limit);
    if R::may_skip(longer) {
        return (v, longer, limit);
    }
    let size = size2.sqrt();
    (scaled(v, (limit / size).where_else(longer, size.constant(1.0))), longer, size)
}

/// Force, history and work of a touching contact.
///
/// The tangential spring is incremental: F_t ← F_t − k_t Δu_t, turned with the contact, capped at μ F_n. Path work is the trapezium
/// ½ (F_old + F_new) · Δu of the step, torques likewise, slip the work of the capped force over the part of Δu that the spring does not take.
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
    // an overlap rises above what it has been, or the contact unloads or loads again
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

    let mut spring = carried(old.spring.unwrap_or(old.touch.tangential), m, dt);
    if EXTRA && rules.unloading == TangentialUnloading::Rescale {
        // a contact that begins has no tangential force to rescale
        let past = old.touch.overlap;
        let s = e.k_t / L::elastic(past, if L::PLASTIC { before } else { past }, m.r_eff, pair).k_t;
        spring = scaled(spring, s.where_else(past.above(m.overlap), s.constant(1.0)));
    }
    spring = less(spring, scaled(slip, e.k_t * dt));
    let limit = pair.friction * normal_force.at_least(0.0);
    let (spring, slides, size) = capped(spring, limit);

    let mut t = spring;
    let mut taken = none;
    if L::VISCOUS {
        // spring and dashpot together have the limit (Li et al. 2023, eq. 19); where the spring has it, it has all
        let d = scaled(slip, -(pair.viscous * (e.k_t * m.m_eff).sqrt()));
        let damped = capped(plus(spring, d), limit).0;
        t = std::array::from_fn(|a| spring[a].where_else(slides, damped[a]));
        if LEDGER {
            taken = ((normal_force - e.force) * approach - dot(less(t, spring), slip)) * dt;
        }
    }
    if L::PLASTIC && LEDGER {
        taken = L::dissipated(largest, m.r_eff, pair) - L::dissipated(before, m.r_eff, pair);
    }
    let touch = ContactForce { tangential: t, normal_force, normal: n, overlap: m.overlap };
    let weight = pair.e_eff / m.r_eff;
    ContactHistory {
        touch,
        spring: old.spring.map(|_| spring),
        rolling: if EXTRA { old.rolling.map(|moment| rolled(m, pair, e.k_t, normal_force, dt, moment)) } else { None },
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

/// Rolling resistance, elastic–plastic (the spring of Iwashita & Oda 1998 without dashpot): stiffness k_t R*², moment limit
/// μ_r R* F_n. `moment` is the moment on the first end; the second gets the opposite.
#[inline(always)]
fn rolled<R: Real>(m: &ContactGeometry<R>, pair: &Pair<R>, k_t: R, normal_force: R, dt: f64, moment: [R; 3]) -> [R; 3] {
    let n = m.normal;
    let w = m.motion.spin_difference;
    let bending = less(w, scaled(n, dot(w, n)));
    let k = k_t * m.r_eff * m.r_eff * dt;
    let moment = less(carried(moment, m, dt), scaled(bending, k));
    capped(moment, pair.rolling * m.r_eff * normal_force.at_least(0.0)).0
}

/// What is left of a pair that does not touch (any more).
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
        let rules = Rules { dt: 1e-5, unloading: TangentialUnloading::Keep, task: 1, arch: pulp::Arch::Scalar };
        let mut touch = ContactForce::default();
        for slip in [0.3, 3.0, 1e-7] {
            let motion = RelativeMotion { centres: [slip, 0.0, 0.0], turning: none, mean_spin: none, spin_difference: none };
            let meeting = ContactGeometry { normal: [0.0, 0.0, 1.0], overlap: 1e-5, r_eff: 0.01, m_eff: 0.03, motion };
            let old = ContactHistory {
                touch: ContactForce::default(),
                spring: Some(none),
                rolling: None,
                load: None,
                largest: None,
                work: Some(none),
            };
            let new = touching::<f64, HertzViscous, true, true>(&meeting, &pair, &rules, &old);
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
