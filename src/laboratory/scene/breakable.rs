//! Checks whether grains and blocks can break at all: a grain must be larger than the comminution limit and touch another grain or a wall.
//! Contacts with points break neither.

use super::crushing::extremes;
use crate::model::continuum::{MpmSpecimen, MpmTest, Test};
use crate::model::{Model, Rig};
use engine::breakage::CrushModel;

/// A warning that no grain can break; `None` where one can, or where breakage is off.
pub fn none_breaks(model: &Model) -> Option<String> {
    let crush = model.physics.crush.as_ref()?;
    let (_, largest) = extremes(&model.rig);
    if largest == 0.0 {
        return Some("crushing.enabled = true, but there are no grains: points do not break".into());
    }
    if largest <= crush.d_limit {
        return Some(format!(
            "crushing.enabled = true, but no grain can break: the largest has {:.4} mm, the comminution limit is {:.4} mm",
            1e3 * largest,
            1e3 * crush.d_limit
        ));
    }
    match &model.rig {
        Rig::Continuum(rig) if rig.growth.is_none() => unloaded(crush, rig),
        _ => None,
    }
}

/// A ball around a grain or a body at the start of a test.
struct Ball {
    centre: [f64; 3],
    radius: f64,
    breaks: bool,
}

/// A warning for a mixture in which points keep all that may break apart.
fn unloaded(crush: &CrushModel, rig: &MpmTest) -> Option<String> {
    let coarse = rig.coarse.as_ref()?;
    let loaded = match &rig.test {
        Test::Free { .. } => coarse.grains.len() + coarse.blocks.len() > 1 || !coarse.walls.is_empty(),
        // platens press rigid bodies without points together
        Test::Oedometer(s) | Test::Triaxial { specimen: s, .. } => {
            let breaks = |radius: f64| 2.0 * radius > crush.d_limit;
            let grains = coarse.grains.iter().map(|g| Ball { centre: g.position, radius: g.radius, breaks: breaks(g.radius) });
            let bodies = coarse.blocks.iter();
            let bodies =
                bodies.map(|b| Ball { centre: b.centre, radius: b.solid().reach(), breaks: !b.driven && breaks(b.radius) });
            let balls: Vec<Ball> = grains.chain(bodies).collect();
            let mut breakable = balls.iter().enumerate().filter(|(_, ball)| ball.breaks);
            s.bed.is_some()
                || breakable.any(|(i, g)| {
                    let mut others = balls.iter().enumerate().filter(|(j, _)| *j != i);
                    at_a_platen(s, g) || others.any(|(_, h)| touch_at_end(s, g, h))
                })
        }
    };
    let why = "contacts with points break no grain and no block, so probably none breaks";
    (!loaded).then(|| match rig.test {
        Test::Free { .. } => format!("crushing.enabled = true, but there is no other grain and no [[wall]] to touch: {why}"),
        _ => format!(
            "crushing.enabled = true, but points keep all grains apart: a grain that moves with the material touches no other grain and no platen; {why}"
        ),
    })
}

/// Whether two balls touch at the end of a test in which they move with the material.
fn touch_at_end(s: &MpmSpecimen, g: &Ball, h: &Ball) -> bool {
    let [x, y, z]: [f64; 3] = std::array::from_fn(|a| g.centre[a] - h.centre[a]);
    let z = z * (1.0 - s.axial_strain);
    (x * x + y * y + z * z).sqrt() <= g.radius + h.radius
}

/// Whether a ball touches the bottom or the top at the end of such a test, or a side at the start.
fn at_a_platen(s: &MpmSpecimen, g: &Ball) -> bool {
    let away = |a: usize| (g.centre[a] - s.lower[a]).min(s.lower[a] + s.size[a] - g.centre[a]);
    let side = if s.round {
        let [x, y, _] = s.base();
        0.5 * s.size[0] - (g.centre[0] - x).hypot(g.centre[1] - y)
    } else {
        away(0).min(away(1))
    };
    (away(2) * (1.0 - s.axial_strain)).min(side) <= g.radius
}
