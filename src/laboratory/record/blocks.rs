//! Records of rigid bodies that are no spheres: `blocks.csv` has a row for each body at every row of the history; snapshots have
//! their surfaces.

use super::vtk::{self, Fact, Field, VtkError};
use crate::error::Result;
use engine::math::vector::{dot, plus};
use engine::rigid::Blocks;
use std::path::Path;
use table::Row;

/// Table with place, motion and forces of each body.
pub const TRACKS: &str = "blocks.csv";

/// Table with the surface of each body, in its own axes.
pub const SURFACES: &str = "block_surfaces.csv";

/// Rows of [`SURFACES`] for a body: three for each triangle. Where bodies break, with its generation: a piece keeps the number of the body, but not its surface.
pub fn surface(blocks: &Blocks, k: usize) -> Vec<Row> {
    let mesh = blocks.blocks[k].solid().surface();
    let generation = generation(blocks, k);
    let row = |corner: &u32| -> Row {
        let [x, y, z] = mesh.corners[*corner as usize];
        let mut row: Row = vec![("block", k.into())];
        row.extend(generation.map(|g| ("generation", g.into())));
        row.extend([("x_m", x.into()), ("y_m", y.into()), ("z_m", z.into())]);
        row
    };
    mesh.triangles.iter().flatten().map(row).collect()
}

/// Number of breakages between a body and the body of the start; `None` where bodies do not break.
fn generation(blocks: &Blocks, k: usize) -> Option<u64> {
    blocks.breaking().map(|breaking| u64::from(breaking.bodies[k].generation))
}

/// A row of [`TRACKS`] for each body at step `step` and time `time`, s, under `gravity`, m/s².
pub fn rows(blocks: &Blocks, gravity: [f64; 3], step: u64, time: f64) -> impl Iterator<Item = Row> {
    let forces = blocks.all_forces();
    blocks.blocks.iter().enumerate().map(move |(k, b)| {
        let ([x, y, z], [u, v, w], [p, q, r], [a, i, j, l]) = (b.centre, b.velocity, b.spin(), b.turn);
        let mut row: Row = vec![("step", step.into()), ("time_s", time.into()), ("block", k.into())];
        row.extend(generation(blocks, k).map(|g| ("generation", g.into())));
        row.extend([
            ("mass_kg", b.mass.into()),
            ("x_m", x.into()),
            ("y_m", y.into()),
            ("z_m", z.into()),
            ("q_w", a.into()),
            ("q_x", i.into()),
            ("q_y", j.into()),
            ("q_z", l.into()),
            ("vx_m_s", u.into()),
            ("vy_m_s", v.into()),
            ("vz_m_s", w.into()),
            ("wx_rad_s", p.into()),
            ("wy_rad_s", q.into()),
            ("wz_rad_s", r.into()),
        ]);
        const NAMES: [[&str; 3]; 4] = [
            ["points_x_N", "points_y_N", "points_z_N"],
            ["grains_x_N", "grains_y_N", "grains_z_N"],
            ["walls_x_N", "walls_y_N", "walls_z_N"],
            ["blocks_x_N", "blocks_y_N", "blocks_z_N"],
        ];
        for (names, force) in NAMES.into_iter().zip(forces[k]) {
            row.extend(names.into_iter().zip(force.map(Into::into)));
        }
        if let Some(drives) = blocks.drives() {
            let work = blocks.drive(k).map_or(0.0, |drive| drive.of_push + drive.of_hold);
            if !drives.joints.is_empty() {
                row.extend(["joints_x_N", "joints_y_N", "joints_z_N"].into_iter().zip(blocks.joint_force(k).map(Into::into)));
            }
            let outer = blocks.outer_force(k, gravity, time);
            row.extend(["outer_x_N", "outer_y_N", "outer_z_N"].into_iter().zip(outer.map(Into::into)));
            row.push(("outer_work_J", work.into()));
        }
        row.push(("kinetic_J", b.kinetic().into()));
        row
    })
}

/// Writes the surfaces of all bodies as a ParaView snapshot, with `facts` noted in it.
pub fn write_surfaces(path: &Path, facts: &[Fact], step: u64, blocks: &Blocks) -> Result<()> {
    let (mut corners, mut triangles, mut counts) = (Vec::new(), Vec::new(), Vec::new());
    for block in &blocks.blocks {
        let (pose, mesh, first) = (block.pose(0.0), block.solid().surface(), corners.len() as u32);
        corners.extend(mesh.corners.iter().map(|p| plus(pose.centre, pose.outwards(*p))));
        triangles.extend(mesh.triangles.iter().map(|t| t.map(|k| first + k)));
        counts.push(mesh.triangles.len());
    }
    let mut fields: Vec<Field> = Vec::new();
    let mut add = |name: &'static str, of: &dyn Fn(usize) -> Vec<f64>| {
        let each = (0..blocks.blocks.len()).map(of);
        let components = each.clone().next().map_or(1, |first| first.len());
        let values = each.zip(&counts).flat_map(|(of, triangles)| of.repeat(*triangles)).collect();
        fields.push(Field { name, components, values });
    };
    add("block", &|k| vec![k as f64]);
    if blocks.breaking().is_some() {
        add("generation", &|k| generation(blocks, k).map(|g| g as f64).into_iter().collect());
    }
    add("velocity_m_s", &|k| blocks.blocks[k].velocity.to_vec());
    add("spin_rad_s", &|k| blocks.blocks[k].spin().to_vec());
    add("speed_m_s", &|k| vec![dot(blocks.blocks[k].velocity, blocks.blocks[k].velocity).sqrt()]);
    add("material", &|k| vec![f64::from(blocks.blocks[k].material)]);
    vtk::write_surfaces(path, facts, &corners, &triangles, &fields).map_err(VtkError::at(step))
}
