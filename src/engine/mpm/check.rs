//! What a continuum must be before its first step, and the largest step.

use super::law::Law;
use super::points::Points;
use super::{Continuum, Dimension, GridWall, Settings, ShapeFunctions, Transfer};
use crate::error::{Error, Result};

/// Most cells along a side of the domain.
const MOST: u32 = 1 << 19;

/// # Errors
/// Every setting that is not allowed, or else the first point.
pub fn all(settings: &Settings, laws: &[Law], points: &Points) -> Result<()> {
    Error::all(of_settings(settings))?;
    of_points(settings, laws, points)
}

fn wrong(key: &str, value: impl std::fmt::Debug, allowed: &str) -> Error {
    Error::refused("continuum", key, Some(format!("{value:?}")), allowed)
}

fn dimensions(settings: &Settings) -> usize {
    if settings.dimension == Dimension::Space { 3 } else { 2 }
}

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

/// `safety` times the least h/(c + |v|).
pub fn stable_step(c: &Continuum, safety: f64) -> f64 {
    let points = &c.points;
    let fastest = (0..points.len())
        .map(|i| {
            let [u, v, w, _] = points.velocity[i];
            c.laws[points.law[i] as usize].wave_speed(points.density(i)) + (u * u + v * v + w * w).sqrt()
        })
        .fold(0.0, f64::max);
    safety * c.settings.cell / fastest
}

/// Largest stable step, s, where waves through a cell allow `waves` and the stiffest contact of a loading plate has so much stiffness over the mass of its point, 1/s².
///
/// Strains and the ways of faces come from the nodes' velocities after they have been found anew from the points, so that forces F at the nodes change them by T F/m: with
/// FLIP T is the mean of what points share, with eigenvalues 0 ≤ t ≤ 1, and a leapfrog of the stiffness K, of the material and of contacts (symmetric: forces act where their
/// ways are taken), is stable while dt² ω² < 4 for all eigenvalues ω² of T K/m. Over a row of n points per cell, wherever it stands between the nodes, ω² is at most
/// 1.0 (n = 1), 0.86 (2) of (c/h)² in the material, with generalised interpolation 1.34, and 0.97 (1), 0.52 (2; 0.63) of k/m at the face: 1/dt² = (c/h)² + k/4m suffices. APIC forgets a part 1 − t
/// of the velocity in a step, and is stable while dt² ω² < 2 (1 + t): twice k/4m.
pub fn with_plates(waves: f64, rate: f64, transfer: Transfer) -> f64 {
    let forgets = if transfer == Transfer::Affine { 2.0 } else { 1.0 };
    1.0 / (1.0 / (waves * waves) + 0.25 * forgets * rate).sqrt()
}

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
