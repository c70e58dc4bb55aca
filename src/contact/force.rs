//! The force of one contact: normal law, tangential spring with Coulomb limit, viscous and rolling parts, and the work of
//! each. A pure function; it knows neither arrays nor grains.
//!
//! Signs: `normal` points from the first end to the second; forces are those on the first end; the relative velocity is that
//! of the first end's surface against the second's; compression is positive overlap.

use super::law::{Law, Pair};
use super::pairs::Touch;
use crate::model::TangentialUnloading;

/// Relative motion of two bodies near each other.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Velocity of the first centre relative to the second (or to the wall), m/s.
    pub centres: [f64; 3],
    /// r_1 ω_1 + r_2 ω_2, m/s.
    pub turning: [f64; 3],
    /// Mean spin of the two ends, rad/s (on a wall: the grain's spin).
    pub mean_spin: [f64; 3],
    /// Spin of the first end less that of the second, rad/s.
    pub spin_difference: [f64; 3],
}

impl Motion {
    /// Σ arm × spin, with arms that end in the middle of the overlap: (r_1 − δ/2) ω_1 + (r_2 − δ/2) ω_2; on a wall (r − δ) ω.
    #[inline(always)]
    fn arms(&self, overlap: f64) -> [f64; 3] {
        std::array::from_fn(|a| self.turning[a] - overlap * self.mean_spin[a])
    }

    /// Velocity of the first surface against the second at the contact point.
    #[inline(always)]
    fn slip(&self, normal: [f64; 3], overlap: f64) -> [f64; 3] {
        let c = cross(self.arms(overlap), normal);
        [self.centres[0] + c[0], self.centres[1] + c[1], self.centres[2] + c[2]]
    }

    /// Power of a contact's force and torque on both ends, W: (t − N n) · (velocity at the contact point).
    #[inline(always)]
    pub fn power(&self, touch: &Touch) -> f64 {
        let v = self.slip(touch.normal, touch.overlap);
        dot(touch.tangential, v) - touch.normal_force * dot(touch.normal, v)
    }
}

/// Where and how two bodies touch.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// Unit vector from the first to the second end.
    pub normal: [f64; 3],
    /// Overlap, m (> 0).
    pub overlap: f64,
    /// R*, m.
    pub r_eff: f64,
    /// Reduced inertial mass, kg (viscous laws only).
    pub m_eff: f64,
    pub motion: Motion,
}

/// What does not change during one sweep.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    pub dt: f64,
    pub unloading: TangentialUnloading,
    /// Contacts per parallel task.
    pub task: usize,
}

/// What one contact keeps.
pub struct Memory<'a> {
    pub touch: &'a mut Touch,
    /// Path, slip, viscous work of this step, J.
    pub work: Option<&'a mut [f64; 3]>,
    pub rolling: Option<&'a mut [f64; 3]>,
    /// Tangential spring force (viscous laws), N.
    pub spring: Option<&'a mut [f64; 3]>,
    /// Weighted load (Hertzian contact area).
    pub load: Option<&'a mut f64>,
}

#[inline(always)]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Turns a vector of the contact plane with the contact: about the normal with the mean spin, then into the new plane,
/// keeping its length. The length is restored by the series of (|v|/|u|) about 1, which needs no root and no branch; a turn by θ in one
/// step leaves an error of θ⁴/8, and a contact that turns by more than a radian lets go.
#[inline(always)]
fn carried(v: [f64; 3], m: &Meeting, dt: f64) -> [f64; 3] {
    let n = m.normal;
    let twist = dot(m.motion.mean_spin, n) * dt;
    let c = cross(n, v);
    let mut u = [v[0] + twist * c[0], v[1] + twist * c[1], v[2] + twist * c[2]];
    let out = dot(u, n);
    u = [u[0] - out * n[0], u[1] - out * n[1], u[2] - out * n[2]];
    let s = (1.5 - 0.5 * (dot(u, u) / dot(v, v).max(f64::MIN_POSITIVE))).max(0.0);
    [u[0] * s, u[1] * s, u[2] * s]
}

/// Force, torque, history and work of a touching contact.
///
/// The tangential spring is incremental: F_t ← F_t − k_t Δu_t, turned with the contact, capped at μ F_n. Path work is the trapezium
/// ½ (F_old + F_new) · Δu of the step, torques likewise, slip the work of the capped force over the part of Δu that the spring does not take.
#[inline(always)]
pub fn touching<L: Law, const LEDGER: bool, const EXTRA: bool>(m: &Meeting, pair: &Pair, rules: &Rules, memory: Memory<'_>) {
    let n = m.normal;
    let v = m.motion.slip(n, m.overlap);
    let e = L::elastic(m.overlap, m.r_eff, pair);
    let approach = dot(v, n);
    let slip = [v[0] - approach * n[0], v[1] - approach * n[1], v[2] - approach * n[2]];

    let mut normal_force = e.force;
    let mut viscous_t = 0.0;
    if L::VISCOUS {
        let c_n = pair.viscous * (e.k_n * m.m_eff).sqrt();
        viscous_t = pair.viscous * (e.k_t * m.m_eff).sqrt();
        normal_force += c_n * approach;
    }

    let old = if L::VISCOUS { memory.spring.as_deref().copied().unwrap_or_default() } else { memory.touch.tangential };
    let mut t = carried(old, m, rules.dt);
    if EXTRA && rules.unloading == TangentialUnloading::Rescale && m.overlap < memory.touch.overlap {
        let s = e.k_t / L::elastic(memory.touch.overlap, m.r_eff, pair).k_t;
        t = [t[0] * s, t[1] * s, t[2] * s];
    }
    let spring = e.k_t * rules.dt;
    t = [t[0] - spring * slip[0], t[1] - spring * slip[1], t[2] - spring * slip[2]];
    let size2 = dot(t, t);
    let limit = pair.friction * normal_force.max(0.0);
    let mut slip_work = 0.0;
    let mut sticks = true;
    if size2 > limit * limit {
        sticks = false;
        let size = size2.sqrt();
        let s = limit / size;
        t = [t[0] * s, t[1] * s, t[2] * s];
        if LEDGER {
            slip_work = limit * (size - limit) / e.k_t;
        }
    }

    let mut viscous_work = 0.0;
    if L::VISCOUS {
        if let Some(spring) = memory.spring {
            *spring = t;
        }
        if LEDGER {
            viscous_work = (normal_force - e.force) * approach * rules.dt;
        }
        if sticks {
            let d = [-viscous_t * slip[0], -viscous_t * slip[1], -viscous_t * slip[2]];
            t = [t[0] + d[0], t[1] + d[1], t[2] + d[2]];
            if LEDGER {
                viscous_work -= dot(d, slip) * rules.dt;
            }
        }
    }
    if EXTRA && let Some(moment) = memory.rolling {
        roll(m, pair, e.k_t, normal_force, rules.dt, moment);
    }

    if EXTRA && let Some(load) = memory.load {
        let w = pair.e_eff / m.r_eff;
        *load = normal_force * (w * w);
    }
    let touch = Touch { tangential: t, normal_force, normal: n, overlap: m.overlap };
    if LEDGER && let Some(work) = memory.work {
        let power = m.motion.power(memory.touch) + (dot(t, v) - normal_force * approach);
        *work = [-0.5 * power * rules.dt, slip_work, viscous_work];
    }
    *memory.touch = touch;
}

/// Rolling resistance, elastic–plastic (the spring of Iwashita & Oda 1998 without dashpot): stiffness k_t R*², moment limit
/// μ_r R* F_n. `moment` is the moment on the first end; the second gets the opposite.
#[inline(always)]
fn roll(m: &Meeting, pair: &Pair, k_t: f64, normal_force: f64, dt: f64, moment: &mut [f64; 3]) {
    let n = m.normal;
    let carried = carried(*moment, m, dt);
    let w = m.motion.spin_difference;
    let twist = dot(w, n);
    let k = k_t * m.r_eff * m.r_eff * dt;
    let mut r = [0.0; 3];
    for a in 0..3 {
        r[a] = carried[a] - k * (w[a] - twist * n[a]);
    }
    let limit = pair.rolling * m.r_eff * normal_force.max(0.0);
    let size2 = dot(r, r);
    if size2 > limit * limit {
        let s = limit / size2.sqrt();
        r = [r[0] * s, r[1] * s, r[2] * s];
    }
    *moment = r;
}

/// Ends the contact of a pair that does not touch (any more).
#[inline(always)]
pub fn apart<const LEDGER: bool>(motion: impl Fn() -> Motion, dt: f64, memory: Memory<'_>) {
    if memory.touch.overlap > 0.0 {
        if LEDGER && let Some(work) = memory.work {
            *work = [-0.5 * motion().power(memory.touch) * dt, 0.0, 0.0];
        }
        *memory.touch = Touch::default();
        if let Some(spring) = memory.spring {
            *spring = [0.0; 3];
        }
        if let Some(load) = memory.load {
            *load = 0.0;
        }
        if let Some(moment) = memory.rolling {
            *moment = [0.0; 3];
        }
    } else if LEDGER && let Some(work) = memory.work {
        *work = [0.0; 3];
    }
}
