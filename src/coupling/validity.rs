//! Where a mixture leaves the range in which its grains can be in a continuum. Li et al. 2023 (sections 4 and 6) had good results at a size ratio of 1:5 and up to 40 % of
//! coarse grains.

use crate::grains::sphere_volume;
use crate::model::Model;
use crate::model::continuum::Continuum as Rig;
use crate::mpm::Dimension;
use crate::mpm::platen::ghost_radius;

/// Mean diameter of coarse grains over that of ghosts, at least; a little room for a gradation.
const RATIO: f64 = 4.9;
/// Coarse grains in the mass, at most.
const CONTENT: f64 = 0.6;
/// Cells over the diameter of the smallest grain, at most.
const CELL: f64 = 0.5;
/// Share of grains that have a neighbour nearer than a ghost is wide, at most.
const CROWDED: f64 = 0.25;

/// What is outside of that range, in words.
pub fn doubts(model: &Model, rig: &Rig) -> Vec<String> {
    let Some(coarse) = rig.coarse.as_ref().filter(|c| !c.grains.is_empty()) else { return Vec::new() };
    if rig.points.is_empty() {
        return Vec::new();
    }
    let (grains, mut doubts) = (&coarse.grains, Vec::new());
    let count = grains.len() as f64;
    let mean = 2.0 * grains.iter().map(|g| g.radius).sum::<f64>() / count;
    let least = 2.0 * grains.iter().map(|g| g.radius).fold(f64::INFINITY, f64::min);
    let ghost = 2.0 * ghost_radius(Dimension::Space, (0..rig.points.len()).map(|i| rig.points.solid(i)).fold(0.0, f64::max));
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
    let mass: f64 = grains.iter().map(|g| model.materials[usize::from(g.material)].density * sphere_volume(g.radius)).sum();
    let fine: f64 = rig.points.velocity.iter().map(|v| v[3]).sum();
    let content = mass / (mass + fine);
    if rig.specimen().is_some() && content > CONTENT {
        doubts.push(format!("{:.0} % of the mass are coarse grains: above {:.0} % they bear most of the stress, and points do not fill what is between them", 100.0 * content, 100.0 * CONTENT));
    }
    let near = |(i, g): &(usize, &crate::model::GrainSpec)| {
        grains.iter().enumerate().any(|(j, h)| {
            let d: f64 = (0..3).map(|a| (g.position[a] - h.position[a]) * (g.position[a] - h.position[a])).sum();
            j != *i && d.sqrt() < g.radius + h.radius + ghost
        })
    };
    let crowded = grains.iter().enumerate().filter(near).count() as f64;
    if crowded > CROWDED * count {
        doubts
            .push(format!("{crowded} of {count} grains have a neighbour nearer than a ghost is wide: no points are between them"));
    }
    doubts
}
