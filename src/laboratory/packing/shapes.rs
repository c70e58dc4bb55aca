//! Random shapes of rigid bodies: rounded polygons and polyhedra whose corners lie on an ellipse or ellipsoid, so that they are convex.

use engine::math::portable::sin;
use engine::math::vector::{dot, less};
use engine::shape::{Polygon, Polyhedron, Shape};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_2, TAU};

/// What the shapes of a set of bodies are drawn from; each pair has the least and the largest value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shapes {
    /// Whether they are polygons of plane strain.
    pub flat: bool,
    /// Diameter of the disc of the same area, or of the sphere of the same volume, m.
    pub diameter: [f64; 2],
    /// Number of corners.
    pub corners: [u32; 2],
    /// Longest over intermediate axis of the ellipsoid, or longer over shorter axis of the ellipse.
    pub elongation: [f64; 2],
    /// Intermediate over shortest axis of the ellipsoid.
    pub flatness: [f64; 2],
    /// Radius of the edges over the diameter.
    pub rounding: f64,
}

/// Part of the mean angle between two corners by which each is at most away from its place among corners at equal angles.
const UNEVEN: f64 = 0.35;
/// Random places of which a corner of a polyhedron takes the one that is furthest from those before it.
const CHOICE: u32 = 8;
/// Times that a shape is made to find the size of its core under its rounding.
const ROUNDS: u32 = 2;

impl Shapes {
    /// Draws a shape.
    ///
    /// # Errors
    /// A rounding so large that nothing is left within it.
    pub fn draw(&self, rng: &mut ChaCha8Rng) -> Result<Shape, String> {
        let mut between = |[low, high]: [f64; 2]| low + (high - low) * rng.random::<f64>();
        let (diameter, elongation, flatness) = (between(self.diameter), between(self.elongation), between(self.flatness));
        let corners = rng.random_range(self.corners[0]..=self.corners[1]);
        let unit = if self.flat { ring(corners, rng) } else { shell(corners, rng) };
        let axes = [elongation, 1.0, 1.0 / flatness];
        let points: Vec<[f64; 3]> = unit.iter().map(|p| std::array::from_fn(|a| axes[a] * p[a])).collect();
        let mut size = 0.5 * diameter;
        let mut shape = self.of(&points, size, diameter)?;
        for _ in 0..ROUNDS {
            // the core is what the rounding leaves of the diameter
            let core = 2.0 * (shape.radius() - self.rounding * diameter);
            size *= ((1.0 - 2.0 * self.rounding) * diameter / core).max(0.0);
            shape = self.of(&points, size, diameter)?;
        }
        Ok(shape)
    }

    fn of(&self, points: &[[f64; 3]], size: f64, diameter: f64) -> Result<Shape, String> {
        let rounding = self.rounding * diameter;
        let points = points.iter().map(|p| p.map(|x| size * x));
        if self.flat {
            let corners: Vec<[f64; 2]> = points.map(|[x, y, _]| [x, y]).collect();
            Ok(Shape::Polygon(Polygon::of(&corners, rounding)?.0))
        } else {
            Ok(Shape::Polyhedron(Polyhedron::hull(&points.collect::<Vec<_>>(), rounding)?.polyhedron))
        }
    }
}

/// Points around the unit circle at about equal angles.
fn ring(count: u32, rng: &mut ChaCha8Rng) -> Vec<[f64; 3]> {
    let turns: Vec<f64> =
        (0..count).map(|k| (f64::from(k) + UNEVEN * (2.0 * rng.random::<f64>() - 1.0)) / f64::from(count)).collect();
    turns.into_iter().map(|turn| direction(turn.rem_euclid(1.0))).collect()
}

/// The direction at a part of a turn, 0 to 1, from the first axis.
fn direction(turn: f64) -> [f64; 3] {
    let quarter = (4.0 * turn).floor();
    let angle = TAU * (turn - 0.25 * quarter);
    let (s, c) = (sin(angle), sin(FRAC_PI_2 - angle));
    match quarter as u32 % 4 {
        0 => [c, s, 0.0],
        1 => [-s, c, 0.0],
        2 => [-c, -s, 0.0],
        _ => [s, -c, 0.0],
    }
}

/// Points on the unit sphere, away from each other.
fn shell(count: u32, rng: &mut ChaCha8Rng) -> Vec<[f64; 3]> {
    let mut points: Vec<[f64; 3]> = Vec::new();
    for _ in 0..count {
        let apart = |p: &[f64; 3]| {
            let square = |q: &[f64; 3]| dot(less(*p, *q), less(*p, *q));
            points.iter().map(square).fold(f64::INFINITY, f64::min)
        };
        let places: Vec<[f64; 3]> = (0..CHOICE).map(|_| on_sphere(rng)).collect();
        let best = places.iter().fold((places[0], f64::NEG_INFINITY), |best, p| {
            let d = apart(p);
            if d > best.1 { (*p, d) } else { best }
        });
        points.push(best.0);
    }
    points
}

/// A random point of the unit sphere: of the ball between two spheres, moved outwards.
fn on_sphere(rng: &mut ChaCha8Rng) -> [f64; 3] {
    loop {
        let p: [f64; 3] = std::array::from_fn(|_| 2.0 * rng.random::<f64>() - 1.0);
        let square = dot(p, p);
        if (0.01..=1.0).contains(&square) {
            return p.map(|x| x / square.sqrt());
        }
    }
}

/// A random orientation, as unit quaternion; of a flat body about the third axis.
pub fn orientation(flat: bool, rng: &mut ChaCha8Rng) -> [f64; 4] {
    loop {
        let q: [f64; 4] = std::array::from_fn(|a| if flat && (a == 1 || a == 2) { 0.0 } else { 2.0 * rng.random::<f64>() - 1.0 });
        let square: f64 = q.iter().map(|x| x * x).sum();
        if (0.01..=1.0).contains(&square) {
            return q.map(|x| x / square.sqrt());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn shapes_have_the_size_corners_and_rounding_that_were_asked_for() {
        for flat in [true, false] {
            let shapes = Shapes {
                flat,
                diameter: [0.01, 0.03],
                corners: if flat { [3, 7] } else { [6, 20] },
                elongation: [1.0, 2.0],
                flatness: [1.0, 1.5],
                rounding: 0.05,
            };
            let mut rng = ChaCha8Rng::seed_from_u64(3);
            let mut seen = [f64::INFINITY, 0.0];
            for _ in 0..40 {
                let shape = shapes.draw(&mut rng).expect("a shape");
                let (diameter, rounded) = (2.0 * shape.radius(), shape.rounded().expect("corners"));
                assert!((0.0099..=0.0301).contains(&diameter), "{diameter}");
                assert!((rounded.rounding() / diameter / 0.05 - 1.0).abs() < 0.01, "{} of {diameter}", rounded.rounding());
                let [least, most] = shapes.corners.map(|n| n as usize);
                assert!((least..=most).contains(&rounded.corners().len()));
                seen = [seen[0].min(diameter), seen[1].max(diameter)];
            }
            assert!(seen[0] < 0.012 && seen[1] > 0.028, "{seen:?}");
        }
    }

    #[test]
    fn directions_go_once_around() {
        for k in 0..40 {
            let turn = f64::from(k) / 40.0;
            let [x, y, _] = direction(turn);
            assert!((x - (TAU * turn).cos()).abs() < 1e-12 && (y - (TAU * turn).sin()).abs() < 1e-12, "{turn}");
        }
    }
}
