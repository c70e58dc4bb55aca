//! The contacts of grains at an instant: bodies, place and forces, as a table beside a snapshot; and the mean stress in each
//! grain.

use super::vtk::Fact;
use crate::error::{Error, Result};
use engine::boundary::Wall;
use engine::boundary::WallShape;
use engine::contact::pairs::ContactForce;
use engine::coupling::Mixture;
use engine::dem::State;
use engine::grains::{Grains, sphere_volume};
use engine::mpm::Continuum;
use std::fmt::Write as _;
use std::path::Path;
use table::number;

/// Columns of the file.
const HEADER: &str = "a,kind_b,b,x_m,y_m,z_m,a_x_m,a_y_m,a_z_m,b_x_m,b_y_m,b_z_m,normal_x_N,normal_y_N,normal_z_N,\
                      tangential_x_N,tangential_y_N,tangential_z_N,overlap_m\n";

/// The second body of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Other {
    /// Index of a grain.
    Grain(usize),
    /// Number of a wall.
    Wall(usize),
    /// Identity of a point.
    Point(u32),
}

/// A contact of a grain.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// Index of the grain, which is the first body.
    pub grain: usize,
    /// The second body.
    pub other: Other,
    /// Point of contact, m: the middle of the overlap, on a wall its surface.
    pub point: [f64; 3],
    /// Centre of the second body, m; of a wall the point of contact.
    pub centre: [f64; 3],
    /// Distance of the point of contact from the centres of both bodies along the normal, m.
    arms: [f64; 2],
    /// Forces on the grain, N.
    pub touch: ContactForce,
}

impl Contact {
    fn between(grains: &Grains, grain: usize, other: Other, centre: [f64; 3], radius: f64, touch: ContactForce) -> Contact {
        let [x, y, z, r] = grains.pos[grain];
        let wall = matches!(other, Other::Wall(_));
        let half = if wall { touch.overlap } else { 0.5 * touch.overlap };
        let point = std::array::from_fn(|a| [x, y, z][a] + (r - half) * touch.normal[a]);
        Contact { grain, other, point, centre: if wall { point } else { centre }, arms: [r - half, radius - half], touch }
    }
}

/// Contacts between grains and of grains with walls, in the order of ids.
pub fn of_grains(state: &State) -> Vec<Contact> {
    let State { grains: g, pairs, wall_pairs, .. } = state;
    let id = |i: u32| g.id[i as usize];
    let between = pairs.touching(|[i, j]| [id(i), id(j)]).into_iter().map(|s| {
        let [i, j] = pairs.ends[s].map(|i| i as usize);
        let [x, y, z, r] = g.pos[j];
        Contact::between(g, i, Other::Grain(j), [x, y, z], r, pairs.touch[s])
    });
    let on_walls = wall_pairs.touching(|[i, k]| [k, id(i)]).into_iter().map(|s| {
        let [i, k] = wall_pairs.ends[s].map(|i| i as usize);
        Contact::between(g, i, Other::Wall(k), [0.0; 3], 0.0, wall_pairs.touch[s])
    });
    between.chain(on_walls).collect()
}

/// Contacts between grains, of grains with walls, and of grains with points.
pub fn of_mixture(mixture: &Mixture, continuum: &Continuum) -> Vec<Contact> {
    let mut all = of_grains(&mixture.grains);
    let points = continuum.points();
    all.extend(mixture.point_contacts.on_grains().map(|(grain, point, radius, touch)| {
        let [x, y, z, _] = points.position[point];
        Contact::between(&mixture.grains.grains, grain, Other::Point(points.id[point]), [x, y, z], radius, touch)
    }));
    all
}

/// Mean stress in each grain by index, Pa, compression positive: a third of the trace of Love and Weber's sum of contact forces
/// times branch vectors, over the volume of the grain.
pub fn mean_stresses(grains: &Grains, contacts: &[Contact]) -> Vec<f64> {
    let mut sums = vec![0.0; grains.len()];
    for c in contacts {
        // tangential forces are normal to the branch vectors and add nothing to the trace
        sums[c.grain] += c.touch.normal_force * c.arms[0];
        if let Other::Grain(j) = c.other {
            sums[j] += c.touch.normal_force * c.arms[1];
        }
    }
    sums.iter().zip(&grains.pos).map(|(sum, p)| sum / (3.0 * sphere_volume(p[3]))).collect()
}

/// Love and Weber's mean stress in a volume, m³, from all of its contacts, Pa, compression positive: −Σ f ⊗ l / V with the force f on the first body and the
/// branch vector l from the centre of the first body to that of the second, on a wall to the point of contact. Rows are the directions of the forces.
pub fn mean_stress(grains: &Grains, contacts: &[Contact], volume: f64) -> [[f64; 3]; 3] {
    let mut stress = [[0.0; 3]; 3];
    for c in contacts {
        let force = c.touch.force();
        let at = grains.pos[c.grain];
        for (row, f) in stress.iter_mut().zip(force) {
            for (a, sum) in row.iter_mut().enumerate() {
                *sum -= f * (c.centre[a] - at[a]) / volume;
            }
        }
    }
    stress
}

/// Names of the walls: `bottom`, `top`, `cylinder`, `x_low`, … in a test (`specimen`), `wall_0`, `wall_1`, … in a free scene.
pub fn names(walls: &[Wall], specimen: bool) -> Vec<String> {
    let name = |(k, wall): (usize, &Wall)| {
        let of_specimen = match wall.shape {
            WallShape::Cylinder { .. } => Some("cylinder"),
            WallShape::Plane { normal, .. } => {
                let places = [
                    ("x_low", 0, 1.0),
                    ("x_high", 0, -1.0),
                    ("y_low", 1, 1.0),
                    ("y_high", 1, -1.0),
                    ("bottom", 2, 1.0),
                    ("top", 2, -1.0),
                ];
                places.into_iter().find(|(_, axis, sign)| normal[*axis] == *sign).map(|p| p.0)
            }
        };
        of_specimen.filter(|_| specimen).map_or_else(|| format!("wall_{k}"), str::to_string)
    };
    walls.iter().enumerate().map(name).collect()
}

/// Writes the contacts as a table, with `facts` as notes before it; forces are those on the first body. `walls` are the names of
/// the walls.
pub fn write(path: &Path, facts: &[Fact], grains: &Grains, walls: &[String], contacts: &[Contact]) -> Result<()> {
    let mut text: String = facts.iter().map(|(name, value)| format!("# {name} = {}\n", number(*value))).collect();
    text += HEADER;
    for c in contacts {
        let (kind, name) = match c.other {
            Other::Grain(j) => ("grain", grains.id[j].to_string()),
            Other::Wall(k) => ("wall", walls[k].clone()),
            Other::Point(id) => ("point", id.to_string()),
        };
        let [x, y, z, _] = grains.pos[c.grain];
        let normal = c.touch.normal.map(|n| -c.touch.normal_force * n);
        let vectors = [c.point, [x, y, z], c.centre, normal, c.touch.tangential];
        let numbers = vectors.into_iter().flatten().chain([c.touch.overlap]).map(number).collect::<Vec<String>>().join(",");
        let _ = writeln!(text, "{},{kind},{name},{numbers}", grains.id[c.grain]);
    }
    table::write(path, text).map_err(Error::write(path))
}
