//! Gives the engine a contact law that the engine does not have, and runs the engine's own time
//! step with this law.
//!
//! The law is that of a blunt cone pressed into a plane (Sneddon 1965, Int. J. Eng. Sci. 3, 47): the force grows with the
//! square of the overlap, F = c δ² with c = 2 E*/(π tan β), where β is the angle between cone and plane. Two spheres meet
//! head-on; prints the largest overlap and the duration of the impact with this law and with Hertz's, each beside its closed
//! form. With F = c δⁿ, the reduced mass m* and the relative speed v
//!
//! ```text
//! δ_max = ((n + 1) m* v²/(2 c))^(1/(n + 1))        T = 2 √π Γ(1 + 1/(n + 1))/Γ(1/2 + 1/(n + 1)) δ_max/v
//! ```
//!
//! Fails if an overlap or a duration differs from its closed form by more than 0.1 %.
//!
//! ```text
//! cargo run --release --example custom_contact_law
//! ```

use comminute::contact::law::{Coefficients, Elastic, Law, Moduli};
use comminute::contact::pair::Pair;
use comminute::contact::registry::LawTable;
use comminute::math::real::Real;
use comminute::parameter::{Parameter, Range, Values};
use comminute::{ContactLaw, Grains, Material, Physics, State, Stepping, Workspace, step};
use std::convert::Infallible;
use std::f64::consts::PI;

/// Conical contact: F = c δ², energy c δ³/3.
#[derive(Clone, Copy)]
struct Cone;

impl Law for Cone {
    /// False: the area of contact is not that of Hertz's theory.
    const HERTZIAN: bool = false;

    /// Parameters that the law needs of a material besides its elastic moduli;
    /// [`Material::contact`] holds the values in this order.
    const PARAMETERS: &'static [Parameter] = &[Parameter {
        key: "contact.cone_slope",
        range: Range::POSITIVE,
        default: None,
        meaning: "tangent of the angle between the cone and the plane",
    }];

    /// Coefficients of a pair of materials, made once: c for the normal force and 16 G*/(π tan β)
    /// for the tangential one, as a contact of radius a = 2 δ/(π tan β) has the tangential
    /// stiffness 8 G* a. tan β is the mean of the two materials.
    fn coefficients(moduli: Moduli, first: &Values, second: Option<&Values>) -> Coefficients {
        let slope = second.map_or(first[0], |second| 0.5 * (first[0] + second[0]));
        Coefficients {
            normal: 2.0 * moduli.young / (PI * slope),
            tangential: 16.0 * moduli.shear / (PI * slope),
            viscous: 0.0,
            yield_overlap: 0.0,
        }
    }

    /// Force, stiffnesses and energy of a contact, evaluated in every step. `R` stands for one
    /// number or for several that are computed side by side.
    #[inline(always)]
    fn elastic<R: Real>(overlap: R, _largest: R, _r_eff: R, pair: &Pair<R>) -> Elastic<R> {
        let secant = pair.normal_stiffness * overlap;
        let force = secant * overlap;
        Elastic { force, k_n: secant * 2.0, k_t: pair.tangential_stiffness * overlap, energy: force * overlap * (1.0 / 3.0) }
    }

    fn overlap_under(force: f64, _r_eff: f64, pair: &Pair) -> f64 {
        (force / pair.normal_stiffness).sqrt()
    }
}

/// The functions of the law, compiled for the loops of the engine.
static CONE: LawTable = LawTable::of::<Cone>();

/// Radius of both spheres, m, and their relative speed, m/s.
const RADIUS: f64 = 0.005;
const SPEED: f64 = 2.0;

fn main() {
    let material = Material {
        name: "glass".into(),
        density: 2500.0,
        internal_porosity: 0.0,
        young: 50e9,
        poisson: 0.2,
        friction: 0.3,
        rolling_friction: 0.0,
        interface_friction: None,
        contact: [0.1, 0.0, 0.0, 0.0],
    };
    let mass = 0.5 * material.density * 4.0 / 3.0 * PI * RADIUS.powi(3);
    // 2 √π Γ(1 + 1/(n + 1))/Γ(1/2 + 1/(n + 1)) of n = 2 and n = 3/2
    let laws = [
        ("cone, F = c δ²", ContactLaw::Custom(&CONE), 2.0, 2.804_364_2),
        ("Hertz, F = c δ^1.5", ContactLaw::Hertz, 1.5, 2.943_275_1),
    ];
    println!("law                  largest overlap (µm)   closed form   duration (µs)   closed form");
    for (name, law, n, factor) in laws {
        let pair = law.between(&material, &material);
        // Hertz's factor is 4/3 E* √R*
        let c = pair.normal_stiffness * if law == ContactLaw::Hertz { (0.5 * RADIUS).sqrt() } else { 1.0 };
        let overlap = ((n + 1.0) * mass * SPEED * SPEED / (2.0 * c)).powf(1.0 / (n + 1.0));
        let duration = factor * overlap / SPEED;
        let [deepest, lasted] = impact(&material, law, duration / 5000.0);
        println!("{name:20} {:20.4}   {:11.4}   {:13.4}   {:11.4}", 1e6 * deepest, 1e6 * overlap, 1e6 * lasted, 1e6 * duration);
        assert!((deepest / overlap - 1.0).abs() < 1e-3, "the largest overlap is {deepest} m, not {overlap} m");
        assert!((lasted / duration - 1.0).abs() < 1e-3, "the impact lasts {lasted} s, not {duration} s");
    }
}

/// Largest overlap, m, and duration, s, of the impact with steps of `time_step` seconds.
fn impact(material: &Material, law: ContactLaw, time_step: f64) -> [f64; 2] {
    let stepping = Stepping { dt: Some(time_step), ..Stepping::default() };
    let physics = Physics { stepping, ..Physics::of(vec![material.clone()], law) };
    let mut grains = Grains::default();
    let half_way = 0.25 * SPEED * time_step;
    for side in [-1.0, 1.0] {
        let i = grains.add([side * (RADIUS + half_way), 0.0, 0.0], RADIUS, 0, &physics.materials);
        grains.vel[i][0] = -0.5 * SPEED * side;
    }
    let mut state = State::new(&physics, grains, Vec::new(), false);
    let mut work = Workspace::new(&physics, &mut state);
    let (mut deepest, mut began) = (0.0_f64, None);
    loop {
        let mut overlap = 0.0;
        // the closure sees the state when the forces of this instant are known
        let Ok(()) = step(&physics, &mut state, &mut work, |state, _| -> Result<(), Infallible> {
            overlap = 2.0 * RADIUS - (state.grains.pos[1][0] - state.grains.pos[0][0]).abs();
            Ok(())
        });
        deepest = deepest.max(overlap);
        match began {
            None if overlap > 0.0 => began = Some(state.time),
            Some(since) if overlap <= 0.0 => return [deepest, state.time - since],
            _ => {}
        }
    }
}
