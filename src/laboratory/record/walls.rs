//! Snapshots of walls for ParaView, as triangles: platens as discs or rectangles, cylinders as tubes. An infinite plane of a free
//! scene is drawn as far as the bodies reach.

use super::vtk::{self, Fact, Field, VtkError};
use engine::boundary::WallShape;
use std::f64::consts::TAU;
use std::path::Path;

/// Corners around a circle.
const SIDES: u32 = 72;

/// A wall with the normal force on it, N (on a cylinder the sum of the radial forces).
pub type Loaded = (WallShape, f64);

/// Lower and upper corner of a box around all bodies (centre and radius) and all walls that are normal to an axis, m.
pub fn space(bodies: impl Iterator<Item = [f64; 4]>, walls: &[Loaded]) -> [[f64; 3]; 2] {
    let mut space = bodies.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[low, high], p| {
        [std::array::from_fn(|a| low[a].min(p[a] - p[3])), std::array::from_fn(|a| high[a].max(p[a] + p[3]))]
    });
    for (shape, _) in walls {
        match *shape {
            WallShape::Plane { point, normal } => {
                for a in 0..3 {
                    if normal[a].abs() == 1.0 {
                        space[usize::from(normal[a] < 0.0)][a] = point[a];
                    }
                }
            }
            WallShape::Cylinder { centre, radius } => {
                for (a, c) in centre.into_iter().enumerate() {
                    (space[0][a], space[1][a]) = (c - radius, c + radius);
                }
            }
        }
    }
    space
}

/// Triangles of one wall.
#[derive(Default)]
struct Mesh {
    corners: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    fn rectangle(&mut self, corners: [[f64; 3]; 4]) {
        let n = self.corners.len() as u32;
        self.corners.extend(corners);
        self.triangles.extend([[n, n + 1, n + 2], [n, n + 2, n + 3]]);
    }

    fn disc(&mut self, [x, y]: [f64; 2], radius: f64, z: f64) {
        let n = self.corners.len() as u32;
        self.corners.push([x, y, z]);
        self.corners.extend((0..SIDES).map(|k| ring([x, y], radius, z, k)));
        self.triangles.extend((0..SIDES).map(|k| [n, n + 1 + k, n + 1 + (k + 1) % SIDES]));
    }

    fn tube(&mut self, centre: [f64; 2], radius: f64, [low, high]: [f64; 2]) {
        let n = self.corners.len() as u32;
        self.corners.extend((0..SIDES).flat_map(|k| [low, high].map(|z| ring(centre, radius, z, k))));
        for k in 0..SIDES {
            let (a, b) = (n + 2 * k, n + 2 * ((k + 1) % SIDES));
            self.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
}

fn ring([x, y]: [f64; 2], radius: f64, z: f64, k: u32) -> [f64; 3] {
    let (sin, cos) = (TAU * f64::from(k) / f64::from(SIDES)).sin_cos();
    [x + radius * cos, y + radius * sin, z]
}

/// Writes the walls as `.vtp` with the cell data `wall` (number of the wall) and `normal_force_N`. `low` and `high` are the
/// corners of [`space`].
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, facts: &[Fact], walls: &[Loaded], [low, high]: [[f64; 3]; 2]) -> Result<(), VtkError> {
    let mut mesh = Mesh::default();
    let (mut numbers, mut forces) = (Vec::new(), Vec::new());
    let shell = walls.iter().find_map(|(shape, _)| match *shape {
        WallShape::Cylinder { centre, radius } => Some((centre, radius)),
        WallShape::Plane { .. } => None,
    });
    for (k, (shape, force)) in walls.iter().enumerate() {
        let before = mesh.triangles.len();
        match (*shape, shell) {
            (WallShape::Cylinder { centre, radius }, _) => mesh.tube(centre, radius, [low[2], high[2]]),
            (WallShape::Plane { point, normal }, Some((centre, radius))) if normal[2].abs() == 1.0 => {
                mesh.disc(centre, radius, point[2])
            }
            (WallShape::Plane { point, normal }, _) => mesh.rectangle(face(point, normal, low, high)),
        }
        let more = mesh.triangles.len() - before;
        numbers.extend(std::iter::repeat_n(k as f64, more));
        forces.extend(std::iter::repeat_n(*force, more));
    }
    let field = |name, values| Field { name, components: 1, values };
    vtk::write_surfaces(path, facts, &mesh.corners, &mesh.triangles, &[field("wall", numbers), field("normal_force_N", forces)])
}

/// The part of a plane that is drawn: a side of the box from `low` to `high` for a plane normal to an axis, else a square as wide
/// as the diagonal of the box.
fn face(point: [f64; 3], normal: [f64; 3], low: [f64; 3], high: [f64; 3]) -> [[f64; 3]; 4] {
    if let Some(axis) = (0..3).find(|&a| normal[a].abs() == 1.0) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        return [(false, false), (true, false), (true, true), (false, true)].map(|(a, b)| {
            let mut p = point;
            p[u] = if a { high[u] } else { low[u] };
            p[v] = if b { high[v] } else { low[v] };
            p
        });
    }
    let middle: [f64; 3] = std::array::from_fn(|a| 0.5 * (low[a] + high[a]));
    let half = 0.5 * (0..3).map(|a| (high[a] - low[a]).powi(2)).sum::<f64>().sqrt();
    let height: f64 = (0..3).map(|a| (middle[a] - point[a]) * normal[a]).sum();
    let least = (0..3).fold(0, |a, b| if normal[b].abs() < normal[a].abs() { b } else { a });
    let mut along = normal.map(|n| -n * normal[least]);
    along[least] += 1.0;
    let length = along.iter().map(|x| x * x).sum::<f64>().sqrt();
    let along = along.map(|x| x / length);
    let across = engine::math::vector::cross(normal, along);
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(a, b)| std::array::from_fn(|k| middle[k] - height * normal[k] + half * (a * along[k] + b * across[k])))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area of the triangles of a wall.
    fn area(walls: &[Loaded]) -> f64 {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("walls.vtp");
        let space = space([[0.0, 0.0, 0.5, 0.1]].into_iter(), walls);
        write(&path, &[], walls, space).expect("written");
        let file = std::fs::read(&path).expect("file");
        let corners = vtk::tests::numbers(&vtk::tests::array(&file, "Points"));
        let ends: Vec<usize> =
            vtk::tests::array(&file, "connectivity").as_chunks::<8>().0.iter().map(|b| i64::from_le_bytes(*b) as usize).collect();
        let at = |k: usize| -> [f64; 3] { std::array::from_fn(|a| corners[3 * k + a]) };
        let half = |t: &[usize]| {
            let [p, q, r] = [at(t[0]), at(t[1]), at(t[2])];
            let n = engine::math::vector::cross(engine::math::vector::less(q, p), engine::math::vector::less(r, p));
            0.5 * engine::math::vector::dot(n, n).sqrt()
        };
        ends.chunks(3).map(half).sum()
    }

    fn plane(z: f64, up: f64) -> Loaded {
        (WallShape::Plane { point: [0.0, 0.0, z], normal: [0.0, 0.0, up] }, 1.0)
    }

    #[test]
    fn platens_are_discs_and_the_cylinder_a_tube_between_them() {
        let shell = (WallShape::Cylinder { centre: [0.0; 2], radius: 0.5 }, 2.0);
        let whole = area(&[plane(0.0, 1.0), plane(2.0, -1.0), shell]);
        let circle = std::f64::consts::PI * 0.25;
        let exact = 2.0 * circle + std::f64::consts::PI * 2.0;
        assert!((whole / exact - 1.0).abs() < 2e-3, "{whole} of {exact}");
    }

    #[test]
    fn planes_reach_as_far_as_the_bodies() {
        // 0.2 by 0.2 under a grain; an inclined one is a square of the diagonal of 0.2 · 0.2 · 0.6
        assert!((area(&[plane(0.0, 1.0)]) - 0.04).abs() < 1e-12);
        let inclined = (WallShape::Plane { point: [0.0; 3], normal: [0.6, 0.0, 0.8] }, 0.0);
        assert!((area(&[inclined]) - 0.12).abs() < 1e-9);
    }
}
