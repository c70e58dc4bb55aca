//! Contact laws: the elastic force of one contact from its overlap. Pure functions of one contact.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `overlap` | depth of the overlap of two spheres, > 0 in contact | m |
//! | `r_eff` R* | r1 r2 / (r1 + r2); the grain's own radius on a wall | m |
//! | E*, G* | 1/E* = Σ (1 − ν²)/E; 1/G* = Σ (2 − ν)/G | Pa |
//!
//! On a wall the law is that of a mirrored identical grain (NOTES.md): R* = r, E* = E/(1 − ν²), G* = G/(2 − ν).

use crate::contact::ContactLaw;
use crate::material::Material;
use crate::material::effective_modulus;
use crate::math::real::{Lanes, Real};
use pulp::Simd;

/// Parameters of the contacts between two materials. Prefactors `a` (normal) and `b` (tangential) are per law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair<R = f64> {
    /// Linear: 4 K_eff, Pa. Hertz: 4/3 E*, Pa.
    pub a: R,
    /// Linear: 4 alpha_S K_eff, Pa. Hertz: 8 G*, Pa.
    pub b: R,
    /// Coulomb coefficient mu.
    pub friction: R,
    /// Viscous coefficient 2 sqrt(5/6) beta(restitution).
    pub viscous: R,
    /// Rolling friction mu_r.
    pub rolling: R,
    /// E' of eq. (11) for the Hertzian contact area, Pa.
    pub e_eff: R,
}

/// What a law answers for one overlap.
#[derive(Clone, Copy, Debug)]
pub struct Elastic<R = f64> {
    /// Normal force, N.
    pub force: R,
    /// Tangent normal stiffness dF/d(overlap), N/m.
    pub k_n: R,
    /// Tangential stiffness, N/m.
    pub k_t: R,
    /// Elastic energy of the normal compression, J.
    pub energy: R,
}

/// A normal law with its tangential stiffness.
pub trait Law: Copy + Send + Sync + 'static {
    /// Whether the law adds viscous forces.
    const VISCOUS: bool;
    /// Whether the dashpot may make the normal force tensile at the end of an impact.
    const TENSION: bool = true;
    /// Whether a grain's stiffness may be that of another size ([`crate::grains::Grains::stiffness_radius`]).
    const INHERITED: bool = false;
    fn elastic<R: Real>(overlap: R, r_eff: R, pair: &Pair<R>) -> Elastic<R>;
}

/// Linear law, Ciantia et al. 2015 eq. (13): k_N = 2 K_eff D1 D2/(D1 + D2) = 4 K_eff R*, F = k_N U, k_S = alpha_S k_N.
#[derive(Clone, Copy)]
pub struct Linear;

impl Law for Linear {
    const VISCOUS: bool = false;
    #[inline(always)]
    fn elastic<R: Real>(overlap: R, r_eff: R, pair: &Pair<R>) -> Elastic<R> {
        let k_n = pair.a * r_eff;
        let force = k_n * overlap;
        Elastic { force, k_n, k_t: pair.b * r_eff, energy: force * overlap * 0.5 }
    }
}

/// [`Linear`] with the stiffness that fragments have from their mothers.
#[derive(Clone, Copy)]
pub struct LinearInherited;

impl Law for LinearInherited {
    const VISCOUS: bool = false;
    const INHERITED: bool = true;
    #[inline(always)]
    fn elastic<R: Real>(overlap: R, r_eff: R, pair: &Pair<R>) -> Elastic<R> {
        Linear::elastic(overlap, r_eff, pair)
    }
}

/// Simplified Hertz–Mindlin law, Ciantia et al. 2015 eq. (14), which for equal grains is Hertz' F = 4/3 E* √R* U^{3/2} with
/// the no-slip tangential stiffness k_S = 8 G* √(R* U); written with E*, G* (Li et al. 2023 eqs 20, 21), which also hold for
/// different materials.
#[derive(Clone, Copy)]
pub struct Hertz;

impl Law for Hertz {
    const VISCOUS: bool = false;
    #[inline(always)]
    fn elastic<R: Real>(overlap: R, r_eff: R, pair: &Pair<R>) -> Elastic<R> {
        let contact_radius = (r_eff * overlap).sqrt();
        let force = pair.a * contact_radius * overlap;
        Elastic { force, k_n: pair.a * 1.5 * contact_radius, k_t: pair.b * contact_radius, energy: force * 0.4 * overlap }
    }
}

/// Hertz–Mindlin with viscous damping, Li et al. 2023 eqs (18)–(21); spring and dashpot together slide (eq. 19). The damping constants are those of Tsuji's form,
/// η = 2 √(5/6) β √(S m*), S_n = 2 E* √(R* U), S_t = 8 G* √(R* U), with β = −ln e / √(π² + ln² e): the restitution is exactly e when
/// the force may turn tensile at the end of an impact, and so it may here.
#[derive(Clone, Copy)]
pub struct HertzViscous;

impl Law for HertzViscous {
    const VISCOUS: bool = true;
    #[inline(always)]
    fn elastic<R: Real>(overlap: R, r_eff: R, pair: &Pair<R>) -> Elastic<R> {
        Hertz::elastic(overlap, r_eff, pair)
    }
}

/// [`HertzViscous`] whose normal force ends where it would turn tensile. The impulse of a sliding contact is then exactly μ (1 + e) m* v, and the damping for a
/// restitution e is that of [`viscous_coefficient_without_tension`].
#[derive(Clone, Copy)]
pub struct HertzViscousNoTension;

impl Law for HertzViscousNoTension {
    const VISCOUS: bool = true;
    const TENSION: bool = false;
    #[inline(always)]
    fn elastic<R: Real>(overlap: R, r_eff: R, pair: &Pair<R>) -> Elastic<R> {
        Hertz::elastic(overlap, r_eff, pair)
    }
}

/// Viscous coefficient c of η = c √(S_n m*) that gives the restitution e in (0, 1] where the force ends at zero.
///
/// With z = δ^{5/4} Hertz's contact with Tsuji's damping is a linear oscillator of damping ratio ζ = √0.3 c (Antypov & Elliott 2011). That one leaves contact
/// where its acceleration is zero, at the time t of tan(ω t) = −2 ζ ω / (1 − 2 ζ²), ω² = 1 − ζ², and with the speed e = exp(−ζ t) (Schwager & Pöschel 2007).
pub fn viscous_coefficient_without_tension(restitution: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1e6);
    // the root by halving: e falls with ζ
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if restitution_without_tension(middle) > restitution { low = middle } else { high = middle }
    }
    low / 0.3f64.sqrt()
}

/// Restitution of a damping ratio ζ where the force ends at zero.
fn restitution_without_tension(zeta: f64) -> f64 {
    let difference = 1.0 - zeta * zeta;
    let omega = difference.abs().sqrt();
    let (sine, cosine) = (2.0 * zeta * omega, 1.0 - 2.0 * zeta * zeta);
    let time = match omega {
        // the limit of both
        omega if omega < 1e-6 => 2.0,
        omega if difference > 0.0 => sine.atan2(-cosine) / omega,
        omega => (sine / -cosine).atanh() / omega,
    };
    (-zeta * time).exp()
}

/// Viscous coefficient 2 √(5/6) β of a restitution e in (0, 1].
pub fn viscous_coefficient(restitution: f64) -> f64 {
    let l = restitution.ln();
    let beta = -l / (std::f64::consts::PI.powi(2) + l * l).sqrt();
    2.0 * (5.0f64 / 6.0).sqrt() * beta
}

impl Pair {
    /// Each parameter by itself.
    #[inline(always)]
    pub fn map<R>(&self, f: impl Fn(f64) -> R) -> Pair<R> {
        let Pair { a, b, friction, viscous, rolling, e_eff } = *self;
        Pair { a: f(a), b: f(b), friction: f(friction), viscous: f(viscous), rolling: f(rolling), e_eff: f(e_eff) }
    }

    /// Overlap, m, at which a contact bears the force `force`, N.
    pub fn depth(&self, law: ContactLaw, r_eff: f64, force: f64) -> f64 {
        match law {
            ContactLaw::Linear | ContactLaw::LinearInherited => force / (self.a * r_eff),
            ContactLaw::Hertz | ContactLaw::HertzViscous | ContactLaw::HertzViscousNoTension => {
                (force / (self.a * r_eff.sqrt())).cbrt().powi(2)
            }
        }
    }

    /// Between two materials.
    pub fn between(law: ContactLaw, m1: &Material, m2: &Material) -> Pair {
        let e_eff = effective_modulus((m1.young, m1.poisson), (m2.young, m2.poisson));
        let shear = |m: &Material| m.young / (2.0 * (1.0 + m.poisson));
        let g_eff = 1.0 / ((2.0 - m1.poisson) / shear(m1) + (2.0 - m2.poisson) / shear(m2));
        let k_eff = 2.0 / (1.0 / m1.k_eff + 1.0 / m2.k_eff);
        let alpha = 0.5 * (m1.alpha_s + m2.alpha_s);
        Pair::new(law, e_eff, g_eff, k_eff, alpha, m1, m2)
    }

    /// A grain of one material on a rigid wall with its own friction coefficient.
    pub fn on_wall(law: ContactLaw, m: &Material, friction: f64) -> Pair {
        let e_eff = m.young / (1.0 - m.poisson * m.poisson);
        let g_eff = m.young / (2.0 * (1.0 + m.poisson)) / (2.0 - m.poisson);
        Pair { friction, ..Pair::new(law, e_eff, g_eff, m.k_eff, m.alpha_s, m, m) }
    }

    fn new(law: ContactLaw, e_eff: f64, g_eff: f64, k_eff: f64, alpha: f64, m1: &Material, m2: &Material) -> Pair {
        let (a, b) = match law {
            ContactLaw::Linear | ContactLaw::LinearInherited => (4.0 * k_eff, 4.0 * alpha * k_eff),
            ContactLaw::Hertz | ContactLaw::HertzViscous | ContactLaw::HertzViscousNoTension => (4.0 / 3.0 * e_eff, 8.0 * g_eff),
        };
        let restitution = (m1.restitution * m2.restitution).sqrt();
        Pair {
            a,
            b,
            friction: m1.friction.min(m2.friction),
            viscous: if law == ContactLaw::HertzViscousNoTension {
                viscous_coefficient_without_tension(restitution)
            } else {
                viscous_coefficient(restitution)
            },
            rolling: m1.rolling_friction.min(m2.rolling_friction),
            e_eff,
        }
    }
}

/// All pairs of a run: between materials, and of each material on each wall.
#[derive(Clone, Debug)]
pub struct PairTable {
    materials: usize,
    grains: Vec<Pair>,
    walls: Vec<Pair>,
}

impl PairTable {
    /// `friction` replaces the friction between grains during preparation.
    pub fn new(law: ContactLaw, m: &[Material], walls: &[crate::boundary::Wall], friction: Option<f64>) -> PairTable {
        let mut grains = Vec::with_capacity(m.len() * m.len());
        for m1 in m {
            for m2 in m {
                let mut pair = Pair::between(law, m1, m2);
                pair.friction = friction.unwrap_or(pair.friction);
                grains.push(pair);
            }
        }
        let mut on_walls = Vec::with_capacity(walls.len() * m.len());
        for w in walls {
            for m1 in m {
                on_walls.push(PairTable::on_wall(law, m1, w, m));
            }
        }
        PairTable { materials: m.len(), grains, walls: on_walls }
    }

    /// A grain of material `m` on a wall.
    pub fn on_wall(law: ContactLaw, m: &Material, wall: &crate::boundary::Wall, materials: &[Material]) -> Pair {
        match wall.material {
            Some(k) => Pair { friction: wall.friction, ..Pair::between(law, m, &materials[k as usize]) },
            None => Pair::on_wall(law, m, wall.friction),
        }
    }

    /// Number of materials.
    pub fn materials(&self) -> usize {
        self.materials
    }

    #[inline(always)]
    pub fn grains(&self, m1: u8, m2: u8) -> &Pair {
        &self.grains[m1 as usize * self.materials + m2 as usize]
    }

    /// The parameters of a pair in each lane.
    #[inline(always)]
    pub fn lanes<'a, S: Simd>(simd: S, pair: impl Fn(usize) -> &'a Pair) -> Pair<Lanes<S>> {
        let [a, b, friction, viscous] = Lanes::columns(simd, |k| [pair(k).a, pair(k).b, pair(k).friction, pair(k).viscous]);
        let [rolling, e_eff, ..] = Lanes::columns(simd, |k| [pair(k).rolling, pair(k).e_eff, 0.0, 0.0]);
        Pair { a, b, friction, viscous, rolling, e_eff }
    }

    /// Whether all grains are of one material.
    pub fn is_single(&self) -> bool {
        self.materials == 1
    }

    #[inline(always)]
    pub fn wall(&self, wall: usize, m: u8) -> &Pair {
        &self.walls[wall * self.materials + m as usize]
    }
}

/// Calls `$body` with `$L` bound to the law type: the one match over laws.
#[macro_export]
macro_rules! with_law {
    ($law:expr, $L:ident => $body:expr) => {
        match $law {
            $crate::contact::ContactLaw::Linear => {
                type $L = $crate::contact::law::Linear;
                $body
            }
            $crate::contact::ContactLaw::LinearInherited => {
                type $L = $crate::contact::law::LinearInherited;
                $body
            }
            $crate::contact::ContactLaw::Hertz => {
                type $L = $crate::contact::law::Hertz;
                $body
            }
            $crate::contact::ContactLaw::HertzViscous => {
                type $L = $crate::contact::law::HertzViscous;
                $body
            }
            $crate::contact::ContactLaw::HertzViscousNoTension => {
                type $L = $crate::contact::law::HertzViscousNoTension;
                $body
            }
        }
    };
}
