//! Random shapes of rigid bodies: rounded polygons and polyhedra whose corners lie on an ellipse or ellipsoid, so that they are convex.

use engine::math::portable::sin;
use engine::math::vector::{dot, less};
use engine::shape::{Polygon, Polyhedron, Shape, convex_ring};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_2, TAU};

/// What the shapes of a set of bodies are drawn from; each pair has the least and the largest value.
#[derive(Clone, Debug, PartialEq)]
pub struct Shapes {
    /// Whether they are polygons of plane strain.
    pub flat: bool,
    /// Diameter of the disc of the same area, or of the sphere of the same volume, m.
    pub diameter: [f64; 2],
    /// Their corners, before they have a size.
    pub form: Form,
    /// Radius of the edges over the diameter.
    pub rounding: f64,
}

/// What the corners of shapes are drawn from; each pair has the least and the largest value.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// Corners on an ellipsoid or ellipse.
    Random {
        /// Number of corners.
        corners: [u32; 2],
        /// Longest over intermediate axis of the ellipsoid, or longer over shorter axis of the ellipse.
        elongation: [f64; 2],
        /// Intermediate over shortest axis of the ellipsoid.
        flatness: [f64; 2],
    },
    /// One of these outlines, with equal probability: the hull of its points, about their middle, in the unit of the radius of the sphere or disc of its volume or area.
    Listed(Vec<Vec<[f64; 3]>>),
}

impl Form {
    /// Outlines in any unit, at any place. `flat`: in plane strain.
    ///
    /// # Errors
    /// An outline that is no body: its number, and what is wrong with it.
    pub fn listed(outlines: &[Vec<[f64; 3]>], flat: bool) -> Result<Form, (usize, &'static str)> {
        let units = outlines.iter().enumerate().map(|(k, outline)| unit(outline, flat).map_err(|wrong| (k, wrong)));
        Ok(Form::Listed(units.collect::<Result<_, _>>()?))
    }
}

/// The points of an outline as in [`Form::Listed`].
fn unit(outline: &[[f64; 3]], flat: bool) -> Result<Vec<[f64; 3]>, &'static str> {
    if flat && outline.iter().any(|p| p[2] != 0.0) {
        return Err("has corners out of the plane");
    }
    let middle: [f64; 3] = std::array::from_fn(|a| {
        let (low, high) = outline.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[a]), h.max(p[a])));
        0.5 * (low + high)
    });
    let about: Vec<[f64; 3]> = outline.iter().map(|p| less(*p, middle)).collect();
    let most = about.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
    let nothing = if flat { "has no area" } else { "has no volume" };
    if most == 0.0 {
        return Err(nothing);
    }
    let near: Vec<[f64; 3]> = about.iter().map(|p| p.map(|x| x / most)).collect();
    let radius = rounded(&near, 0.0, flat).map_err(|_| nothing)?.radius();
    Ok(near.iter().map(|p| p.map(|x| x / radius)).collect())
}

/// The hull of points, m, with a sphere or disc of a radius, m, swept over it.
fn rounded(points: &[[f64; 3]], rounding: f64, flat: bool) -> Result<Shape, String> {
    if flat {
        let corners: Vec<[f64; 2]> = points.iter().map(|&[x, y, _]| [x, y]).collect();
        Ok(Shape::Polygon(Polygon::of(&convex_ring(&corners), rounding)?.0))
    } else {
        Ok(Shape::Polyhedron(Polyhedron::hull(points, rounding)?.polyhedron))
    }
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
        let diameter = between(self.diameter);
        let points = match &self.form {
            Form::Random { corners, elongation, flatness } => {
                let axes = [between(*elongation), 1.0, 1.0 / between(*flatness)];
                let corners = rng.random_range(corners[0]..=corners[1]);
                let unit = if self.flat { ring(corners, rng) } else { shell(corners, rng) };
                unit.iter().map(|p| std::array::from_fn(|a| axes[a] * p[a])).collect()
            }
            Form::Listed(outlines) => outlines[rng.random_range(0..outlines.len())].clone(),
        };
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
        let points: Vec<[f64; 3]> = points.iter().map(|p| p.map(|x| size * x)).collect();
        rounded(&points, self.rounding * diameter, self.flat)
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
            let corners = if flat { [3, 7] } else { [6, 20] };
            let shapes = Shapes {
                flat,
                diameter: [0.01, 0.03],
                form: Form::Random { corners, elongation: [1.0, 2.0], flatness: [1.0, 1.5] },
                rounding: 0.05,
            };
            let mut rng = ChaCha8Rng::seed_from_u64(3);
            let mut seen = [f64::INFINITY, 0.0];
            for _ in 0..40 {
                let shape = shapes.draw(&mut rng).expect("a shape");
                let (diameter, rounded) = (2.0 * shape.radius(), shape.rounded());
                assert!((0.0099..=0.0301).contains(&diameter), "{diameter}");
                assert!((rounded.rounding() / diameter / 0.05 - 1.0).abs() < 0.01, "{} of {diameter}", rounded.rounding());
                let [least, most] = corners.map(|n| n as usize);
                assert!((least..=most).contains(&rounded.corners().len()));
                seen = [seen[0].min(diameter), seen[1].max(diameter)];
            }
            assert!(seen[0] < 0.012 && seen[1] > 0.028, "{seen:?}");
        }
    }

    /// Outlines of any size and place come out in the size that is drawn, with the corners of their hulls, and each as often as the others.
    #[test]
    fn listed_outlines_are_drawn_in_the_size_that_was_asked_for() {
        let square: Vec<[f64; 3]> = [[10.0, 10.0], [30.0, 10.0], [30.0, 30.0], [10.0, 30.0]].map(|[x, y]| [x, y, 0.0]).into();
        // an L, whose hull has five corners
        let ell: Vec<[f64; 3]> =
            [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]].map(|[x, y]| [x, y, 0.0]).into();
        let cube: Vec<[f64; 3]> = (0..8).map(|k| std::array::from_fn(|a| f64::from(k >> a & 1))).collect();
        let tetrahedron = vec![[0.0; 3], [1e3, 0.0, 0.0], [0.0, 1e3, 0.0], [0.0, 0.0, 1e3]];
        for (flat, outlines, counts) in [(true, vec![square, ell], [4, 5]), (false, vec![cube, tetrahedron], [8, 4])] {
            let form = Form::listed(&outlines, flat).expect("bodies");
            let shapes = Shapes { flat, diameter: [0.02, 0.02], form, rounding: 0.05 };
            let mut rng = ChaCha8Rng::seed_from_u64(5);
            let mut seen = [0; 2];
            for _ in 0..200 {
                let shape = shapes.draw(&mut rng).expect("a shape");
                let rounded = shape.rounded();
                assert!((2.0 * shape.radius() / 0.02 - 1.0).abs() < 0.01 && (rounded.rounding() - 1e-3).abs() < 1e-12);
                seen[counts.iter().position(|n| *n == rounded.corners().len()).expect("an outline")] += 1;
            }
            assert!(seen.iter().all(|n| *n > 70), "{seen:?}");
        }
        let line = vec![[0.0; 3], [1.0, 0.0, 0.0]];
        assert_eq!(Form::listed(&[line], true), Err((0, "has no area")));
        assert_eq!(Form::listed(&[vec![[2.0; 3]; 5]], false), Err((0, "has no volume")));
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
