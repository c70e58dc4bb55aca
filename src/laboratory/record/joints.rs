//! Records of joints of rigid bodies: `joints.csv` has a row for each joint at every row of the history.

use engine::rigid::{Blocks, Joint};
use table::Row;

/// Table with what each joint bears.
pub const JOINTS: &str = "joints.csv";

/// A row of [`JOINTS`] for each joint at step `step` and time `time`, s.
pub fn rows(blocks: &Blocks, step: u64, time: f64) -> Vec<Row> {
    let row = |(k, joint): (usize, &Joint)| -> Row {
        let (bond, now) = (&joint.bond, &joint.now);
        let [[x, y, z], [p, q, r]] = now.on_second;
        let [normal, shear, bending, twist] = now.load;
        vec![
            ("step", step.into()),
            ("time_s", time.into()),
            ("joint", k.into()),
            ("first", u64::from(bond.first).into()),
            ("second", bond.second.map_or(-1.0, f64::from).into()),
            ("fx_N", x.into()),
            ("fy_N", y.into()),
            ("fz_N", z.into()),
            ("mx_N_m", p.into()),
            ("my_N_m", q.into()),
            ("mz_N_m", r.into()),
            ("tension_N", normal.into()),
            ("shear_N", shear.into()),
            ("bending_N_m", bending.into()),
            ("twist_N_m", twist.into()),
            ("utilisation", now.utilisation.into()),
            ("broken_at_s", joint.broken.unwrap_or(-1.0).into()),
            ("elastic_J", now.stored.into()),
            ("viscous_J", joint.viscous.into()),
            ("released_J", joint.released.into()),
        ]
    };
    blocks.drives().into_iter().flat_map(|drives| &drives.joints).enumerate().map(row).collect()
}
