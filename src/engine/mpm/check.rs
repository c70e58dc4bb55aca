//! Checks of settings, laws and points before the first step, and the stable time step.

use super::law::Law;
use super::points::Points;
use super::{Continuum, Dimension, GridWall, Settings, ShapeFunctions, Transfer};
use crate::check::{self, Checked, ensure};
use crate::error::{Error, Result};

/// Largest number of cells along a side of the domain.
const MOST: u32 = 1 << 19;

/// Checks settings and points.
///
/// # Errors
/// All settings that are not allowed; if there are none, the first point that is not allowed.
pub fn all(settings: &Settings, laws: &[Law], points: &Points) -> Result<()> {
    Error::all(of_settings(settings))?;
    of_points(settings, laws, points)
}

/// Error about a setting or point: its name, its value, and what is allowed.
fn wrong(key: &str, value: impl std::fmt::Debug, allowed: &str) -> Error {
    Error::refused("continuum", key, Some(format!("{value:?}")), allowed)
}

/// Number of dimensions.
fn dimensions(settings: &Settings) -> usize {
    if settings.dimension == Dimension::Space { 3 } else { 2 }
}

/// Errors of the settings.
fn of_settings(s: &Settings) -> Vec<Error> {
    let mut errors = Vec::new();
    let mut require = |ok: bool, key: &str, value: &dyn std::fmt::Debug, allowed: &str| {
        if !ok {
            errors.push(wrong(key, value, allowed));
        }
    };
    let d = dimensions(s);
    require(s.cell > 0.0 && s.cell.is_finite(), "cell", &s.cell, "must be > 0");
    require(s.lower.iter().all(|x| x.is_finite()), "lower", &s.lower, "must be finite");
    require(s.cells[..d].iter().all(|n| (1..=MOST).contains(n)), "cells", &s.cells, "must be 1 to 524288 along each axis");
    require(s.gravity.iter().all(|g| g.is_finite()), "gravity", &s.gravity, "must be finite");
    require(d == 3 || s.gravity[2] == 0.0, "gravity", &s.gravity, "must lie in the plane");
    require((0.0..1.0).contains(&s.damping), "damping", &s.damping, "must be at least 0 and below 1");
    if let Transfer::Blend { pic } = s.transfer {
        require((0.0..=1.0).contains(&pic), "pic", &pic, "must be from 0 (FLIP) to 1 (PIC)");
    }
    if let ShapeFunctions::Gimp { half_width } = s.shape {
        require(half_width > 0.0 && half_width <= 0.5, "half_width", &half_width, "must be above 0 and at most 0.5 (cells)");
        require(s.transfer != Transfer::Affine, "transfer", &"affine", "needs B-splines: choose them, or a FLIP/PIC blend");
    }
    for wall in s.walls {
        if let GridWall::Friction { friction } = wall {
            require(friction >= 0.0 && friction.is_finite(), "friction", &friction, "must be at least 0");
        }
    }
    errors
}

/// Checks identities and the state of every point.
fn of_points(settings: &Settings, laws: &[Law], points: &Points) -> Result<()> {
    let d = dimensions(settings);
    let mut ids = points.id.clone();
    ids.sort_unstable();
    if let Some(twice) = ids.windows(2).find(|w| w[0] == w[1]) {
        return Err(wrong("id", twice[0], "stands twice: ids must differ"));
    }
    for i in 0..points.len() {
        let point = |what: &str| format!("point {} {what}", points.id[i]);
        let (p, v) = (&points.position[i], &points.velocity[i]);
        for a in 0..d {
            let (low, high) = (settings.lower[a], settings.lower[a] + f64::from(settings.cells[a]) * settings.cell);
            if !(p[a] >= low && p[a] <= high) {
                let allowed =
                    format!("is outside of the grid, {low} to {high} m along {}: enlarge it or move the point", ["x", "y", "z"][a]);
                return Err(wrong(&point("position"), [p[0], p[1], p[2]], &allowed));
            }
        }
        if !(p[3] > 0.0 && p[3].is_finite()) {
            return Err(wrong(&point("volume"), p[3], "must be > 0"));
        }
        if !(v[3] > 0.0 && v[3].is_finite()) {
            return Err(wrong(&point("mass"), v[3], "must be > 0"));
        }
        if !v[..3].iter().chain(&points.stress[i]).all(|x| x.is_finite()) {
            return Err(wrong(&point("velocity or stress"), (v, points.stress[i]), "must be finite"));
        }
        if !(0.0..1.0).contains(&points.initial_porosity[i]) {
            return Err(wrong(&point("porosity"), points.initial_porosity[i], "must be at least 0 and below 1"));
        }
        if usize::from(points.law[i]) >= laws.len() {
            return Err(wrong(&point("law"), points.law[i], &format!("there are {} laws, counted from 0", laws.len())));
        }
    }
    Ok(())
}

/// See [`Continuum::check`].
pub fn of_state(c: &Continuum, made: &Continuum, added: u64) -> Checked {
    ensure(c.settings == made.settings && c.laws == made.laws, || "grid or laws of the points are not those of the scene".into())?;
    ensure(c.account.is_some() == made.account.is_some(), || "the energy account is kept otherwise than in the scene".into())?;
    c.account.as_ref().map_or(Ok(()), |account| account.check())?;
    ensure(c.keeps_transport_velocity == made.keeps_transport_velocity, || {
        "points keep other velocities than the scene asks for".into()
    })?;
    let (p, n) = (&c.points, c.points.len());
    let own = [
        p.velocity.len(),
        p.stress.len(),
        p.memory.len(),
        p.initial_volume.len(),
        p.initial_porosity.len(),
        p.law.len(),
        p.id.len(),
    ];
    check::lengths("points", n, own)?;
    check::lengths("points", if c.settings.transfer == Transfer::Affine { n } else { 0 }, [p.affine.len()])?;
    check::lengths("points", if c.keeps_transport_velocity { n } else { 0 }, [p.transport_velocity.len()])?;
    check::lengths("points", if p.faces.is_empty() { 0 } else { n }, [p.faces.len()])?;
    let most = u64::from(made.points.next_id) + added;
    ensure((u64::from(made.points.next_id)..=most).contains(&u64::from(p.next_id)), || format!("there were {} points", p.next_id))?;
    check::identities("point", &p.id, p.next_id)?;
    check::numbers("places of points", p.position.as_flattened())?;
    check::numbers("velocities of points", p.velocity.as_flattened())?;
    check::numbers("stresses of points", p.stress.as_flattened())?;
    check::positive("volumes of points", p.position.iter().map(|p| p[3]).chain(p.initial_volume.iter().copied()))?;
    check::positive("masses of points", p.velocity.iter().map(|v| v[3]))?;
    check::numbers("plastic strains of points", p.memory.iter().map(|m| m.plastic))?;
    check::not_negative("gaps of points", p.memory.iter().map(|m| m.gap))?;
    let falls = |law: u8| c.laws.get(usize::from(law)).is_some_and(Law::plastic_falls);
    let accumulated = p.memory.iter().zip(&p.law).filter(|(_, law)| !falls(**law));
    check::not_negative("plastic strains of points", accumulated.map(|(m, _)| m.plastic))?;
    check::numbers("velocity gradients of points", p.affine.as_flattened().as_flattened())?;
    check::numbers("velocities of points", p.transport_velocity.as_flattened())?;
    check::numbers("faces of points", p.faces.as_flattened().as_flattened())?;
    of_points(&c.settings, &c.laws, p).map_err(|e| e.to_string())?;
    check::counters("steps", &[c.step])?;
    check::numbers("work and forces of points", c.wall_force.iter().flatten().chain([&c.stress_work]))
}

/// See [`Continuum::stable_step`].
pub fn stable_step(c: &Continuum, safety: f64) -> f64 {
    let points = &c.points;
    // stresses are read only where a law needs them
    let stiffens = c.laws.iter().any(Law::stiffens);
    let fastest = (0..points.len())
        .map(|i| {
            let [u, v, w, _] = points.velocity[i];
            let law = &c.laws[points.law[i] as usize];
            let wave = if stiffens {
                law.wave_speed_at(points.density(i), &points.stress[i], points.memory[i])
            } else {
                law.wave_speed(points.density(i))
            };
            wave + (u * u + v * v + w * w).sqrt()
        })
        .fold(0.0, f64::max);
    safety * c.settings.cell / fastest
}

/// Largest stable step of a continuum with loading plates, s: 1/dt² = 1/`waves`² + `rate`/4, with APIC 1/dt² = 1/`waves`² + `rate`/2. `waves`: largest step by
/// waves through a cell, h/c, s; `rate`: largest tangent stiffness over mass k/m of a point in contact with a plate, 1/s².
///
/// Derivation. Strains and displacements of faces follow the nodes' velocities after these were computed anew from the points. So forces F at the nodes
/// change those velocities by T F/m, where T averages over what points share. With FLIP T has eigenvalues 0 ≤ t ≤ 1. With the stiffness K of the material and
/// of contacts, which is symmetric as forces act where displacements are taken, the leapfrog is stable while dt² ω² < 4 for all eigenvalues ω² of T K/m.
/// For a row of n points per cell, at any place between the nodes, ω² is at most 1.0 (n = 1) or 0.86 (n = 2) times (c/h)² in the material, 1.34 times with
/// generalised interpolation, and 0.97 (n = 1) or 0.52 (n = 2; 0.63 with generalised interpolation) times k/m at the face; so 1/dt² = (c/h)² + k/(4m)
/// suffices. APIC loses the part 1 − t of a velocity in each step and is stable while dt² ω² < 2 (1 + t), hence k/(2m).
pub fn with_plates(waves: f64, rate: f64, transfer: Transfer) -> f64 {
    let forgets = if transfer == Transfer::Affine { 2.0 } else { 1.0 };
    1.0 / (1.0 / (waves * waves) + 0.25 * forgets * rate).sqrt()
}

/// See [`Continuum::check_step`].
///
/// # Errors
/// A step that is not positive or above the bound.
pub fn step(c: &Continuum, dt: f64) -> Result<()> {
    let bound = stable_step(c, 1.0);
    if dt > 0.0 && dt <= bound {
        return Ok(());
    }
    let allowed = format!("must be above 0 and at most {bound:e} s, the time a compression wave takes through a cell");
    Err(wrong("time step", dt, &allowed))
}
