//! Motion of a rigid body: leapfrog, with the full tensor of inertia.
//!
//! The rotational state is the angular momentum in the axes of space, which only torques change. Between two changes of momentum the body rotates freely;
//! that rotation is split into rotations about the principal axes one after the other and back, each by the angle that its own part of the kinetic
//! energy gives (Miller et al. 2002, J. Chem. Phys. 116, 8649, "no squish"). The method is symplectic and reversible: the error of the energy oscillates in
//! proportion to the square of the step and does not drift.

use super::Block;
use crate::math::vector::{cross, dot, less, plus, scaled};

/// Position and orientation of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Centre of mass, m.
    pub centre: [f64; 3],
    /// Unit vectors of the principal axes, in the axes of space.
    pub axes: [[f64; 3]; 3],
}

impl Pose {
    /// Position in space of a place in the frame of the body.
    pub fn place(&self, at: [f64; 3]) -> [f64; 3] {
        plus(self.centre, self.outwards(at))
    }

    /// Place in the frame of the body of a position in space.
    pub fn within(&self, at: [f64; 3]) -> [f64; 3] {
        self.inwards(less(at, self.centre))
    }

    /// Components of a vector in the axes of the body, from those in the axes of space.
    pub fn inwards(&self, v: [f64; 3]) -> [f64; 3] {
        self.axes.map(|axis| dot(axis, v))
    }

    /// Components of a vector in the axes of space, from those in the axes of the body.
    pub fn outwards(&self, v: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.axes;
        plus(scaled(a, v[0]), plus(scaled(b, v[1]), scaled(c, v[2])))
    }
}

/// Product of two rotations as quaternions (w, x, y, z): first `q`, then `p`.
pub fn product(p: [f64; 4], q: [f64; 4]) -> [f64; 4] {
    let ([a, u @ ..], [b, v @ ..]) = (p, q);
    let [x, y, z] = plus(plus(scaled(v, a), scaled(u, b)), cross(u, v));
    [a * b - dot(u, v), x, y, z]
}

/// Rotation of the axes x, y, z by a unit quaternion (w, x, y, z).
pub fn axes([w, x, y, z]: [f64; 4]) -> [[f64; 3]; 3] {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// Unit quaternion that rotates x, y, z into three given perpendicular unit vectors (right-handed). It is found from the largest of its four numbers.
pub fn quaternion([a, b, c]: [[f64; 3]; 3]) -> [f64; 4] {
    let squares = [1.0 + a[0] + b[1] + c[2], 1.0 + a[0] - b[1] - c[2], 1.0 - a[0] + b[1] - c[2], 1.0 - a[0] - b[1] + c[2]];
    let k = (0..4).fold(0, |most, k| if squares[k] > squares[most] { k } else { most });
    let (twice, x, y, z) = (squares[k].sqrt(), b[2] - c[1], c[0] - a[2], a[1] - b[0]);
    let [xy, yz, zx] = [a[1] + b[0], b[2] + c[1], c[0] + a[2]];
    let s = 0.5 / twice;
    let whole = 0.5 * twice;
    let q = match k {
        0 => [whole, x * s, y * s, z * s],
        1 => [x * s, whole, xy * s, zx * s],
        2 => [y * s, xy * s, whole, yz * s],
        _ => [z * s, zx * s, yz * s, whole],
    };
    unit(q)
}

/// Unit quaternion of a rotation by `angle`, rad, at most half a turn either way, about a direction of any length but zero.
pub fn about(direction: [f64; 3], angle: f64) -> [f64; 4] {
    use crate::math::portable::sin;
    let (half, length) = (0.5 * angle, dot(direction, direction).sqrt());
    let [x, y, z] = scaled(direction, sin(half) / length);
    unit([sin(std::f64::consts::FRAC_PI_2 - half.abs()), x, y, z])
}

/// The quaternion divided by its length.
fn unit(q: [f64; 4]) -> [f64; 4] {
    let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    q.map(|x| x / length)
}

/// How a body yields to forces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Yields {
    /// Inverse mass, 1/kg.
    pub inverse_mass: f64,
    /// Inverse moments of inertia, 1/(kg m²).
    pub inverse_moments: [f64; 3],
    /// Least moment of inertia, kg m².
    least: f64,
}

impl Yields {
    /// Upper bound on how fast the end of `arm` gives way to a force, 1/kg: 1/m + r²/I with the least moment.
    pub fn most_at(&self, arm: [f64; 3]) -> f64 {
        self.inverse_mass + dot(arm, arm) / self.least
    }
}

impl Block {
    /// Position and orientation after `ahead` seconds of free motion.
    pub fn pose(&self, ahead: f64) -> Pose {
        let turn = if ahead == 0.0 { self.turn } else { self.orientation_after(ahead) };
        Pose { centre: plus(self.centre, scaled(self.velocity, ahead)), axes: axes(turn) }
    }

    /// Angular velocity, rad/s.
    pub fn spin(&self) -> [f64; 3] {
        let pose = self.pose(0.0);
        let l = pose.inwards(self.momentum);
        pose.outwards(std::array::from_fn(|a| l[a] / self.moments[a]))
    }

    /// Sets the angular velocity, rad/s.
    pub fn set_spin(&mut self, spin: [f64; 3]) {
        let pose = self.pose(0.0);
        let w = pose.inwards(spin);
        self.momentum = pose.outwards(std::array::from_fn(|a| w[a] * self.moments[a]));
    }

    /// Kinetic energy, J; none of a sheet, which has no mass.
    pub fn kinetic(&self) -> f64 {
        if self.solid().sheet().is_some() {
            return 0.0;
        }
        0.5 * (self.mass * dot(self.velocity, self.velocity) + dot(self.spin(), self.momentum))
    }

    /// How it yields to forces: not at all if it is driven.
    pub(super) fn yields(&self) -> Yields {
        if self.driven {
            return Yields { inverse_mass: 0.0, inverse_moments: [0.0; 3], least: f64::INFINITY };
        }
        let least = self.moments.into_iter().fold(f64::INFINITY, f64::min);
        Yields { inverse_mass: 1.0 / self.mass, inverse_moments: self.moments.map(|moment| 1.0 / moment), least }
    }

    /// One step: changes velocity and angular momentum (but of a driven body) by a force, N, and a torque, N m, over `kick` seconds, then moves the body for `dt` seconds.
    pub fn advance(&mut self, [force, torque]: [[f64; 3]; 2], kick: f64, dt: f64) {
        if !self.driven {
            self.velocity = plus(self.velocity, scaled(force, kick / self.mass));
            self.momentum = plus(self.momentum, scaled(torque, kick));
        }
        self.drift(dt);
    }

    /// Moves the body for `dt` seconds, free of forces.
    pub(super) fn drift(&mut self, dt: f64) {
        self.centre = plus(self.centre, scaled(self.velocity, dt));
        self.turn = self.orientation_after(dt);
    }

    /// Moves the body by a way, m, and turns it about its centre of mass by a rotation vector, rad, of less than a turn.
    pub fn shift(&mut self, way: [f64; 3], turn: [f64; 3]) {
        self.centre = plus(self.centre, way);
        let angle = dot(turn, turn).sqrt();
        if angle > 0.0 {
            self.turn = unit(product(about(turn, angle.min(std::f64::consts::PI)), self.turn));
        }
    }

    /// Orientation after `dt` seconds of free rotation.
    fn orientation_after(&self, dt: f64) -> [f64; 4] {
        if self.momentum == [0.0; 3] {
            return self.turn;
        }
        let mut turn = self.turn;
        let mut l = axes(turn).map(|axis| dot(axis, self.momentum));
        for (k, share) in [(2, 0.5), (1, 0.5), (0, 1.0), (1, 0.5), (2, 0.5)] {
            // tangent of half of the angle, with an error of its fifth power; the angle depends on this part of the momentum alone, so the method stays symplectic
            let angle = l[k] / self.moments[k] * (share * dt);
            let tangent = 0.5 * angle * (1.0 + angle * angle / 12.0);
            let below = 1.0 / (1.0 + tangent * tangent);
            let (cosine, sine) = ((1.0 - tangent * tangent) * below, 2.0 * tangent * below);
            let mut q = [1.0, 0.0, 0.0, 0.0];
            q[1 + k] = tangent;
            turn = product(turn, q);
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            (l[i], l[j]) = (cosine * l[i] + sine * l[j], cosine * l[j] - sine * l[i]);
        }
        unit(turn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Cuboid, Shape};

    fn top(half: [f64; 3]) -> Block {
        let mut top = Block::new(Shape::Box(Cuboid { half }), 2000.0, 0);
        top.turn = about([1.0, 2.0, -1.0], 0.7);
        top
    }

    #[test]
    fn quaternions_and_axes_are_one() {
        for (k, direction) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.4, 0.9], [1.0, -2.0, 0.1]].into_iter().enumerate() {
            for angle in [-3.1, -1.0, 0.2, 3.0] {
                let q = about(direction, angle);
                assert!((q[0] - (0.5 * angle).cos()).abs() < 1e-15);
                let back = quaternion(axes(q));
                let same: f64 = (0..4).map(|a| q[a] * back[a]).sum();
                assert!((same.abs() - 1.0).abs() < 1e-14, "{k} {angle}: {q:?} {back:?}");
                // a rotation leaves its axis
                let pose = Pose { centre: [0.0; 3], axes: axes(q) };
                let moved = pose.outwards(direction);
                assert!((0..3).all(|a| (moved[a] - direction[a]).abs() < 1e-14));
            }
        }
        let turned = Pose { centre: [0.0; 3], axes: axes(about([0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2)) };
        let y = turned.outwards([1.0, 0.0, 0.0]);
        assert!((y[1] - 1.0).abs() < 1e-15 && y[0].abs() < 1e-15);
    }

    /// A top of three different moments, turning about the middle one, which is unstable: angular momentum stays to the bit, energy swings by the
    /// square of the step and does not drift.
    #[test]
    fn a_free_top_keeps_momentum_and_energy() {
        let swing = |dt: f64| {
            let mut top = top([0.3, 0.2, 0.1]);
            top.set_spin(top.pose(0.0).outwards([0.01, 5.0, 0.02]));
            let (start, momentum) = (top.kinetic(), top.momentum);
            let (mut most, mut late) = (0.0_f64, 0.0_f64);
            let steps = (200.0 / dt) as u32;
            for k in 0..steps {
                top.advance([[0.0; 3]; 2], dt, dt);
                let error = (top.kinetic() / start - 1.0).abs();
                if k < steps / 10 { most = most.max(error) } else { late = late.max(error) }
            }
            assert_eq!(top.momentum, momentum);
            assert!(late < 1.2 * most, "{late:e} after {most:e}");
            most
        };
        let (coarse, fine) = (swing(0.02), swing(0.01));
        assert!(fine < 2e-3 && coarse > 3.0 * fine && coarse < 5.0 * fine, "{coarse:e} {fine:e}");
    }

    /// Two like moments: the axis of the third goes round the angular momentum at L/I₁ (Euler).
    #[test]
    fn a_symmetric_top_precesses_as_euler_has_it() {
        let mut top = top([0.2, 0.2, 0.05]);
        top.set_spin(top.pose(0.0).outwards([1.5, 0.0, 7.0]));
        let l = top.momentum;
        let size = dot(l, l).sqrt();
        let rate = size / top.moments[0];
        let start = top.pose(0.0).axes[2];
        let (dt, steps) = (1e-3, 3000);
        for _ in 0..steps {
            top.advance([[0.0; 3]; 2], dt, dt);
        }
        let turn = rate * dt * f64::from(steps);
        // the start turned about the momentum
        let n = scaled(l, 1.0 / size);
        let along = scaled(n, dot(n, start));
        let across = plus(start, scaled(along, -1.0));
        let exact = plus(along, plus(scaled(across, turn.cos()), scaled(cross(n, across), turn.sin())));
        let end = top.pose(0.0).axes[2];
        assert!((0..3).all(|a| (end[a] - exact[a]).abs() < 2e-4), "{end:?} {exact:?}");
    }

    /// Three different moments: the spin comes back in the body's frame after 4 K(k)/λ (Landau & Lifshitz, Mechanics, section 37).
    #[test]
    fn an_asymmetric_top_has_the_period_of_the_elliptic_integral() {
        let mut top = top([0.3, 0.2, 0.1]);
        // moments rise: about x the least
        let [i1, i2, i3] = top.moments;
        assert!(i1 < i2 && i2 < i3);
        top.set_spin(top.pose(0.0).outwards([1.0, 0.0, 4.0]));
        let (twice, square) = (2.0 * top.kinetic(), dot(top.momentum, top.momentum));
        // M² > 2 E I2
        assert!(square > twice * i2);
        let rate = ((i3 - i2) * (square - twice * i1) / (i1 * i2 * i3)).sqrt();
        let k2 = (i2 - i1) * (twice * i3 - square) / ((i3 - i2) * (square - twice * i1));
        // K by the arithmetic-geometric mean
        let (mut a, mut g) = (1.0_f64, (1.0 - k2).sqrt());
        for _ in 0..20 {
            (a, g) = (0.5 * (a + g), (a * g).sqrt());
        }
        let period = 4.0 * (std::f64::consts::FRAC_PI_2 / a) / rate;
        let steps = 20_000;
        let dt = period / f64::from(steps);
        let start = top.pose(0.0).inwards(top.spin());
        for _ in 0..steps {
            top.advance([[0.0; 3]; 2], dt, dt);
        }
        let end = top.pose(0.0).inwards(top.spin());
        assert!((0..3).all(|a| (end[a] - start[a]).abs() < 1e-5), "{start:?} {end:?}");
    }
}
