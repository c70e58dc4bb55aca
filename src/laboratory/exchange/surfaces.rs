//! Triangles of everything that a run holds: each grain as an icosahedron whose faces were divided, each body as the surface that pictures
//! show.

use super::Contents;
use crate::error::{Error, Result};

/// Numbers of triangles that a grain may have: an icosahedron whose faces are divided in four, again and again.
pub type Levels = [u32; 4];

/// A surface made of triangles, with numbers of its corners.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surfaces {
    /// Corners, m.
    pub corners: Vec<[f64; 3]>,
    /// Triangles, counter-clockwise when seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Of each corner: radius of its grain, m, 0 of a body; generation of its grain, 0 of a body; number of its body, −1 of a grain.
    pub of_corner: Vec<(f64, u32, i32)>,
}

impl Surfaces {
    /// Numbers of triangles that a grain may have.
    pub const LEVELS: Levels = [20, 80, 320, 1280];
    /// Most corners: their numbers have 31 bits in other programs.
    const MOST: usize = i32::MAX as usize;

    /// The surfaces of everything, grains of `triangles` triangles each, one of [`Surfaces::LEVELS`]; corners of a grain are on its sphere.
    ///
    /// # Errors
    /// Another number of triangles; more corners than 31 bits can count.
    pub fn of(contents: &Contents, triangles: u32) -> Result<Surfaces> {
        let Some(level) = Self::LEVELS.iter().position(|n| *n == triangles) else {
            let allowed = Self::LEVELS.map(|n| n.to_string()).join(", ");
            return Err(Error::input("grains", "triangles", Some(triangles.to_string()), format!("must be one of {allowed}")));
        };
        let (corners, faces) = sphere(level);
        let all = contents.grains.len().saturating_mul(corners.len()).saturating_add(contents.bodies.position.len());
        if all > Self::MOST {
            let message = format!("{} grains make {all} corners, where files hold {}", contents.grains.len(), Self::MOST);
            return Err(Error::input("grains", "triangles", Some(triangles.to_string()), message));
        }
        let mut out = Surfaces::default();
        for grain in &contents.grains {
            let (first, p, r) = (out.corners.len() as u32, grain.position, grain.radius);
            out.corners.extend(corners.iter().map(|c| [p[0] + r * c[0], p[1] + r * c[1], p[2] + r * c[2]]));
            out.triangles.extend(faces.iter().map(|t| t.map(|k| first + k)));
            out.of_corner.extend(std::iter::repeat_n((r, grain.generation, -1), corners.len()));
        }
        let first = out.corners.len() as u32;
        out.corners.extend(&contents.bodies.position);
        out.triangles.extend(contents.bodies.triangles.iter().map(|t| t.map(|k| first + k)));
        let mut of_body = vec![(0.0, 0, 0); contents.bodies.position.len()];
        if let Some(block) = contents.bodies.array("block") {
            for (triangle, block) in contents.bodies.triangles.iter().zip(&block.values) {
                triangle.iter().for_each(|k| of_body[*k as usize].2 = *block as i32);
            }
        }
        out.of_corner.extend(of_body);
        Ok(out)
    }
}

/// Corners on the unit sphere and faces of an icosahedron whose faces were divided in four `level` times.
fn sphere(level: usize) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (a, b) = (1.0, 0.5 * (1.0 + 5.0_f64.sqrt()));
    let mut corners: Vec<[f64; 3]> = [
        [-a, b, 0.0],
        [a, b, 0.0],
        [-a, -b, 0.0],
        [a, -b, 0.0],
        [0.0, -a, b],
        [0.0, a, b],
        [0.0, -a, -b],
        [0.0, a, -b],
        [b, 0.0, -a],
        [b, 0.0, a],
        [-b, 0.0, -a],
        [-b, 0.0, a],
    ]
    .map(unit)
    .to_vec();
    let mut faces = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..level {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |p: u32, q: u32| {
            *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                let (x, y) = (corners[p as usize], corners[q as usize]);
                corners.push(unit([x[0] + y[0], x[1] + y[1], x[2] + y[2]]));
                corners.len() as u32 - 1
            })
        };
        let divide = |[p, q, r]: [u32; 3]| {
            let (s, t, u) = (middle(p, q), middle(q, r), middle(r, p));
            [[p, s, u], [q, t, s], [r, u, t], [s, t, u]]
        };
        faces = faces.into_iter().flat_map(divide).collect();
    }
    (corners, faces)
}

fn unit([x, y, z]: [f64; 3]) -> [f64; 3] {
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::{Grain, Kind};
    use super::*;
    use engine::shape::Mesh;

    /// Two grains of two materials.
    pub fn two() -> Contents {
        let grain = |x: f64, radius: f64, kind: usize| Grain {
            position: [x, 0.1, -1.0 / 3.0],
            radius,
            velocity: [1e-7, 0.0, -x],
            spin: [0.0, 0.1, 2.0],
            generation: kind as u32,
            kind,
        };
        let kind = |name: &str, density: f64| Kind { name: name.into(), density };
        let kinds = vec![kind("sand", 2650.0), kind("steel", 7850.1)];
        Contents { grains: vec![grain(0.1 + 0.2, 1e-3 / 3.0, 0), grain(-2.5, 0.7, 1)], kinds, ..Contents::default() }
    }

    #[test]
    fn grains_are_closed_surfaces_that_look_outwards() {
        let full = 4.0 / 3.0 * std::f64::consts::PI * 0.7_f64.powi(3);
        let mut lost = [1.0; 4];
        for (lost, triangles) in lost.iter_mut().zip(Surfaces::LEVELS) {
            let contents = Contents { grains: vec![two().grains[1]], ..two() };
            let made = Surfaces::of(&contents, triangles).expect("surfaces");
            assert_eq!((made.triangles.len(), made.corners.len()), (triangles as usize, 2 + triangles as usize / 2));
            let mesh = Mesh { corners: made.corners, triangles: made.triangles };
            *lost = 1.0 - mesh.bulk().volume / full;
        }
        // inscribed: less than the sphere, a quarter of that with four times the triangles
        assert!(lost[1] > 0.0 && lost.windows(2).skip(1).all(|w| (w[0] / w[1] - 4.0).abs() < 0.4), "{lost:?}");
        assert!(Surfaces::of(&two(), 100).expect_err("no such number").to_string().contains("20, 80, 320, 1280"));
    }
}
