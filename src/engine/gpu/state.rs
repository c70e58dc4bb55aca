//! The state of the points as the device holds it, and back. The device has it in planes: arrays with four words of 32 bits for each point.

use super::exact::{UNITS, place, placed, split};
use crate::mpm::law::InternalVariables;
use crate::mpm::{Face, Points, Settings};
use rayon::prelude::*;

/// Number of planes; what they hold, in which order, is said in `nodes.wgsl`.
const PLANES: usize = 9;
/// Number of further planes for the faces of points, with loading plates only.
const FACES: usize = 2;
/// Number of quarters of a plane after these, for what takes one word: identity and ghost radius.
const SINGLES: usize = 2;

/// Number of entries, four words each, for `points` points with or without loading plates.
pub fn entries(points: usize, plates: bool) -> usize {
    first_single(points, plates) + SINGLES * points.div_ceil(4)
}

/// Number of entries of the planes.
fn first_single(points: usize, plates: bool) -> usize {
    points * (PLANES + if plates { FACES } else { 0 })
}

/// Radius of the ghost of point `i`, m: the sphere with its solid volume (Li et al. 2023, eq. 22), which does not change.
pub fn ghost_radius(points: &Points, i: usize) -> f64 {
    let solid = points.solid(i);
    (solid * (0.75 / std::f64::consts::PI)).cbrt()
}

/// Number of a cell, or of a block, by its place, as `blocks.wgsl` has it: x, y, z in 11, 11, 10 bits.
pub fn cell_number([x, y, z]: [u32; 3]) -> u32 {
    x | y << 11 | z << 22
}

/// Place of the cell with this number.
pub fn cell_place(cell: u32) -> [u32; 3] {
    [cell & 2047, cell >> 11 & 2047, cell >> 22]
}

/// Number of the cell at a position, and cell, units and rest along each axis.
pub fn cell_of(settings: &Settings, position: &[f64; 4]) -> (u32, [(i32, i32, f32); 3]) {
    let at: [(i32, i32, f32); 3] = std::array::from_fn(|a| place((position[a] - settings.lower[a]) / settings.cell));
    (cell_number(at.map(|at| (at.0 + 1) as u32)), at)
}

/// The planes of the points, one after the other, and their single words. Points must lie within the domain.
pub fn to_device(settings: &Settings, points: &Points, plates: bool) -> Vec<[u32; 4]> {
    let n = points.len();
    let mut planes = vec![[0_u32; 4]; entries(n, plates)];
    let singles = first_single(n, plates);
    let bits = f32::to_bits;
    for i in 0..n {
        let p = &points.position[i];
        let (cell, [x, y, z]) = cell_of(settings, p);
        let v = points.velocity[i].map(split);
        let s = points.stress[i].map(split);
        let volume = split(p[3]);
        let [plastic, gap] = [points.memory[i].plastic, points.memory[i].gap].map(split);
        let radius = (ghost_radius(points, i) / settings.cell * f64::from(UNITS)) as i32;
        let part = |s: &[[f32; 2]], last: [f32; 2], k: usize| [bits(s[0][k]), bits(s[1][k]), bits(s[2][k]), bits(last[k])];
        let words = [
            [x.1 as u32, y.1 as u32, z.1 as u32, cell],
            [bits(x.2), bits(y.2), bits(z.2), bits(points.initial_volume[i] as f32)],
            part(&v, v[3], 0),
            [bits(v[0][1]), bits(v[1][1]), bits(v[2][1]), u32::from(points.law[i])],
            part(&s[..3], volume, 0),
            part(&s[3..], plastic, 0),
            part(&s[..3], volume, 1),
            part(&s[3..], plastic, 1),
            [0, 0, bits(gap[0]), bits(gap[1])],
        ];
        for (plane, word) in words.into_iter().enumerate() {
            planes[plane * n + i] = word;
        }
        for (k, word) in [points.id[i], radius as u32].into_iter().enumerate() {
            planes[singles + k * n.div_ceil(4) + i / 4][i % 4] = word;
        }
        if let (true, Some([beside, face])) = (plates, points.faces.get(i)) {
            for a in (0..3).filter(|&a| beside[a] != 0.0) {
                let arm = split((face[a] - p[a]) / settings.cell).map(bits);
                (planes[PLANES * n + i][a], planes[(PLANES + 1) * n + i][a]) = (arm[0], arm[1]);
            }
        }
    }
    planes
}

/// Identities of the points and their indices on the device, in the order of identities.
pub fn by_id(planes: &[[u32; 4]], points: usize, plates: bool) -> Vec<(u32, u32)> {
    let ids = planes[first_single(points, plates)..].as_flattened();
    let mut all: Vec<(u32, u32)> = ids[..points].iter().copied().zip(0..).collect();
    all.sort_unstable();
    all
}

/// Writes the state of the points on the device into `points`; `from[i]` is the index on the device of the point `i`. Returns for each point its stress work since
/// the state was copied to the device, J. Masses, laws and initial values are not written.
pub fn to_points(settings: &Settings, planes: &[[u32; 4]], from: &[u32], points: &mut Points) -> Vec<f64> {
    let n = from.len();
    let has_faces = planes.len() == entries(n, true);
    points.faces.resize(if has_faces { n } else { points.faces.len() }, Face::default());
    let Points { position, velocity, stress, memory, faces, .. } = points;
    let works = (position.par_iter_mut(), velocity, stress, memory, from)
        .into_par_iter()
        .map(|(position, velocity, stress, memory, i)| {
            let words = WordsOfPoint::of(planes, n, *i);
            let [x, y, z] = words.position(settings);
            *position = [x, y, z, words.both(4, 6, 3)];
            for a in 0..3 {
                velocity[a] = words.both(2, 3, a);
                stress[a] = words.both(4, 6, a);
                stress[3 + a] = words.both(5, 7, a);
            }
            *memory = InternalVariables { plastic: words.both(5, 7, 3), gap: words.sum(8, 2) };
            words.sum(8, 0)
        })
        .collect();
    if has_faces {
        (faces.par_iter_mut(), position, from)
            .into_par_iter()
            .for_each(|(face, position, i)| *face = WordsOfPoint::of(planes, n, *i).face(settings, position));
    }
    works
}

/// The words of one point of the planes of all.
#[derive(Clone, Copy)]
struct WordsOfPoint<'a> {
    planes: &'a [[u32; 4]],
    points: usize,
    index: usize,
}

impl WordsOfPoint<'_> {
    fn of(planes: &[[u32; 4]], points: usize, index: u32) -> WordsOfPoint<'_> {
        WordsOfPoint { planes, points, index: index as usize }
    }

    fn word(self, plane: usize) -> [u32; 4] {
        self.planes[plane * self.points + self.index]
    }

    fn number(self, plane: usize, k: usize) -> f64 {
        f64::from(f32::from_bits(self.word(plane)[k]))
    }

    /// A number that is split into two planes.
    fn both(self, high: usize, low: usize, k: usize) -> f64 {
        self.number(high, k) + self.number(low, k)
    }

    /// A number that is split into two words of a plane, from `k` on.
    fn sum(self, plane: usize, k: usize) -> f64 {
        self.number(plane, k) + self.number(plane, k + 1)
    }

    fn position(self, settings: &Settings) -> [f64; 3] {
        let (units, rest) = (self.word(0), self.word(1));
        let cells = cell_place(units[3]);
        [0, 1, 2].map(|a| settings.lower[a] + settings.cell * placed(cells[a] as i32 - 1, units[a] as i32, f32::from_bits(rest[a])))
    }

    /// Places of the pressed faces, from the point and in space; `at`: the point's position.
    fn face(self, settings: &Settings, at: &[f64; 4]) -> Face {
        let beside = [0, 1, 2].map(|a| settings.cell * self.both(PLANES, PLANES + 1, a));
        [beside, [0, 1, 2].map(|a| at[a] + beside[a])]
    }
}
