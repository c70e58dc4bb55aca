//! Contact of the material with rigid bodies at the nodes that both reach: the scheme MPM-DEM of Liu et al., to compare with (Jiang et al. 2020, section 5.4 and Fig. 17 C).
//!
//! A body is a few material points of its own, which give mass and momentum to the nodes (Bardenhagen et al.). At a node that the material reaches as well the two may not approach each other along
//! the normal of the material, the gradient of its mass (of the two it has the more points): an impulse makes them equal there, with friction across. The body's points get the opposite of it by their
//! shares of the node's mass. Momentum is kept; angular momentum only as far as the points stand where the nodes are; what the two approach each other with at nodes is lost.

use super::blocks::CellBlocks;
use super::grid::NodeGrid;
use super::pass::cell_of;
use super::points::Points;
use super::spline::ShapeFunction;
use super::{GridWall, Settings};
use crate::math::real::{Four, Plain};
use crate::math::vector::{dot, less, plus, scaled};

/// Change of the mass over a cell, over the mass of the node, below which a node lies inside of the material and has no normal. There the gradient is only noise, whose direction would hold bodies back that part:
/// a rod that has hit a block then takes a quarter of its speed back. From 0.05 to 0.5 the rods of Jiang et al. 2020, Fig. 18, move alike.
const INSIDE: f64 = 0.1;

/// A material point of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyPoint {
    /// Index of the body; its points follow each other.
    pub body: u32,
    /// Its share of the mass of the body, kg.
    pub mass: f64,
    /// Position, m.
    pub position: [f64; 3],
    /// Velocity, m/s.
    pub velocity: [f64; 3],
    /// Coefficient of friction of the body with the material.
    pub friction: f64,
    /// Whether the body gives way to nothing.
    pub driven: bool,
    /// Impulse of the material on it in the last step, N s.
    pub impulse: [f64; 3],
}

/// What a point of a body gives to a node.
struct Share {
    node: u32,
    /// Coordinates of the node.
    place: [i32; 3],
    /// Index among the points of the body.
    point: usize,
    /// Mass, kg.
    mass: f64,
}

/// The material and its nodes, which have their changes of this step but for walls.
pub struct Nodes<'a, S> {
    /// Shape functions.
    pub shape: S,
    /// Settings of the continuum.
    pub settings: &'a Settings,
    /// Blocks of nodes.
    pub blocks: &'a CellBlocks,
    /// The material's points.
    pub points: &'a Points,
    /// Values at the nodes.
    pub grid: &'a mut NodeGrid,
}

impl<S: ShapeFunction> Nodes<'_, S> {
    /// Changes the velocities of the nodes by the contacts with these bodies, one body after the other, and sets the impulses on the bodies' points.
    pub fn touch<const D: usize>(&mut self, bodies: &mut [BodyPoint]) {
        bodies.iter_mut().for_each(|point| point.impulse = [0.0; 3]);
        for body in bodies.chunk_by_mut(|a, b| a.body == b.body) {
            let mut shares = Vec::new();
            for (k, point) in body.iter().enumerate() {
                self.each_node::<D>(point.position, |node, place, weight, _| {
                    shares.push(Share { node, place, point: k, mass: weight * point.mass });
                });
            }
            shares.sort_by_key(|share| share.node);
            let gradients = self.gradients::<D>(&shares);
            for (shares, gradient) in shares.chunk_by(|a, b| a.node == b.node).zip(gradients) {
                self.meet(body, shares, gradient);
            }
        }
    }

    /// Calls `visit` with each node that a place gives to and that the material reaches: its number, its coordinates, the weight and its derivatives by the place, 1/m.
    fn each_node<const D: usize>(&self, at: [f64; 3], mut visit: impl FnMut(u32, [i32; 3], f64, [f64; 3])) {
        let (Settings { lower, cell, .. }, [x, y, z]) = (self.settings, at);
        let inverse = 1.0 / cell;
        let first = cell_of::<D>(&[x, y, z, 0.0], *lower, inverse, self.shape.reach());
        let t = |a: usize| if a < D { (at[a] - lower[a]) * inverse - f64::from(first[a]) } else { 1.0 };
        let w = self.shape.weights((), Plain::of((), [t(0), t(1), t(2), 1.0]), inverse);
        for n in 0..if D == 3 { 27 } else { 9 } {
            let k = [n % 3, n / 3 % 3, n / 9];
            let place = std::array::from_fn(|a| first[a] + k[a] as i32);
            let [x, y, z] = std::array::from_fn(|a| if a < D { w.value[k[a]][a] } else { 1.0 });
            let [dx, dy, dz] = std::array::from_fn(|a| if a < D { w.slope[k[a]][a] } else { 0.0 });
            if let Some(node) = self.blocks.node::<D>(place).filter(|_| x * y * z > 0.0) {
                visit(node, place, x * y * z, [dx * y * z, x * dy * z, x * y * dz]);
            }
        }
    }

    /// The gradient of the material's mass at each node of these shares, kg/m, out of the material; behind a wall of the domain lies its mirror image.
    fn gradients<const D: usize>(&self, shares: &[Share]) -> Vec<[f64; 3]> {
        let mut nodes: Vec<(u32, [i32; 3])> = shares.iter().map(|share| (share.node, share.place)).collect();
        nodes.dedup();
        let mut gradients = vec![[0.0; 3]; nodes.len()];
        let end =
            |worst: fn(i32, i32) -> i32| nodes.iter().map(|node| node.1).reduce(|a, b| std::array::from_fn(|k| worst(a[k], b[k])));
        let (Some(low), Some(high)) = (end(i32::min), end(i32::max)) else { return gradients };
        // a point of a cell reaches the node of that number and the next two
        self.blocks.visit::<D>(low.map(|x| x - 2), high, |range| {
            for i in range {
                let [x, y, z, _] = self.points.position[i];
                self.each_node::<D>([x, y, z], |node, _, _, slope| {
                    if let Ok(k) = nodes.binary_search_by_key(&node, |node| node.0) {
                        gradients[k] = plus(gradients[k], scaled(slope, self.points.velocity[i][3]));
                    }
                });
            }
        });
        let size = self.settings.size();
        for ((_, place), gradient) in nodes.iter().zip(&mut gradients) {
            for a in 0..D {
                let [low, high] = [2 * a, 2 * a + 1].map(|side| self.settings.walls[side] != GridWall::Open);
                if low && place[a] <= 0 || high && place[a] >= size[a] {
                    gradient[a] = 0.0;
                }
            }
        }
        gradients
    }

    /// The contact of a body with the material at one node, where the gradient of the material's mass is `gradient`.
    fn meet(&mut self, body: &mut [BodyPoint], shares: &[Share], gradient: [f64; 3]) {
        let node = shares[0].node as usize;
        let (material, steep) = (self.grid.momentum[node][3], dot(gradient, gradient).sqrt());
        if material <= 0.0 || steep * self.settings.cell <= INSIDE * material {
            return;
        }
        let (mass, momentum) = shares.iter().fold((0.0, [0.0; 3]), |(mass, momentum), share| {
            (mass + share.mass, plus(momentum, scaled(body[share.point].velocity, share.mass)))
        });
        // out of the body
        let normal = scaled(gradient, -1.0 / steep);
        let change = &mut self.grid.change[node];
        let now: [f64; 3] = std::array::from_fn(|a| self.grid.velocity[node][a] + change[a]);
        let between = less(now, scaled(momentum, 1.0 / mass));
        let apart = dot(between, normal);
        if apart >= 0.0 {
            return;
        }
        let first = body[shares[0].point];
        let both = if first.driven { material } else { material * mass / (material + mass) };
        let aside = less(between, scaled(normal, apart));
        let slip = dot(aside, aside).sqrt();
        let push = -both * apart;
        let rub = if slip > 0.0 { (first.friction * push).min(both * slip) / slip } else { 0.0 };
        let impulse = less(scaled(normal, push), scaled(aside, rub));
        for (v, j) in change.iter_mut().zip(impulse) {
            *v += j / material;
        }
        for share in shares {
            let of = &mut body[share.point].impulse;
            *of = less(*of, scaled(impulse, share.mass / mass));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mpm::law::{Elastic, Law};
    use crate::mpm::{Continuum, Dimension, Point, ShapeFunctions, Transfer};

    /// A square of 8 × 8 points in plane strain, from the origin on, that moves with this velocity; cells of 0.1 m.
    fn material(velocity: [f64; 3]) -> Continuum {
        let settings = Settings {
            dimension: Dimension::PlaneStrain,
            cell: 0.1,
            lower: [-0.5, -0.5, 0.0],
            cells: [16, 16, 1],
            walls: [GridWall::Open; 6],
            gravity: [0.0; 3],
            shape: ShapeFunctions::Gimp { half_width: 0.25 },
            transfer: Transfer::Blend { pic: 0.0 },
            damping: 0.0,
        };
        let mut points = Points::default();
        for k in 0..64 {
            let position = [0.025 + 0.05 * f64::from(k % 8), 0.025 + 0.05 * f64::from(k / 8), 0.0];
            points.add(&Point { position, velocity, mass: 5.0, volume: 2.5e-3, stress: [0.0; 6], porosity: 0.0, law: 0 });
        }
        Continuum::new(settings, vec![Law::Elastic(Elastic::of_young(1e6, 0.3))], points).expect("allowed")
    }

    /// A body of three points in a row across, beside the material, of 60 kg.
    fn body(velocity: [f64; 3], friction: f64, driven: bool) -> Vec<BodyPoint> {
        let at =
            |y: f64| BodyPoint { body: 0, mass: 20.0, position: [0.43, y, 0.0], velocity, friction, driven, impulse: [7.0; 3] };
        [0.1, 0.2, 0.3].map(at).to_vec()
    }

    fn impulse(points: &[BodyPoint]) -> [f64; 3] {
        points.iter().fold([0.0; 3], |sum, point| plus(sum, point.impulse))
    }

    #[test]
    fn what_the_body_gets_the_material_loses() {
        for (friction, driven) in [(0.0, false), (0.3, false), (0.3, true)] {
            let (mut c, mut points) = (material([0.2, 0.05, 0.0]), body([0.0, 0.0, 0.0], friction, driven));
            let before = c.totals().momentum;
            c.step_beside(1e-5, &mut points).expect("a small step");
            let (lost, got) = (less(before, c.totals().momentum), impulse(&points));
            assert!((0..3).all(|a| (lost[a] - got[a]).abs() < 1e-12), "{lost:?} {got:?}");
            assert!(got[0] > 0.1, "{got:?}");
            // the material moves up along the body, which rubs on it
            assert!(if friction > 0.0 { got[1] > 1e-3 } else { got[1].abs() < 0.2 * got[0] }, "{got:?}");
        }
    }

    #[test]
    fn nothing_acts_where_the_two_part_or_do_not_meet() {
        let (mut c, mut points) = (material([-0.2, 0.0, 0.0]), body([0.1, 0.0, 0.0], 0.3, false));
        c.step_beside(1e-5, &mut points).expect("a small step");
        assert_eq!(impulse(&points), [0.0; 3]);
        let mut far = body([-5.0, 0.0, 0.0], 0.3, false);
        far.iter_mut().for_each(|point| point.position[0] = 0.8);
        c.step_beside(1e-5, &mut far).expect("a small step");
        assert_eq!(impulse(&far), [0.0; 3]);
    }

    /// At a node that one point of each reaches alone the two go on with the velocity of their centre of mass, along the line between them.
    #[test]
    fn two_points_at_one_node_go_on_together() {
        let mut c = material([0.0; 3]);
        let points = c.points_mut();
        points.remove(&(0..64).map(|k| k != 63).collect::<Vec<_>>());
        points.position[0][..2].copy_from_slice(&[0.38, 0.4]);
        points.velocity[0][0] = 0.3;
        let mut points = vec![BodyPoint { position: [0.42, 0.4, 0.0], ..body([-0.1, 0.0, 0.0], 0.0, false)[0] }];
        c.step_beside(1e-5, &mut points).expect("a small step");
        let [x, y, _] = impulse(&points);
        assert!(x > 0.0 && y.abs() < 1e-15, "{x} {y}");
        // 5 kg and 20 kg that meet with 0.4 m/s: with all of their masses at one node it would be the reduced mass times that
        let all = 0.4 * 5.0 * 20.0 / 25.0;
        assert!(x < all && x > 0.5 * all, "{x} of {all}");
    }
}
