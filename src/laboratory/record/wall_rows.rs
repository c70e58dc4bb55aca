//! Rows of `walls.csv`: where the walls of a free scene are and what presses on them, where one of them moves.

use engine::boundary::{Wall, WallSpec};
use engine::coupling::Mixture;
use table::Row;

/// Table with place and force of each wall.
pub const WALL_ROWS: &str = "walls.csv";

/// A row for each wall at step `step` and time `time`, s, where a wall of the scene moves; `start` are the walls of the scene.
pub fn rows(mixture: &Mixture, start: &[WallSpec], step: u64, time: f64) -> Vec<Row> {
    if !mixture.has_moving_walls() {
        return Vec::new();
    }
    let row = |(k, (wall, start)): (usize, (&Wall, &WallSpec))| -> Row {
        let moved = wall.way_since(&start.shape);
        vec![
            ("step", step.into()),
            ("time_s", time.into()),
            ("wall", k.into()),
            ("displacement_mm", (1e3 * moved).into()),
            ("speed_m_s", wall.speed.into()),
            ("force_N", wall.reaction.into()),
            ("work_J", wall.work.into()),
        ]
    };
    mixture.grains.walls.iter().zip(start).enumerate().map(row).collect()
}
