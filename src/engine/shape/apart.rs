//! Nearest points of two convex bodies of which only the furthest points along directions are known (Gilbert, Johnson & Keerthi 1988).

use crate::math::vector::{cross, dot, less, plus, scaled};

/// The nearest points of two bodies that are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apart {
    /// Unit vector from the first to the second.
    pub normal: [f64; 3],
    /// Distance, m; 0 for bodies that cut each other, whose other numbers mean nothing.
    pub distance: f64,
    /// Nearest point of the first, m.
    pub on_first: [f64; 3],
}

/// A point of the first body less one of the second, and that of the first.
#[derive(Clone, Copy)]
struct Corner {
    between: [f64; 3],
    on_first: [f64; 3],
}

/// The point nearest to the origin of the hull of some corners, with the corners that it lies among and their weights.
#[derive(Clone, Copy)]
struct Foot {
    corners: [Corner; 3],
    weights: [f64; 3],
    count: usize,
    at: [f64; 3],
    square: f64,
}

/// Most rounds; it ends when the distance does not become less.
const ROUNDS: usize = 200;
/// Share of the square of the distance that it may still become less at the end.
const EXACT: f64 = 1e-14;

impl Foot {
    /// The point of these corners with these weights, whose sum is 1.
    fn of<const N: usize>(corners: [Corner; N], weights: [f64; N]) -> Foot {
        let at = (0..N).fold([0.0; 3], |sum, k| plus(sum, scaled(corners[k].between, weights[k])));
        let (mut all, mut shares) = ([corners[0]; 3], [0.0; 3]);
        all[..N].copy_from_slice(&corners);
        shares[..N].copy_from_slice(&weights);
        Foot { corners: all, weights: shares, count: N, at, square: dot(at, at) }
    }

    /// The nearest point of an edge between its ends.
    fn on_edge(p: Corner, new: Corner) -> Option<Foot> {
        let along = less(p.between, new.between);
        let (length, t) = (dot(along, along), -dot(along, new.between));
        (t > 0.0 && t < length).then(|| Foot::of([p, new], [t / length, 1.0 - t / length]))
    }

    /// The nearest point of a triangle between its edges.
    fn on_face(p: Corner, q: Corner, new: Corner) -> Option<Foot> {
        let (u, v) = (less(p.between, new.between), less(q.between, new.between));
        let normal = cross(u, v);
        let area = dot(normal, normal);
        let from = scaled(new.between, -1.0);
        let (s, t) = (dot(cross(from, v), normal), dot(cross(u, from), normal));
        (s > 0.0 && t > 0.0 && s + t < area).then(|| {
            let [s, t] = [s, t].map(|x| x / area);
            Foot::of([p, q, new], [s, t, 1.0 - s - t])
        })
    }

    /// Whether the origin lies in the tetrahedron of three corners and a new one.
    fn inside([p, q, r]: [Corner; 3], new: Corner) -> bool {
        let [u, v, w] = [p, q, r].map(|c| less(c.between, new.between));
        let from = scaled(new.between, -1.0);
        let volume = dot(u, cross(v, w));
        let side = |x: f64| x * volume > 0.0;
        let [a, b, c] = [dot(from, cross(v, w)), dot(u, cross(from, w)), dot(u, cross(v, from))];
        side(a) && side(b) && side(c) && side(volume - (a + b + c))
    }

    /// The nearest point of the hull of the corners and a new one; `None`: the origin lies in it. The new corner is nearer to the origin along the old foot than
    /// the others, so it takes part.
    fn with(&self, new: Corner) -> Option<Foot> {
        let old = &self.corners[..self.count];
        if let &[p, q, r] = old
            && Foot::inside([p, q, r], new)
        {
            return None;
        }
        let mut best = Foot::of([new], [1.0]);
        let mut take = |foot: Option<Foot>| {
            if let Some(foot) = foot.filter(|foot| foot.square < best.square) {
                best = foot;
            }
        };
        for (k, &p) in old.iter().enumerate() {
            take(Foot::on_edge(p, new));
            for &q in &old[k + 1..] {
                take(Foot::on_face(p, q, new));
            }
        }
        Some(best)
    }
}

/// The nearest points of two convex bodies, each given by its furthest point along a unit vector; `None` where they are further from each other than `beyond`, m.
/// `start`: unit vector, about from the first to the second. `rough`: share of the square of the distance that it may still become less; 0 for the best there is.
pub fn apart(
    first: impl Fn([f64; 3]) -> [f64; 3],
    second: impl Fn([f64; 3]) -> [f64; 3],
    start: [f64; 3],
    [beyond, rough]: [f64; 2],
) -> Option<Apart> {
    let corner = |towards: [f64; 3]| {
        let on_first = first(towards);
        Corner { between: less(on_first, second(scaled(towards, -1.0))), on_first }
    };
    let cut = Apart { normal: start, distance: 0.0, on_first: [0.0; 3] };
    let mut foot = Foot::of([corner(start)], [1.0]);
    for _ in 0..ROUNDS {
        let distance = foot.square.sqrt();
        if distance == 0.0 {
            return Some(cut);
        }
        let new = corner(scaled(foot.at, -1.0 / distance));
        let along = dot(foot.at, new.between);
        if along > beyond * distance {
            return None;
        }
        if foot.square - along <= rough.max(EXACT) * foot.square {
            break;
        }
        match foot.with(new) {
            None => return Some(cut),
            Some(next) if next.square < foot.square => foot = next,
            Some(_) => break,
        }
    }
    let distance = foot.square.sqrt();
    let on_first = (0..foot.count).fold([0.0; 3], |sum, k| plus(sum, scaled(foot.corners[k].on_first, foot.weights[k])));
    (rough > 0.0 || distance <= beyond).then(|| Apart { normal: scaled(foot.at, -1.0 / distance), distance, on_first })
}
