//! A spinning elastic disk.

use super::block::{self, APIC, FLIP, Method, PIC, elastic, fill};
use super::{Case, Found, Task};
use engine::mpm::law::Sym;
use engine::mpm::{Continuum, Dimension, Transfer};
use laboratory::error::Result;
use std::f64::consts::PI;

/// The case in the list of cases.
pub const CASE: Case = Case {
    name: "disk",
    about: "An elastic disk in plane strain spins freely, one turn, from the stress that its spin asks for",
    exact: "σr = (3 − 2ν)/(8(1 − ν)) ρω²(R² − r²), σθ = ρω²((3 − 2ν)R² − (1 + 2ν)r²)/(8(1 − ν)); ω 1 rad/s, R 1 m, ρ 1000 kg/m³, E 1 MPa, ν 0.3; angular momentum and stress stay",
    across: "cells along the radius",
    resolutions: &[5, 8, 12, 20],
    ways: &["APIC", "FLIP", "FLIP, 1 % PIC", "PIC"],
    quantities: &["angular momentum", "stress"],
    scene: false,
    run,
    graphs: None,
};
const METHODS: [Method; 4] = [APIC, FLIP, Method { transfer: Transfer::Blend { pic: 0.01 }, ..FLIP }, PIC];
const NU: f64 = 0.3;
const DENSITY: f64 = 1000.0;

fn run(task: &Task) -> Result<Found> {
    spin(METHODS[task.way], task.cells)
}

/// Errors after one turn: change of the angular momentum; root mean square error of the stress over
/// the root mean square stress. The last entry is the largest stress over ρω²R².
///
/// # Errors
/// A lost point.
pub fn spin(method: Method, cells: u32) -> Result<Found> {
    let cell = 1.0 / f64::from(cells);
    let side = 2 * (cells + 3);
    let s = block::settings(Dimension::PlaneStrain, cell, [side, side, 1], method);
    let middle = cell * f64::from(cells + 3);
    let at = |x: f64, y: f64| [x - middle, y - middle];
    let inside = |[x, y, _]: [f64; 3]| at(x, y).iter().map(|x| x * x).sum::<f64>() < 1.0;
    let end = 2.0 * middle;
    let mut points = fill(&s, [[0.0; 3], [end, end, 0.0]], 2, DENSITY, inside, |[x, y, _]| [middle - y, x - middle, 0.0]);
    for (stress, p) in points.stress.iter_mut().zip(&points.position) {
        *stress = exact(at(p[0], p[1]));
    }
    let count = points.len();
    let mut c = Continuum::new(s, elastic(1e6, NU), points)?;
    c.points_mut().affine.fill([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0; 3]]);
    // about the origin, which is as good as the middle, because the disk has no momentum
    let start = c.totals().angular_momentum[2];
    let n = 800 * u64::from(cells);
    block::steps(&mut c, 2.0 * PI / n as f64, n)?;
    let points = c.points();
    let (mut off, mut all, mut most) = (0.0, 0.0, 0.0_f64);
    for (stress, p) in points.stress.iter().zip(&points.position) {
        let exact = exact(at(p[0], p[1]));
        // the full tensor holds the shear component of the plane twice
        for (k, twice) in [(0, 1.0), (1, 1.0), (3, 2.0)] {
            off += twice * (stress[k] - exact[k]) * (stress[k] - exact[k]);
            all += twice * exact[k] * exact[k];
            most = most.max(stress[k].abs());
        }
    }
    let errors = vec![c.totals().angular_momentum[2] / start - 1.0, (off / all).sqrt(), most / DENSITY];
    Ok(Found { points: count, steps: c.steps(), errors })
}

/// Stress of the spinning disk, Pa, at a place given from the middle of the disk.
fn exact([x, y]: [f64; 2]) -> Sym {
    let square = x * x + y * y;
    let unit = DENSITY / (8.0 * (1.0 - NU));
    let radial = unit * (3.0 - 2.0 * NU) * (1.0 - square);
    let hoop = unit * ((3.0 - 2.0 * NU) - (1.0 + 2.0 * NU) * square);
    let [cc, ss, sc] = if square > 0.0 { [x * x / square, y * y / square, x * y / square] } else { [1.0, 0.0, 0.0] };
    [radial * cc + hoop * ss, radial * ss + hoop * cc, NU * (radial + hoop), (radial - hoop) * sc, 0.0, 0.0]
}
