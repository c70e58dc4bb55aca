//! The parameters of the contacts between two materials, and the table of them for all materials and walls of a run.

use crate::boundary::Wall;
use crate::material::{Material, effective_modulus};
use crate::math::real::Lanes;
use crate::parameter::Values;
use pulp::Simd;

/// Reduced elastic moduli of two bodies in contact, Pa.
#[derive(Clone, Copy, Debug)]
pub struct Moduli {
    /// E*, Pa.
    pub young: f64,
    /// G*, Pa.
    pub shear: f64,
}

/// The coefficients of a law for the contacts between two materials, computed once per run.
#[derive(Clone, Copy, Debug)]
pub struct Coefficients {
    /// [`Pair::normal_stiffness`].
    pub normal: f64,
    /// [`Pair::tangential_stiffness`].
    pub tangential: f64,
    /// [`Pair::viscous`]; 0 without dashpots.
    pub viscous: f64,
    /// [`Pair::yield_overlap`]; 0 of elastic laws.
    pub yield_overlap: f64,
}

/// The function [`super::law::Law::coefficients`] of a law.
pub type CoefficientsOf = fn(Moduli, &Values, Option<&Values>) -> Coefficients;

/// Parameters of the contacts between two materials. With `R` = f64 those of one contact; with SIMD lanes those of one contact per lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair<R = f64> {
    /// Factor A of the normal force F at the overlap U, Pa. Linear law: A = 4 K_eff, F = A R* U. Hertzian laws: A = 4/3 E*, F = A √R* U^(3/2).
    pub normal_stiffness: R,
    /// Factor B of the tangential stiffness k_S, Pa. Linear law: B = 4 alpha_S K_eff, k_S = B R*. Hertzian laws: B = 8 G*, k_S = B √(R* U).
    pub tangential_stiffness: R,
    /// Coefficient of friction mu, -.
    pub friction: R,
    /// Viscous coefficient c, -: dashpots have the viscosity η = c √(S m*), with the stiffness S and the reduced mass m*.
    pub viscous: R,
    /// Coefficient of rolling friction mu_r, -.
    pub rolling: R,
    /// Reduced modulus E' of Ciantia et al. 2015 eq. (11), for the area of a Hertzian contact, Pa.
    pub e_eff: R,
    /// Overlap at which the contact begins to yield, over R*, -; 0 for laws that do not yield.
    pub yield_overlap: R,
}

impl Pair {
    /// From the coefficients of a law, the coefficients of friction and of rolling friction, and E', Pa.
    pub fn of(coefficients: &Coefficients, friction: f64, rolling: f64, e_eff: f64) -> Pair {
        let Coefficients { normal, tangential, viscous, yield_overlap } = *coefficients;
        Pair { normal_stiffness: normal, tangential_stiffness: tangential, friction, viscous, rolling, e_eff, yield_overlap }
    }

    /// The pair with `f` of each parameter.
    #[inline(always)]
    pub fn map<R>(&self, f: impl Fn(f64) -> R) -> Pair<R> {
        Pair {
            normal_stiffness: f(self.normal_stiffness),
            tangential_stiffness: f(self.tangential_stiffness),
            friction: f(self.friction),
            viscous: f(self.viscous),
            rolling: f(self.rolling),
            e_eff: f(self.e_eff),
            yield_overlap: f(self.yield_overlap),
        }
    }

    /// Contacts between two materials: the smaller friction and rolling friction of the two; everything else by the law.
    pub fn between(law: CoefficientsOf, m1: &Material, m2: &Material) -> Pair {
        let young = effective_modulus((m1.young, m1.poisson), (m2.young, m2.poisson));
        let shear = |m: &Material| m.young / (2.0 * (1.0 + m.poisson));
        let shear = 1.0 / ((2.0 - m1.poisson) / shear(m1) + (2.0 - m2.poisson) / shear(m2));
        let coefficients = law(Moduli { young, shear }, &m1.contact, Some(&m2.contact));
        Pair::of(&coefficients, m1.friction.min(m2.friction), m1.rolling_friction.min(m2.rolling_friction), young)
    }

    /// Contacts of grains of one material with a rigid wall that has its own coefficient of friction.
    pub fn on_wall(law: CoefficientsOf, m: &Material, friction: f64) -> Pair {
        let young = m.young / (1.0 - m.poisson * m.poisson);
        let shear = m.young / (2.0 * (1.0 + m.poisson)) / (2.0 - m.poisson);
        Pair::of(&law(Moduli { young, shear }, &m.contact, None), friction, m.rolling_friction, young)
    }
}

/// The parameters of all contacts of a run: of every two materials, and of every material on every wall.
#[derive(Clone, Debug)]
pub struct PairTable {
    materials: usize,
    grains: Vec<Pair>,
    walls: Vec<Pair>,
}

impl PairTable {
    /// The table of a run with these materials and walls; `friction`, where given, replaces the friction between grains (during preparation).
    pub fn new(law: CoefficientsOf, m: &[Material], walls: &[Wall], friction: Option<f64>) -> PairTable {
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

    /// Contacts of grains of material `m` with a wall: as between two materials where the wall has a material, otherwise with a rigid wall. The friction is the
    /// wall's.
    pub fn on_wall(law: CoefficientsOf, m: &Material, wall: &Wall, materials: &[Material]) -> Pair {
        match wall.material {
            Some(k) => Pair { friction: wall.friction, ..Pair::between(law, m, &materials[k as usize]) },
            None => Pair::on_wall(law, m, wall.friction),
        }
    }

    /// Number of materials.
    pub fn materials(&self) -> usize {
        self.materials
    }

    /// Parameters of the contacts of grains of two materials.
    #[inline(always)]
    pub fn grains(&self, m1: u8, m2: u8) -> &Pair {
        &self.grains[m1 as usize * self.materials + m2 as usize]
    }

    /// The parameters of one contact per SIMD lane: lane k has those of `pair(k)`.
    #[inline(always)]
    pub fn lanes<'a, S: Simd>(simd: S, pair: impl Fn(usize) -> &'a Pair) -> Pair<Lanes<S>> {
        let [normal_stiffness, tangential_stiffness, friction, viscous] = Lanes::columns(simd, |k| {
            let pair = pair(k);
            [pair.normal_stiffness, pair.tangential_stiffness, pair.friction, pair.viscous]
        });
        let [rolling, e_eff, yield_overlap, _] = Lanes::columns(simd, |k| {
            let pair = pair(k);
            [pair.rolling, pair.e_eff, pair.yield_overlap, 0.0]
        });
        Pair { normal_stiffness, tangential_stiffness, friction, viscous, rolling, e_eff, yield_overlap }
    }

    /// Whether all grains are of one material.
    pub fn is_single(&self) -> bool {
        self.materials == 1
    }

    /// Parameters of the contacts of grains of material `m` with a wall.
    #[inline(always)]
    pub fn wall(&self, wall: usize, m: u8) -> &Pair {
        &self.walls[wall * self.materials + m as usize]
    }
}
