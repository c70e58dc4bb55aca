//! Grains as the table that a free scene reads (`grains_csv`).

use super::Packing;
use std::fmt::Write as _;

/// The text of the table; `materials`: the name of each type; where it is empty, the grains have the only material of the scene. Velocities
/// and spins are left out where no grain moves.
pub fn write(packing: &Packing, materials: &[String]) -> String {
    let moving = packing.grains.iter().any(|g| g.velocity != [0.0; 3] || g.spin != [0.0; 3]);
    let mut text = String::from("x_m,y_m,z_m,r_m");
    text += if materials.is_empty() { "" } else { ",material" };
    text += if moving { ",vx_m_s,vy_m_s,vz_m_s,wx_rad_s,wy_rad_s,wz_rad_s\n" } else { "\n" };
    for g in &packing.grains {
        let [x, y, z] = g.position;
        let _ = write!(text, "{x:?},{y:?},{z:?},{:?}", g.radius);
        if let Some(name) = materials.get(g.kind) {
            let _ = write!(text, ",{}", crate::record::specimen::quoted(name));
        }
        if moving {
            [g.velocity, g.spin].as_flattened().iter().for_each(|x| {
                let _ = write!(text, ",{x:?}");
            });
        }
        text.push('\n');
    }
    text
}
