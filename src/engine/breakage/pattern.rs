//! Into which daughters a grain breaks: balls inside its sphere that do not overlap (Ciantia et al. 2015, Fig. 3, Table 5, Appendix). Lengths are over the
//! mother's radius; the axes are x', y', z', with z' along the decisive force.
//!
//! The pattern of two is two balls of half the mother's radius on the axis x'. All larger patterns come from one construction in the mother's sphere. It begins
//! with three equal balls that touch each other and the sphere, with their centres in the plane z' = 0, the first on +y', and the ball above them that touches all
//! three and the sphere. These are five spheres of which each touches the other four. From any such five the next ones follow: leave one out, and there is exactly
//! one other sphere that touches the remaining four. With the curvature b = 1/r (-1 for the mother, which is touched from inside) and the centre c, the sphere b, c
//! left out and the new one b', c' satisfy the linear form of Soddy's theorem for spheres,
//!
//! ```text
//! b + b' = b1 + b2 + b3 + b4,      b c + b' c' = b1 c1 + b2 c2 + b3 c3 + b4 c4
//! ```
//!
//! A pattern is the largest balls found in this way, in whole size classes. Radius and number of the classes: 0.4641 x 3, 0.3660 x 2, 0.2573 x 6, 0.2240 x 3,
//! 0.1780 x 12, 0.1360 x 12, 0.1261 x 12, 0.1101 x 18.

use std::collections::HashSet;

/// Numbers of daughters for which there is a pattern.
pub const COUNTS: [u32; 7] = [2, 5, 14, 26, 38, 50, 68];

/// Largest curvature of the balls generated: above that of the smallest class used, 9.08, and below the next.
const LARGEST_CURVATURE: f64 = 1.0 / 0.105;

/// Coordinates and radii that differ by less than this count as the same.
const RESOLUTION: f64 = 1e-9;

/// One daughter in the mother's frame, over the mother's radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Centre, -.
    pub centre: [f64; 3],
    /// Radius, -.
    pub radius: f64,
}

/// The daughters of a mother of radius 1, sorted by radius from large to small, then by z' and then by y' from high to low, then by x' from low to high.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    balls: Vec<Ball>,
    volume_kept: f64,
    smallest: f64,
}

impl Pattern {
    /// The pattern with `count` daughters.
    ///
    /// # Errors
    /// Where `count` is none of [`COUNTS`]; the message lists them.
    pub fn new(count: u32) -> Result<Self, String> {
        let balls = match count {
            2 => vec![ball(-0.5, 0.0, 0.0, 0.5), ball(0.5, 0.0, 0.0, 0.5)],
            _ if COUNTS.contains(&count) => {
                let mut balls = gasket();
                balls.truncate(count as usize);
                balls
            }
            _ => {
                let known = COUNTS.map(|n| n.to_string()).join(", ");
                return Err(format!("no pattern of {count} daughters; there are {known}"));
            }
        };
        let volume_kept = balls.iter().map(|b| b.radius * b.radius * b.radius).sum();
        let smallest = balls.iter().map(|b| b.radius).fold(1.0, f64::min);
        Ok(Self { balls, volume_kept, smallest })
    }

    /// The daughters.
    pub fn balls(&self) -> &[Ball] {
        &self.balls
    }

    /// Number of daughters.
    pub fn count(&self) -> usize {
        self.balls.len()
    }

    /// Volume of all daughters together over that of the mother, -.
    pub fn volume_kept(&self) -> f64 {
        self.volume_kept
    }

    /// Radius of the smallest daughter over that of the mother, -.
    pub fn smallest(&self) -> f64 {
        self.smallest
    }

    /// Size classes, the largest first: radius over that of the mother, and number of daughters.
    pub fn classes(&self) -> Vec<(f64, usize)> {
        let mut classes: Vec<(f64, usize)> = Vec::new();
        for ball in &self.balls {
            match classes.last_mut() {
                Some((radius, count)) if key(*radius) == key(ball.radius) => *count += 1,
                _ => classes.push((ball.radius, 1)),
            }
        }
        classes
    }

    /// Centres and radii, m, of the daughters of a mother with this centre and radius, m. The axis z' of the pattern is the unit vector `axis` (the direction of
    /// the decisive force), x' is `perpendicular`, a unit vector at right angles to it, and y' = z' × x'.
    pub fn daughters(
        &self,
        centre: [f64; 3],
        radius: f64,
        axis: [f64; 3],
        perpendicular: [f64; 3],
    ) -> impl ExactSizeIterator<Item = ([f64; 3], f64)> {
        let [x, z] = [perpendicular, axis];
        let y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]];
        self.balls.iter().map(move |ball| {
            let [a, b, c] = ball.centre;
            let at = |k: usize| centre[k] + radius * (a * x[k] + b * y[k] + c * z[k]);
            ([at(0), at(1), at(2)], radius * ball.radius)
        })
    }
}

/// How a pattern is turned about its axis z'.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Azimuth {
    /// By a random angle, keyed by the lineage of the grain.
    Random,
    /// As two rotations turn it from the axes of space to the force ([`turned_from_space`]).
    Fixed,
}

/// The axes z' and x' of a pattern that is turned to the direction `axis`, a unit vector whose sense means nothing, from the axes of space: first about y, then
/// about x, each by at most a quarter turn (Ciantia et al. 2015, Appendix: "two subsequent rotations; one with respect to the y' axis and the other with respect
/// to the x' axis"). The rotations by β about y, sin β = n_x, and by α about x, tan α = −n_y/n_z, take (0, 0, 1) to n with n_z ≥ 0 and (1, 0, 0) to what is
/// left of it at right angles to n. Where n is along x, only the first is made.
pub fn turned_from_space(axis: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let [x, y, z] = axis;
    // of the two senses the one that points up; without one, that along +y, then that along +x
    let down = if z != 0.0 {
        z < 0.0
    } else if y != 0.0 {
        y < 0.0
    } else {
        x < 0.0
    };
    let [x, y, z] = if down { [-x, -y, -z] } else { axis };
    let cosine = (y * y + z * z).sqrt();
    let side = if cosine > 0.0 { [cosine, -x * y / cosine, -x * z / cosine] } else { [0.0, 0.0, -x] };
    ([x, y, z], side)
}

fn ball(x: f64, y: f64, z: f64, radius: f64) -> Ball {
    Ball { centre: [x, y, z], radius }
}

/// A sphere as curvature, and curvature times centre; the mother has the curvature -1.
type Sphere = [f64; 4];

/// A coordinate or radius as a whole number, equal for those that count as the same.
fn key(value: f64) -> i64 {
    (value / RESOLUTION).round() as i64
}

fn sphere_key(sphere: &Sphere) -> [i64; 4] {
    sphere.map(key)
}

/// All balls up to the largest curvature, sorted as in [`Pattern`].
fn gasket() -> Vec<Ball> {
    let root3 = 3.0_f64.sqrt();
    let large = 2.0 * root3 - 3.0;
    let reach = 1.0 - large;
    let above = (1.0 - large) / (1.0 + large);
    let first = [
        [-1.0, 0.0, 0.0, 0.0],
        sphere(ball(0.0, reach, 0.0, large)),
        sphere(ball(-0.5 * root3 * reach, -0.5 * reach, 0.0, large)),
        sphere(ball(0.5 * root3 * reach, -0.5 * reach, 0.0, large)),
        sphere(ball(0.0, 0.0, 1.0 - above, above)),
    ];

    let mut spheres: HashSet<[i64; 4]> = first.iter().map(sphere_key).collect();
    let mut balls: Vec<Ball> = first[1..].iter().map(inside).collect();
    let mut visited = HashSet::from([five_key(&first)]);
    // Breadth first, so that every ball is found in the fewest steps and with the least rounding error.
    let mut front = vec![first];
    while !front.is_empty() {
        let mut next = Vec::new();
        for five in &front {
            for replaced in 0..5 {
                let mirrored = mirror(five, replaced);
                if mirrored[0] > LARGEST_CURVATURE {
                    continue;
                }
                let mut other = *five;
                other[replaced] = mirrored;
                if visited.insert(five_key(&other)) {
                    if spheres.insert(sphere_key(&mirrored)) {
                        balls.push(inside(&mirrored));
                    }
                    next.push(other);
                }
            }
        }
        front = next;
    }
    balls.sort_by_key(|b| {
        let [x, y, z] = b.centre.map(key);
        (-key(b.radius), -z, -y, x)
    });
    balls
}

/// The other sphere that touches four of five mutually tangent spheres, in place of number `replaced`.
fn mirror(five: &[Sphere; 5], replaced: usize) -> Sphere {
    std::array::from_fn(|k| {
        let mut sum = 0.0;
        for (i, sphere) in five.iter().enumerate() {
            if i != replaced {
                sum += sphere[k];
            }
        }
        sum - five[replaced][k]
    })
}

fn five_key(five: &[Sphere; 5]) -> [[i64; 4]; 5] {
    let mut keys = five.map(|s| sphere_key(&s));
    keys.sort_unstable();
    keys
}

fn sphere(ball: Ball) -> Sphere {
    let b = 1.0 / ball.radius;
    [b, b * ball.centre[0], b * ball.centre[1], b * ball.centre[2]]
}

/// The ball of a sphere inside the mother. Coordinates that are zero but for rounding become zero.
fn inside(sphere: &Sphere) -> Ball {
    let clean = |k: usize| {
        let x = sphere[k] / sphere[0];
        if x.abs() < 1e-13 { 0.0 } else { x }
    };
    ball(clean(1), clean(2), clean(3), 1.0 / sphere[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::random_perpendicular;
    use proptest::prelude::*;

    fn pattern(count: u32) -> Pattern {
        Pattern::new(count).unwrap()
    }

    fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
        let [x, y, z]: [f64; 3] = std::array::from_fn(|k| a[k] - b[k]);
        (x * x + y * y + z * z).sqrt()
    }

    /// Gap between two balls and between a ball and the mother sphere.
    fn gap(a: &Ball, b: &Ball) -> f64 {
        distance(a.centre, b.centre) - a.radius - b.radius
    }
    fn depth(ball: &Ball) -> f64 {
        1.0 - ball.radius - distance(ball.centre, [0.0; 3])
    }

    /// Table 5: r, x', y', z' over R, balls 1 to 14.
    const TABLE_5: [[f64; 4]; 14] = [
        [0.4641, 0.0, 0.5359, 0.0],
        [0.4641, -0.4641, -0.2679, 0.0],
        [0.4641, 0.4641, -0.2679, 0.0],
        [0.2240, -0.6720, 0.3880, 0.0],
        [0.2240, 0.6720, 0.3880, 0.0],
        [0.2240, 0.0, -0.7760, 0.0],
        [0.3659, 0.0, 0.0, 0.6339],
        [0.3659, 0.0, 0.0, -0.6339],
        [0.2573, 0.0, -0.5942, 0.4456],
        [0.2573, 0.5146, 0.2971, 0.4456],
        [0.2573, -0.5146, 0.2971, 0.4456],
        [0.2573, 0.0, -0.5942, -0.4456],
        [0.2573, 0.5146, 0.2971, -0.4456],
        [0.2573, -0.5146, 0.2971, -0.4456],
    ];

    #[test]
    fn fourteen_balls_are_those_of_table_5() {
        let pattern = pattern(14);
        let mut left = pattern.balls().to_vec();
        for [radius, x, y, z] in TABLE_5 {
            let at = left.iter().position(|b| (b.radius - radius).abs() < 1.5e-4 && distance(b.centre, [x, y, z]) < 3e-4);
            left.remove(at.unwrap_or_else(|| panic!("no ball at {x}, {y}, {z}")));
        }
        assert!(left.is_empty());
        // Four digits lose 2e-4 of the volume that exact tangency keeps.
        let printed: f64 = TABLE_5.iter().map(|b| b[0] * b[0] * b[0]).sum();
        assert!((printed - 0.53378).abs() < 5e-6);
        assert!((pattern.volume_kept() - 0.533874).abs() < 5e-7);
        assert!((pattern.smallest() - 0.2240).abs() < 5e-5);
        assert!((pattern.balls()[0].radius - (2.0 * 3.0_f64.sqrt() - 3.0)).abs() < 1e-15);
        assert!((pattern.balls()[0].centre[1] - 0.5359).abs() < 1e-4, "ball 1 lies on +y'");
    }

    #[test]
    fn classes_of_the_gasket() {
        let expected = [
            (0.4641, 3, 0.300),
            (0.3660, 2, 0.398),
            (0.2573, 6, 0.500),
            (0.2240, 3, 0.534),
            (0.1780, 12, 0.602),
            (0.1360, 12, 0.632),
            (0.1261, 12, 0.656),
            (0.1101, 18, 0.680),
        ];
        let classes = pattern(68).classes();
        assert_eq!(classes.len(), expected.len());
        let mut kept = 0.0;
        for ((radius, count), (r, n, volume)) in classes.into_iter().zip(expected) {
            assert!((radius - r).abs() < 5.1e-5, "{radius} {r}");
            assert_eq!(count, n);
            kept += radius * radius * radius * count as f64;
            assert!((kept - volume).abs() < 5.1e-4, "{kept} {volume}");
        }
        // In closed form every curvature here is 1 + k / sqrt 3.
        for ((radius, _), k) in pattern(68).classes().into_iter().zip([2, 3, 5, 6, 8, 11, 12, 14]) {
            assert!((1.0 / radius - 1.0 - f64::from(k) / 3.0_f64.sqrt()).abs() < 1e-13);
        }
        assert_eq!(gasket().len(), 68, "nothing is generated in vain");
        for count in COUNTS {
            let pattern = pattern(count);
            assert_eq!(pattern.count(), count as usize);
            let held: usize = pattern.classes().iter().map(|c| c.1).sum();
            assert_eq!(held, count as usize);
        }
        assert_eq!(pattern(2).volume_kept(), 0.25);
    }

    #[test]
    fn balls_touch_without_overlap_and_stay_inside() {
        for count in COUNTS {
            let pattern = pattern(count);
            for (i, a) in pattern.balls().iter().enumerate() {
                assert!(depth(a) > -1e-13, "{count}: {i} sticks out {:e}", depth(a));
                let mut touching = u32::from(depth(a).abs() < 1e-13);
                for (j, b) in pattern.balls().iter().enumerate() {
                    if i != j {
                        assert!(gap(a, b) > -1e-13, "{count}: {i}, {j} overlap {:e}", gap(a, b));
                        touching += u32::from(gap(a, b) < 1e-13);
                    }
                }
                let least = if count == 2 { 2 } else { 4 };
                assert!(touching >= least, "{count}: {i} touches {touching}");
                if count <= 14 {
                    assert!(depth(a) < 1e-13, "{count}: {i} does not touch the mother");
                }
            }
            // The centre of mass stays where it was: daughters with the mother's velocity have its momentum.
            let moment = pattern
                .balls()
                .iter()
                .fold([0.0; 3], |sum: [f64; 3], b| std::array::from_fn(|k| sum[k] + b.radius * b.radius * b.radius * b.centre[k]));
            assert!(distance(moment, [0.0; 3]) < 1e-13, "{moment:?}");
        }
    }

    #[test]
    fn largest_balls_lie_in_the_plane_across_the_force() {
        for count in COUNTS {
            let pattern = pattern(count);
            let largest = pattern.balls()[0].radius;
            for ball in pattern.balls() {
                if ball.radius > 0.999 * largest {
                    assert_eq!(ball.centre[2], 0.0);
                }
            }
        }
    }

    #[test]
    fn order_is_stated_and_smaller_patterns_begin_larger_ones() {
        let all = pattern(68);
        for count in [5, 14, 26, 38, 50] {
            assert_eq!(pattern(count).balls(), &all.balls()[..count as usize]);
        }
        for pair in all.balls().windows(2) {
            assert!(pair[0].radius > pair[1].radius - 1e-12);
            if (pair[0].radius - pair[1].radius).abs() < 1e-12 {
                assert!(pair[0].centre[2] > pair[1].centre[2] - 1e-12);
            }
        }
    }

    #[test]
    fn unknown_counts_are_refused_with_those_there_are() {
        for count in [0, 1, 3, 57, 69] {
            let message = Pattern::new(count).unwrap_err();
            assert!(message.contains(&count.to_string()) && message.contains("26, 38, 50, 68"));
        }
    }

    #[test]
    fn reference_frame_is_right_handed() {
        let pattern = pattern(14);
        let daughters = pattern.daughters([0.0; 3], 1.0, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        for ((centre, radius), ball) in daughters.zip(pattern.balls()) {
            assert_eq!((centre, radius), (ball.centre, ball.radius));
        }
        // Turned by a quarter about x: z' = -y, y' = z.
        let turned = pattern.daughters([0.0; 3], 1.0, [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]);
        for ((centre, _), ball) in turned.zip(pattern.balls()) {
            let [x, y, z] = ball.centre;
            assert!(distance(centre, [x, -z, y]) < 1e-15);
        }
    }

    /// The pattern is where the two rotations of the paper's appendix take it, whichever way along the force it is given.
    #[test]
    fn a_fixed_azimuth_is_that_of_two_rotations() {
        // along z nothing is turned, along y by a quarter about x, along x by a quarter about y
        assert_eq!(turned_from_space([0.0, 0.0, -1.0]), ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]));
        assert_eq!(turned_from_space([0.0, -1.0, 0.0]), ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0]));
        assert_eq!(turned_from_space([1.0, 0.0, 0.0]), ([1.0, 0.0, 0.0], [0.0, 0.0, -1.0]));
        assert_eq!(turned_from_space([-1.0, 0.0, 0.0]), ([1.0, 0.0, 0.0], [0.0, 0.0, -1.0]));
        let pattern = pattern(14);
        for (beta, alpha) in [(0.3_f64, 0.0_f64), (0.0, -0.7), (1.1, 0.4), (-0.9, -1.5), (1.56, 0.2)] {
            let turned = |[x, y, z]: [f64; 3]| {
                let (x, z) = (beta.cos() * x + beta.sin() * z, beta.cos() * z - beta.sin() * x);
                [x, alpha.cos() * y - alpha.sin() * z, alpha.sin() * y + alpha.cos() * z]
            };
            let force = turned([0.0, 0.0, 1.0]);
            for sense in [1.0, -1.0] {
                let (axis, side) = turned_from_space(force.map(|f| sense * f));
                for ((at, _), ball) in pattern.daughters([0.0; 3], 1.0, axis, side).zip(pattern.balls()) {
                    assert!(distance(at, turned(ball.centre)) < 1e-13, "{beta} {alpha}");
                }
            }
        }
    }

    /// Rotation by a unit quaternion.
    fn rotate(q: [f64; 4], v: [f64; 3]) -> [f64; 3] {
        let [w, x, y, z] = q;
        [
            (1.0 - 2.0 * (y * y + z * z)) * v[0] + 2.0 * (x * y - w * z) * v[1] + 2.0 * (x * z + w * y) * v[2],
            2.0 * (x * y + w * z) * v[0] + (1.0 - 2.0 * (x * x + z * z)) * v[1] + 2.0 * (y * z - w * x) * v[2],
            2.0 * (x * z - w * y) * v[0] + 2.0 * (y * z + w * x) * v[1] + (1.0 - 2.0 * (x * x + y * y)) * v[2],
        ]
    }

    fn unit<const N: usize>() -> impl Strategy<Value = [f64; N]> {
        proptest::array::uniform::<_, N>(-1.0..1.0_f64).prop_filter_map("too short", |v| {
            let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            (length > 0.05).then(|| v.map(|x| x / length))
        })
    }

    /// Unit vectors, the six axes of space among them and their close neighbours.
    fn axis() -> impl Strategy<Value = [f64; 3]> {
        let special = (0_usize..3, prop::bool::ANY, -1e-8..1e-8_f64, prop::bool::ANY).prop_map(|(k, negative, tilt, exact)| {
            let mut v = [0.0; 3];
            v[k] = if negative { -1.0 } else { 1.0 };
            if !exact {
                v[(k + 1) % 3] = tilt;
            }
            v
        });
        prop_oneof![unit::<3>(), special]
    }

    fn counts() -> impl Strategy<Value = u32> {
        prop::sample::select(COUNTS.to_vec())
    }

    proptest! {
        #[test]
        fn daughters_are_inscribed_about_every_axis(axis in axis(), lineage: u64, count in counts(), radius in 1e-4..1.0_f64) {
            let pattern = pattern(count);
            let side = random_perpendicular(1, lineage, axis);
            let centre = [0.03, -0.07, 0.02];
            let daughters: Vec<_> = pattern.daughters(centre, radius, axis, side).collect();
            for (i, &(a, r)) in daughters.iter().enumerate() {
                let expected = depth(&pattern.balls()[i]);
                let found = (radius - r - distance(a, centre)) / radius;
                let rounding = 2e-15 + 1e-16 / radius;
                prop_assert!((found - expected).abs() < rounding, "{found:e} {expected:e}");
                for (j, &(b, s)) in daughters.iter().enumerate().skip(i + 1) {
                    let expected = gap(&pattern.balls()[i], &pattern.balls()[j]);
                    let found = (distance(a, b) - r - s) / radius;
                    prop_assert!((found - expected).abs() < rounding, "{found:e} {expected:e}");
                }
                // The local height of a daughter is its height along the force.
                let height: f64 = (0..3).map(|k| (a[k] - centre[k]) * axis[k]).sum();
                prop_assert!((height / radius - pattern.balls()[i].centre[2]).abs() < rounding);
            }
        }

        #[test]
        fn fixed_axes_are_perpendicular_units(axis in axis()) {
            let (z, x) = turned_from_space(axis);
            let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            prop_assert!(z == axis || z == axis.map(|c| -c));
            prop_assert!(z[2] >= 0.0 && x[0] >= 0.0);
            prop_assert!((dot(x, x) - dot(z, z)).abs() < 1e-14 && dot(x, z).abs() < 1e-15, "{x:?} {z:?}");
            prop_assert_eq!(turned_from_space(axis.map(|c| -c)), (z, x));
        }

        #[test]
        fn daughters_turn_with_the_frame(q in unit::<4>(), axis in axis(), lineage: u64, count in counts()) {
            let pattern = pattern(count);
            let side = random_perpendicular(1, lineage, axis);
            let centre = [0.3, -0.7, 0.2];
            let here = pattern.daughters(centre, 0.5, axis, side);
            let there = pattern.daughters(rotate(q, centre), 0.5, rotate(q, axis), rotate(q, side));
            for ((a, r), (b, s)) in here.zip(there) {
                prop_assert_eq!(r, s);
                prop_assert!(distance(rotate(q, a), b) < 3e-15);
            }
        }
    }
}
