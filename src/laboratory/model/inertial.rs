//! Inertial numbers of a test of points between platens: strain rate times d √(ρ/p) (Li et al. 2023, eq. 42), with the diameter d of grains, the inertia ρ over
//! their volume, and the mean stress p. A point counts as its contact sphere.

use super::Model;
use super::continuum::{Fraction, MpmTest};
use engine::grains::sphere_volume;
use engine::mpm::Dimension;
use engine::mpm::loading_plate::ghost_radius;

/// Inertial numbers at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertialNumbers {
    /// Of the points, with [`MpmTest::points_inertia`].
    pub points: f64,
    /// Of the coarse grains and rigid bodies; `None`: there are none.
    pub coarse: Option<f64>,
}

/// Mean diameter, weighted by volume, times √ρ, √(kg/m), of bodies that are given by diameter, m, and inertia, kg. `None` without bodies. Times the strain rate
/// over √p it is their inertial number.
pub fn size(bodies: impl IntoIterator<Item = [f64; 2]>) -> Option<f64> {
    let [mut volume, mut weighted, mut inertia] = [0.0; 3];
    for [diameter, m] in bodies {
        let v = sphere_volume(0.5 * diameter);
        (volume, weighted, inertia) = (volume + v, weighted + v * diameter, inertia + m);
    }
    (volume > 0.0).then(|| weighted / volume * (inertia / volume).sqrt())
}

/// As [`size`], of the points of a specimen, with the inertia that they move with.
pub fn size_of_points(rig: &MpmTest) -> Option<f64> {
    let (points, dimension) = (&rig.points, rig.settings.dimension);
    if dimension == Dimension::PlaneStrain {
        // masses are per metre: d √ρ of one cylinder is that of all
        let of = |i: usize| 2.0 * ghost_radius(dimension, points.solid(i)) * (points.velocity[i][3] / points.solid(i)).sqrt();
        let sum: f64 = (0..points.len()).map(of).sum();
        return (!points.is_empty()).then(|| sum / points.len() as f64 * rig.points_inertia.sqrt());
    }
    size((0..points.len()).map(|i| [2.0 * ghost_radius(dimension, points.solid(i)), rig.points_inertia * points.velocity[i][3]]))
}

/// Inertial numbers at the strain rate `rate`, 1/s, and the mean stress `pressure`, Pa, before the test has begun. `None` in a free scene, without points and
/// without stress.
pub fn at_the_start(model: &Model, rig: &MpmTest, rate: f64, pressure: f64) -> Option<InertialNumbers> {
    let [points, _] = rig.counts();
    rig.specimen().filter(|_| pressure > 0.0 && points > 0)?;
    let density = |material: u8| model.physics.materials[usize::from(material)].density;
    let of = |f: Fraction, factor: f64| f.mean_diameter() * (factor * density(f.material)).sqrt();
    let (points, coarse) = match &rig.growth {
        Some(growth) => (of(growth.fines, rig.points_inertia), growth.coarse.map(|c| of(c, 1.0))),
        None => {
            let grains = rig.coarse.iter().flat_map(|c| &c.grains);
            let grains = grains.map(|g| [2.0 * g.radius, density(g.material) * sphere_volume(g.radius)]);
            let blocks = rig.coarse.iter().flat_map(|c| &c.blocks).filter(|b| b.mass > 0.0).map(|b| [2.0 * b.radius, b.mass]);
            (size_of_points(rig)?, size(grains.chain(blocks)))
        }
    };
    let number = |size: f64| rate * size / pressure.sqrt();
    Some(InertialNumbers { points: number(points), coarse: coarse.map(number) })
}
