//! Refusals of, and warnings for, a mixture in which the fine grains cannot be replaced by a continuum. Li et al. 2023 (sections 4 and 6) had good
//! results at a size ratio of 1:5 and up to 40 % of coarse grains; so far mixtures were compared with the same tests with fine
//! grains instead of points (figures/mixture).

use crate::model::continuum::MpmTest;
use engine::dem::physics::Physics;
use engine::grains::sphere_volume;
use engine::material::Material;
use engine::mpm::loading_plate::ghost_radius;
use engine::mpm::{Dimension, Transfer};

/// Least ratio of the mean diameter of the coarse grains to that of the points' contact spheres: 5, less some room for the
/// scatter of a drawn gradation.
const RATIO: f64 = 4.9;
/// Largest share of coarse grains in the mass: 40 %, and some room for the scatter of a drawn gradation.
const CONTENT: f64 = 0.41;
/// Largest ratio of a cell's edge to the diameter of the smallest grain; a cell wider than the grain is refused.
const CELL: f64 = 0.5;
/// Least number of points, below which cells are refused, in a cell that is full of soil whose porosity is [`POROSITY`]. With 2.4 of them (`experiments/mixture/twin_points.toml`, `grid.cell_mm = 2.5`) neighbours lose each other as
/// the soil shears: it does not dilate, and its strength has no peak.
const POINTS: f64 = 4.0;
/// Porosity of dense soil, as of the specimens of Li et al. 2023.
const POROSITY: f64 = 0.37;
/// Largest share of grains that have a neighbour at a gap smaller than the diameter of a point's contact sphere.
const CROWDED: f64 = 0.25;

/// The sizes of a mixture that the limits are for.
struct Sizes {
    /// Mean diameter of the coarse grains, m.
    mean: f64,
    /// Smallest diameter of the coarse grains, m.
    least: f64,
    /// Mean and largest diameter of the points' contact spheres, m.
    ghosts: [f64; 2],
    /// Share of the coarse grains in the mass.
    content: f64,
}

/// Sizes of the present grains and points, or of those that will grow; `None` where grains or points are missing.
fn sizes(materials: &[Material], rig: &MpmTest) -> Option<Sizes> {
    let density = |material: u8| materials[usize::from(material)].density;
    let grains = &rig.coarse.as_ref()?.grains;
    if let (Some(growth), true) = (&rig.growth, grains.is_empty()) {
        let coarse = growth.coarse.filter(|_| growth.as_points && growth.fines.count() > 0)?;
        let [mass, fine] = [coarse, growth.fines].map(|f| f.volume * density(f.material));
        let (least, ghosts) = (2.0 * coarse.radii[0], [growth.fines.mean_diameter(), 2.0 * growth.fines.radii[1]]);
        return Some(Sizes { mean: coarse.mean_diameter(), least, ghosts, content: mass / (mass + fine) });
    }
    // a rigid body that is no sphere counts by the sphere of its volume, a sheet has none
    let blocks = rig.coarse.iter().flat_map(|c| &c.blocks).map(|b| b.radius).filter(|r| r.is_finite());
    let radii: Vec<f64> = grains.iter().map(|g| g.radius).chain(blocks).collect();
    if radii.is_empty() || rig.points.is_empty() {
        return None;
    }
    let count = rig.points.len();
    let ghosts = (0..count).map(|i| 2.0 * ghost_radius(rig.settings.dimension, rig.points.solid(i)));
    let (sum, largest) = ghosts.fold((0.0, 0.0_f64), |(sum, most), d| (sum + d, most.max(d)));
    // an outline leaves out some of both, by numbers of their own
    let [more_points, more_grains] = rig.left_out.map(|n| n as f64);
    let mass: f64 = grains.iter().map(|g| density(g.material) * sphere_volume(g.radius)).sum();
    let of_blocks: f64 = rig.coarse.iter().flat_map(|c| &c.blocks).map(|b| b.mass).sum();
    let mass = mass * (1.0 + more_grains / grains.len().max(1) as f64) + of_blocks;
    let fine = rig.points.velocity.iter().map(|v| v[3]).sum::<f64>() * (1.0 + more_points / count as f64);
    Some(Sizes {
        mean: 2.0 * radii.iter().sum::<f64>() / radii.len() as f64,
        least: 2.0 * radii.iter().copied().fold(f64::INFINITY, f64::min),
        ghosts: [sum / count as f64, largest],
        content: mass / (mass + fine),
    })
}

/// Largest damping ratio that the transfer may give to the slowest standing wave of a specimen, beyond which stresses lag behind strains. With 0.01, 0.05, 0.13 and
/// 0.65 (1, 4, 10 and 50 steps of the points in a cycle of `experiments/mixture/triaxial_small.toml`) q at 0.03 % strain is 2.75, 2.98, 3.04 and 3.88 kPa; without PIC
/// it is 2.13 kPa with 1 step and 2.07 kPa with 10.
const VISCOUS: f64 = 0.1;

/// Warns where the transfer between points and nodes acts as a viscosity that a test of points feels, as it does where the points' steps of `dt` seconds are far
/// shorter than their stable step (`stepping.continuum_steps`, a small `stepping.safety`, stiff contacts).
///
/// The share α of PIC (`grid.pic`) replaces a velocity at every step by its mean over neighbours, however short the step is. Quadratic splines, to the nodes and
/// back, average with a variance of h²/2 in cells of edge h, so that each step takes the share α k² h²/4 of a wave of number k: a kinematic viscosity
/// ν = α h²/(4 dt). The slowest standing wave of a specimen of height L with the wave speed c, k = π/L, has the damping ratio ζ = ν k/(2 c) = π α h²/(8 dt c L).
pub fn viscous(rig: &MpmTest, dt: f64) -> Option<String> {
    let (specimen, Transfer::Blend { pic }) = (rig.specimen().filter(|_| !rig.points.is_empty())?, rig.settings.transfer) else {
        return None;
    };
    let height = specimen.size[if rig.settings.dimension == Dimension::Space { 2 } else { 1 }];
    let (c, h) = (rig.laws[usize::from(specimen.law)].wave_speed(rig.points_inertia * specimen.density), rig.settings.cell);
    let ratio = std::f64::consts::PI * pic * h * h / (8.0 * dt * c * height);
    (ratio > VISCOUS).then(|| {
        format!(
            "grid.pic = {pic} in steps of {dt:.2e} s makes the points viscous: the slowest wave through the specimen has a damping ratio of {ratio:.2}, above {VISCOUS}, and stresses lag behind strains; \
             leave out stepping.continuum_steps, raise stepping.safety, or lower grid.pic"
        )
    })
}

impl Sizes {
    /// Edge of a cell, m, that holds eight points, two along each edge.
    fn full_cell(&self) -> f64 {
        2.0 * (sphere_volume(0.5 * self.ghosts[0]) / (1.0 - POROSITY)).cbrt()
    }
}

/// Why the cells of a test of a mixture are refused, with what would do; `None`: they are not. Where grains break (`crushing`) their daughters are smaller than any cell
/// sooner or later, so that small grains are only warned of.
pub fn refusal(materials: &[Material], rig: &MpmTest, crushing: bool) -> Option<String> {
    let sizes = sizes(materials, rig).filter(|_| rig.specimen().is_some())?;
    let (cell, full) = (rig.settings.cell, sizes.full_cell());
    let held = 8.0 * (cell / full).powi(3);
    if held < POINTS {
        return Some(format!(
            "must be at least {:.4}, where a cell holds {POINTS} points, better {:.4}, where it holds 8: with {held:.1} the soil comes apart as it shears",
            1e3 * full * (POINTS / 8.0).cbrt(),
            1e3 * full
        ));
    }
    (cell > sizes.least && !crushing).then(|| {
        format!(
            "must be at most {:.4}, the diameter of the smallest grain, better {:.4}, half of it: all soil around such a grain moves as one",
            1e3 * sizes.least,
            1e3 * CELL * sizes.least
        )
    })
}

/// One warning for each limit that the mixture exceeds; they stand in `summary.json` (`outside_of_the_method`).
pub fn warnings(physics: &Physics, rig: &MpmTest) -> Vec<String> {
    let Some(sizes) = sizes(&physics.materials, rig) else { return Vec::new() };
    let Sizes { mean, least, ghosts: [ghost, widest], content } = sizes;
    let mut doubts = Vec::new();
    if mean < RATIO * ghost {
        doubts.push(format!(
            "grains are {:.1} times as large as the ghosts of points; below 5 a continuum does not see what is between them: use a smaller grid.cell_mm",
            mean / ghost
        ));
    }
    if rig.settings.cell > CELL * least {
        doubts.push(format!(
            "grid.cell_mm = {:.4} is more than half of the smallest grain, {:.4} mm: the material around it moves as one",
            1e3 * rig.settings.cell,
            1e3 * least
        ));
    }
    if rig.specimen().is_some() && content > CONTENT {
        doubts.push(format!(
            "{:.0} % of the mass are coarse grains: mixtures of points were compared with grains alone up to 40 % (strength within 8 % there); beyond, points do not fill what is between the coarse grains",
            100.0 * content
        ));
    }
    let grains = rig.coarse.as_ref().map_or(&[][..], |c| &c.grains);
    let count = grains.len() as f64;
    let near = |(i, g): &(usize, &crate::model::GrainSpec)| {
        grains.iter().enumerate().any(|(j, h)| {
            let d: f64 = (0..3).map(|a| (g.position[a] - h.position[a]) * (g.position[a] - h.position[a])).sum();
            j != *i && d.sqrt() < g.radius + h.radius + widest
        })
    };
    let crowded = grains.iter().enumerate().filter(near).count() as f64;
    // in a free scene grains may rest on each other on purpose
    if rig.specimen().is_some() && crowded > CROWDED * count {
        doubts
            .push(format!("{crowded} of {count} grains have a neighbour nearer than a ghost is wide: no points are between them"));
    }
    let mut of_points = rig.coarse.iter().flat_map(|c| &c.point_materials).map(|m| &physics.materials[usize::from(*m)]);
    if let (Some(_), Some(soil)) = (rig.specimen(), of_points.find(|m| m.interface_friction.is_none())) {
        doubts.push(format!(
            "points have their grains' friction on coarse grains, {:.3}: fine grains roll along coarse ones and pass on less (a third of it in figures/mixture); \
             give continuum.interface_friction, which comminute calibrate fines --interface measures",
            soil.friction
        ));
    }
    doubts
}
