//! Grains, contacts and walls as the device holds them, in words of 32 bits, and back.

use super::layout::{CONTACT, GRAIN, NO_FACE, NODES, NONE, Side, WALLS, WITH_FINES};
use crate::boundary::Wall;
use crate::boundary::WallShape;
use crate::contact::pairs::ContactForce;
use crate::coupling::Body;
use crate::coupling::exchange::ExchangedContact;
use crate::gpu::bounds::PARTNERS;
use crate::gpu::exact::{place, placed, split};
use crate::gpu::loading_plate::shell_split;
use crate::grains::Grains;
use crate::mpm::Settings;
use crate::point_contacts::GhostFace;

const BITS: fn(f32) -> u32 = f32::to_bits;

/// In place of infinity, which shaders need not have.
const HUGE: f64 = 1e38;

/// A contact: its owner (a grain, or a point) and its four planes of four words each, the fourth of which is the body that the owner touches.
pub type ContactWords = [u32; 1 + 4 * CONTACT];

/// A contact of a point: the same, and the further planes.
pub type PointContactWords = [u32; 1 + 4 * WITH_FINES];

// Where the words of a contact's planes begin that hold its normal, overlap (last), face, place of the force, and overlap without force.
const NORMAL: usize = 5;
const TANGENT: usize = 9;
const FACE: usize = 17;
const PLACE: usize = 21;
const REFERENCE: usize = 25;

/// What contacts have pressed on a node of a point so far in a step of the continuum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// Point, by its number on the device.
    pub point: u32,
    /// The node along each axis: the first, middle or last (0, 1, 2) of those that the point reaches.
    pub node: [usize; 3],
    /// Sum of the forces over the steps of the grains, N.
    pub force: [f64; 3],
}

/// The forces on the nodes of the points in `used` rows, by row, then by node, of the words of these rows: for each node of a point a word for each row, then the
/// owners.
pub fn pushes(rows: &[[u32; 4]], used: usize) -> Vec<Push> {
    let owner = |r: usize| rows[NODES * used + r];
    let push =
        |r: usize, k: usize| Push { point: owner(r)[0], node: [k % 3, k / 3 % 3, k / 9], force: three(&rows[k * used + r], 0) };
    (0..used)
        .filter(|r| owner(*r)[1] != 0)
        .flat_map(|r| (0..NODES).map(move |k| (r, k)))
        .map(|(r, k)| push(r, k))
        .filter(|p| p.force != [0.0; 3])
        .collect()
}

/// The planes of all grains, in the order of their identities; radii are also given in quanta of 2^-`parts` cells.
pub fn grains(settings: &Settings, g: &Grains, parts: u32) -> Vec<[u32; 4]> {
    let n = g.len();
    let mut planes = vec![[0; 4]; GRAIN * n];
    for (k, i) in g.by_id().into_iter().map(|i| i as usize).enumerate() {
        let p = g.pos[i];
        let at: [(i32, i32, f32); 3] = std::array::from_fn(|a| place((p[a] - settings.lower[a]) / settings.cell));
        let radius = p[3] / settings.cell * f64::from(1_u32 << parts);
        let whole = radius.round();
        let (v, w) = (g.vel[i].map(split), g.spin[i].map(split));
        let three = |x: [[f32; 2]; 4], k: usize, last: u32| [BITS(x[0][k]), BITS(x[1][k]), BITS(x[2][k]), last];
        let words = [
            [at[0].1 as u32, at[1].1 as u32, at[2].1 as u32, g.material[i].into()],
            [at[0].0 as u32, at[1].0 as u32, at[2].0 as u32, whole as i32 as u32],
            [BITS(at[0].2), BITS(at[1].2), BITS(at[2].2), BITS((radius - whole) as f32)],
            three(v, 0, BITS(g.mass[i] as f32)),
            three(v, 1, BITS(p[3] as f32)),
            three(w, 0, BITS(g.breakage_threshold[i].min(HUGE) as f32)),
            three(w, 1, g.id[i]),
        ];
        for (plane, word) in words.into_iter().enumerate() {
            planes[plane * n + k] = word;
        }
    }
    planes
}

/// Writes position, velocity and spin of the `k`-th grain by identity into the grain `i` of `g`.
pub fn to_grain(settings: &Settings, planes: &[[u32; 4]], k: usize, g: &mut Grains, i: usize) {
    let n = planes.len() / GRAIN;
    let number = |plane: usize, a: usize| f32::from_bits(planes[plane * n + k][a]);
    let both = |plane: usize, a: usize| f64::from(number(plane, a)) + f64::from(number(plane + 1, a));
    let place = |a: usize| {
        let [units, cell] = [0, 1].map(|plane| planes[plane * n + k][a] as i32);
        settings.lower[a] + settings.cell * placed(cell, units, number(2, a))
    };
    for (to, of) in
        [(&mut g.pos[i], &place as &dyn Fn(usize) -> f64), (&mut g.vel[i], &|a| both(3, a)), (&mut g.spin[i], &|a| both(5, a))]
    {
        to.iter_mut().take(3).enumerate().for_each(|(a, x)| *x = of(a));
    }
}

/// The number of a body on the device.
pub fn body(body: Body) -> u32 {
    match body {
        Body::Grain(k) => k,
        Body::Wall(k) => WALLS + k,
    }
}

/// The words of a contact; `owner` is a grain or a point.
pub fn contact_words(owner: u32, body: u32, c: &ExchangedContact) -> ContactWords {
    let spring = c.spring.map(split);
    let (n, t) = (c.touch.normal.map(|x| BITS(x as f32)), c.touch.tangential.map(|x| BITS(x as f32)));
    let [high, low] = [0, 1].map(|k| spring.map(|s| BITS(s[k])));
    let last = [body, BITS(c.touch.normal_force as f32), BITS(c.touch.overlap as f32), BITS(c.stiffness as f32)];
    let mut words: ContactWords = [owner; 1 + 4 * CONTACT];
    for (plane, (three, last)) in [high, n, t, low].into_iter().zip(last).enumerate() {
        words[1 + 4 * plane..4 + 4 * plane].copy_from_slice(&three);
        words[4 + 4 * plane] = last;
    }
    words
}

/// The contact of some words, without its ends.
pub fn contact(words: &ContactWords, viscous: bool) -> ExchangedContact {
    let number = |k: usize| f64::from(f32::from_bits(words[1 + k]));
    let three = |plane: usize| [0, 1, 2].map(|k| number(4 * plane + k));
    let (high, low) = (three(0), three(3));
    let spring: [f64; 3] = std::array::from_fn(|a| high[a] + low[a]);
    // without dashpots the tangential force is that of the spring, which is known more accurately
    let tangential = if viscous { three(2) } else { spring };
    let touch = ContactForce { tangential, normal_force: number(7), normal: three(1), overlap: number(11) };
    ExchangedContact { ends: [0; 2], touch, spring, stiffness: number(15), reference: 0.0, face: None }
}

/// The words of a contact of the point `point`; `cell`: edge of a cell, m.
pub fn point_contact_words(point: u32, body: u32, c: &ExchangedContact, cell: f64) -> PointContactWords {
    let mut words: PointContactWords = [0; _];
    let own = contact_words(point, body, c);
    words[..own.len()].copy_from_slice(&own);
    words[REFERENCE..REFERENCE + 2].copy_from_slice(&split(c.reference).map(BITS));
    let Some(face) = &c.face else {
        // contacts at centres have no faces, but their overlaps
        if c.touch.overlap <= 0.0 {
            words[TANGENT + 3] = BITS(NO_FACE);
        }
        return words;
    };
    let beyond = split(face.beyond / cell);
    words[NORMAL..NORMAL + 3].copy_from_slice(&face.normal.map(|x| BITS(x as f32)));
    words[FACE..FACE + 3].copy_from_slice(&face.velocity.map(|x| BITS(x as f32)));
    (words[FACE + 3], words[PLACE + 3]) = (BITS(beyond[0]), BITS(beyond[1]));
    words
}

/// Three numbers from `at` on.
fn three(words: &[u32], at: usize) -> [f64; 3] {
    [0, 1, 2].map(|a| f64::from(f32::from_bits(words[at + a])))
}

/// The contact of a point of some words, without its ends.
pub fn point_contact(words: &PointContactWords, viscous: bool, cell: f64) -> ExchangedContact {
    let own: &ContactWords = words.first_chunk().expect("it begins as any contact");
    let number = |k: usize| f64::from(f32::from_bits(words[k]));
    let (beyond, velocity) = (cell * (number(FACE + 3) + number(PLACE + 3)), three(words, FACE));
    let face = GhostFace { normal: three(words, NORMAL), beyond, velocity };
    let of_touch = contact(own, viscous);
    let apart = of_touch.touch.overlap <= 0.0;
    let touch = if apart { ContactForce::default() } else { of_touch.touch };
    let reference = number(REFERENCE) + number(REFERENCE + 1);
    ExchangedContact { touch, reference, face: (of_touch.touch.overlap >= 0.0).then_some(face), ..of_touch }
}

/// The first `planes` planes of all contacts of `owners` owners with room for `room` contacts each, as the buffers `slots` and `rows` have them: by plane, then by place,
/// then by owner. `place` gives the place of a contact from the number of places its owner has used.
pub fn spread<const WORDS: usize>(
    kept: &[[u32; WORDS]],
    [planes, room, owners]: [usize; 3],
    place: impl Fn(&[u32; WORDS], usize) -> usize,
) -> Vec<[u32; 4]> {
    let mut all = vec![[0; 4]; planes * room * owners];
    for entry in &mut all[..room * owners] {
        entry[3] = NONE;
    }
    let mut filled = vec![0; owners];
    for words in kept {
        let owner = words[0] as usize;
        let next = filled[owner];
        let s = place(words, next);
        if s == next {
            filled[owner] += 1;
        }
        for plane in 0..planes {
            all[(plane * room + s) * owners + owner].copy_from_slice(&words[1 + 4 * plane..5 + 4 * plane]);
        }
    }
    all
}

/// The contacts that are to be kept, in the order of owners, then of places; the inverse of [`spread`].
pub fn collect<const WORDS: usize>(
    all: &[[u32; 4]],
    [planes, room, owners]: [usize; 3],
    keeps: impl Fn(&[u32; WORDS]) -> bool,
) -> Vec<[u32; WORDS]> {
    let mut kept = Vec::new();
    for owner in 0..owners {
        for s in 0..room {
            let entry = |plane: usize| all[(plane * room + s) * owners + owner];
            // the slots of walls that a grain has never touched have no body
            if entry(0)[3] == NONE {
                continue;
            }
            let mut words = [0; WORDS];
            words[0] = owner as u32;
            (0..planes).for_each(|plane| words[1 + 4 * plane..5 + 4 * plane].copy_from_slice(&entry(plane)));
            if keeps(&words) {
                kept.push(words);
            }
        }
    }
    kept
}

/// Whether a contact touches.
pub fn touches(words: &ContactWords) -> bool {
    f32::from_bits(words[TANGENT + 3]) > 0.0
}

/// Whether a contact of a point has a face or an overlap without force.
pub fn is_kept(words: &PointContactWords) -> bool {
    f32::from_bits(words[TANGENT + 3]) > NO_FACE || f32::from_bits(words[REFERENCE]) > 0.0
}

/// By how much the face of a contact of a point is beyond its ghost, cells.
pub fn beyond(words: &PointContactWords) -> f32 {
    f32::from_bits(words[FACE + 3])
}

/// The slot of a contact of a grain: for a wall the one that belongs to it, otherwise the next free one.
pub fn slot(words: &ContactWords, next: usize) -> usize {
    if words[4] >= WALLS { PARTNERS + (words[4] - WALLS) as usize } else { next }
}

/// State of a wall on the device; `plate`: index of the loading plate that it moves with, or [`NONE`].
pub fn side(settings: &Settings, wall: &Wall, plate: u32) -> Side {
    let at = |axis: usize, x: f64| place((x - settings.lower[axis]) / settings.cell);
    let (own, (cell, units, rest)) = match wall.shape {
        WallShape::Plane { point, normal } => {
            let axis = axis(normal);
            (Side { axis: axis as u32, normal: normal[axis] as f32, ..Side::default() }, at(axis, point[axis]))
        }
        WallShape::Cylinder { centre, radius } => {
            let [x, y] = [0, 1].map(|axis| at(axis, centre[axis]));
            let own = Side {
                normal: -1.0,
                shell: 1,
                split: shell_split(radius / settings.cell),
                centre_cell: [x.0, y.0],
                centre_units: [x.1, y.1],
                centre_rest: [x.2, y.2],
                ..Side::default()
            };
            (own, place(radius / settings.cell))
        }
    };
    Side {
        cell,
        units,
        rest,
        speed: wall.speed as f32,
        plate,
        reaction: wall.reaction as f32,
        stiffness: wall.stiffness as f32,
        ..own
    }
}

/// The axis along which a normal points.
pub fn axis(normal: [f64; 3]) -> usize {
    (0..3).find(|&a| normal[a] != 0.0).unwrap_or(0)
}

/// Writes the state of a wall on the device into `wall`; its work is `before`, J, plus that on the device.
pub fn to_wall(settings: &Settings, side: &Side, before: f64, wall: &mut Wall) {
    let axis = side.axis as usize;
    let at = settings.cell * placed(side.cell, side.units, side.rest);
    match &mut wall.shape {
        WallShape::Plane { point, .. } => point[axis] = settings.lower[axis] + at,
        WallShape::Cylinder { radius, .. } => *radius = at,
    }
    (wall.speed, wall.reaction, wall.stiffness) = (side.speed.into(), side.reaction.into(), side.stiffness.into());
    wall.work = before + f64::from(side.work[0]) + f64::from(side.work[1]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::bounds::{PLACES, SLOTS};

    fn contact_of(x: f64) -> ExchangedContact {
        let spring = [0.3 * x, -1.7 * x, 1e-7 * x];
        let touch = ContactForce { tangential: spring, normal_force: 2.5 * x, normal: [0.0, 0.6, -0.8], overlap: 1e-6 * x };
        ExchangedContact { ends: [0; 2], touch, spring, stiffness: 1e5 * x, reference: 0.0, face: None }
    }

    /// What goes there comes back: contacts within f32, springs within two of them, each at its owner and place.
    #[test]
    fn contacts_come_back() {
        let given = [
            contact_words(0, 2, &contact_of(1.0)),
            contact_words(0, 7, &contact_of(2.0)),
            contact_words(0, WALLS + 3, &contact_of(3.0)),
            contact_words(2, 0, &contact_of(1.0)),
        ];
        let all = spread(&given, [CONTACT, SLOTS, 3], slot);
        let places: Vec<usize> = (0..SLOTS).filter(|s| all[s * 3][3] != NONE).collect();
        assert_eq!(places, [0, 1, PARTNERS + 3]);
        assert_eq!(collect(&all, [CONTACT, SLOTS, 3], touches), given);
        for (words, x) in given.iter().zip([1.0, 2.0, 3.0, 1.0]) {
            let (there, here) = (contact(words, false), contact_of(x));
            for a in 0..3 {
                assert!((there.spring[a] - here.spring[a]).abs() <= 1e-14 * here.spring[a].abs());
                assert!((there.touch.normal[a] - here.touch.normal[a]).abs() < 1e-7);
            }
            assert!((there.touch.overlap / here.touch.overlap - 1.0).abs() < 1e-7);
            assert!((there.stiffness / here.stiffness - 1.0).abs() < 1e-7);
            assert_eq!(there.touch.tangential, there.spring);
        }
    }

    /// Contacts of points come back with their faces and overlaps without force, those that have one of the two and do not touch too; others are dropped.
    #[test]
    fn contacts_of_points_come_back_with_their_faces() {
        let (cell, n) = (0.005, [0.0, 0.6, -0.8]);
        let face = |beyond| Some(GhostFace { normal: n, beyond, velocity: [0.25, -3.0, 1e-3] });
        let given = [
            ExchangedContact { face: face(1.2345678e-3), ..contact_of(1.0) },
            ExchangedContact { face: face(-4.321e-4), ..ExchangedContact::default() },
            ExchangedContact { reference: 3.21987654e-5, ..ExchangedContact::default() },
            ExchangedContact::default(),
        ];
        let words: Vec<PointContactWords> = (0..).zip(&given).map(|(k, c)| point_contact_words(0, k, c, cell)).collect();
        let sizes = [WITH_FINES, PLACES, 1];
        let back = collect(&spread(&words, sizes, |_, next| next), sizes, is_kept);
        assert_eq!(back, words[..3]);
        let held = point_contact(&back[2], false, cell);
        assert!((held.reference / given[2].reference - 1.0).abs() < 1e-13 && held.face.is_none() && held.touch.overlap == 0.0);
        for (words, given) in back[..2].iter().zip(&given) {
            let there = point_contact(words, false, cell);
            let (own, of) = (there.face.expect("a face"), given.face.expect("a face"));
            assert!((own.beyond - of.beyond).abs() < 1e-13 * of.beyond.abs(), "{own:?}");
            assert!((0..3).all(|a| (own.normal[a] - n[a]).abs() < 1e-7 && (own.velocity[a] - of.velocity[a]).abs() < 1e-9));
            assert!((there.touch.overlap - given.touch.overlap).abs() < 1e-13);
        }
        assert_eq!(point_contact(&back[1], false, cell).touch, ContactForce::default());
    }
}
