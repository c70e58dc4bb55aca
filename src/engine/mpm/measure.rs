//! Mass, momentum and energy of all points, summed in the order of identities.

use super::law::Law;
use super::{Continuum, Points};

/// Sums over points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Mass, kg (in plane strain per metre of thickness, as all others).
    pub mass: f64,
    /// Volume, m³.
    pub volume: f64,
    /// Momentum, kg m/s.
    pub momentum: [f64; 3],
    /// Angular momentum about the origin, kg m²/s; with APIC that of the affine fields, m h²/4 (∇ × v), is included.
    pub angular_momentum: [f64; 3],
    /// Kinetic energy of the points' velocities, J.
    pub kinetic: f64,
    /// Potential energy in gravity, −Σ m g·x, J.
    pub potential: f64,
}

/// Elastic energy of the stresses of all points, J, summed in the order of identities.
pub(super) fn elastic_energy(laws: &[Law], points: &Points) -> f64 {
    let of = |i: u32| {
        let i = i as usize;
        points.position[i][3] * laws[usize::from(points.law[i])].elastic_energy(&points.stress[i], points.memory[i])
    };
    points.by_id().into_iter().map(of).sum()
}

/// Sums over all points.
pub(super) fn totals(c: &Continuum) -> Totals {
    let points = &c.points;
    let g = c.settings.gravity;
    let inertia = 0.25 * c.settings.cell * c.settings.cell;
    let mut t = Totals::default();
    for i in points.by_id() {
        let i = i as usize;
        let ([x, y, z, volume], [u, v, w, m]) = (points.position[i], points.velocity[i]);
        t.mass += m;
        t.volume += volume;
        let p = [m * u, m * v, m * w];
        let mut spin = [y * p[2] - z * p[1], z * p[0] - x * p[2], x * p[1] - y * p[0]];
        if let Some([dx, dy, dz]) = points.affine.get(i) {
            let curl = [dy[2] - dz[1], dz[0] - dx[2], dx[1] - dy[0]];
            for (spin, curl) in spin.iter_mut().zip(curl) {
                *spin += m * inertia * curl;
            }
        }
        for a in 0..3 {
            t.momentum[a] += p[a];
            t.angular_momentum[a] += spin[a];
        }
        t.kinetic += 0.5 * m * (u * u + v * v + w * w);
        t.potential -= m * (g[0] * x + g[1] * y + g[2] * z);
    }
    t
}
