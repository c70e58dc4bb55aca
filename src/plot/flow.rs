//! Material points of plane strain as tiles coloured by their speed, for pictures that show other bodies among them.

use super::colour;
use super::continuum::high_of;
use super::error::Result;
use super::specimen::{Key, TONES, Tones};
use super::table::Table;
use std::collections::BTreeMap;

/// Tiles in a row that have one tone: left end, lower end, width, m, and the tone.
pub type Run = ([f64; 2], f64, usize);

/// Edge of a tile over the largest edge of a point: so that no row of tiles is empty between points that stand side by side.
const WIDE: f64 = 1.3;

/// The points of one instant.
#[derive(Clone, Debug, Default)]
pub struct Flow {
    /// Edge of a tile, m.
    pub edge: f64,
    /// Centre, m, and speed, m/s, of each point.
    points: Vec<([f64; 2], f64)>,
}

impl Flow {
    /// Reads a table of points; without points or with a number that is none nothing is shown.
    ///
    /// # Errors
    /// A table that lacks a column.
    pub fn read(table: Option<&Table>) -> Result<Flow> {
        let Some(table) = table.filter(|t| t.len() > 0) else { return Ok(Flow::default()) };
        let [x, y, volume] = [table.numbers("x_m")?, table.numbers("y_m")?, table.numbers("volume_m3")?];
        let [u, v] = [table.numbers("vx_m_s")?, table.numbers("vy_m_s")?];
        let edge = WIDE * volume.iter().fold(0.0_f64, |most, v| most.max(v.sqrt()));
        let points: Vec<_> = (0..table.len()).map(|i| ([x[i], y[i]], u[i].hypot(v[i]))).collect();
        let sound = edge.is_finite() && points.iter().all(|(p, v)| p.iter().chain([v]).all(|x| x.is_finite()));
        Ok(if sound { Flow { edge, points } } else { Flow::default() })
    }

    /// Left, right, lower and upper end of the points, m.
    pub fn bounds(&self) -> impl Iterator<Item = [f64; 2]> {
        let half = 0.5 * self.edge;
        self.points.iter().flat_map(move |([x, y], _)| [[x - half, y - half], [x + half, y + half]])
    }

    /// The tones of speed of several instants, with their key; `None` without points.
    pub fn tones(all: &[Flow]) -> Option<Tones> {
        let speeds: Vec<f64> = all.iter().flat_map(|f| f.points.iter().map(|p| p.1)).collect();
        let hi = (!speeds.is_empty()).then(|| high_of(speeds))?;
        let palette = (0..TONES).map(|i| colour::sequence(1.0 - 0.75 * i as f64 / (TONES - 1) as f64)).collect();
        Some(Tones { palette, key: Key::Field { name: "speed (m/s)".into(), lo: 0.0, hi } })
    }

    /// The tiles that have points, row by row, those side by side of one tone as one; a tile has the tone of its fastest point.
    pub fn runs(&self, tones: &Tones) -> Vec<Run> {
        let Key::Field { hi, .. } = &tones.key else { return Vec::new() };
        let most = (TONES - 1) as f64;
        let tone = |v: f64| if *hi > 0.0 { (v / hi * most).round().clamp(0.0, most) as usize } else { 0 };
        let mut tiles: BTreeMap<[i64; 2], usize> = BTreeMap::new();
        for (p, speed) in &self.points {
            let [x, y] = p.map(|x| (x / self.edge).floor() as i64);
            let at = tiles.entry([y, x]).or_default();
            *at = (*at).max(tone(*speed));
        }
        let mut runs: Vec<Run> = Vec::new();
        let mut last: Option<([i64; 2], usize)> = None;
        for ([y, x], tone) in tiles {
            match (runs.last_mut(), last) {
                (Some(run), Some(before)) if before == ([y, x - 1], tone) => run.1 += self.edge,
                _ => runs.push(([x as f64 * self.edge, y as f64 * self.edge], self.edge, tone)),
            }
            last = Some(([y, x], tone));
        }
        runs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_side_by_side_of_one_speed_are_one_strip() {
        let points = vec![([0.5, 0.5], 1.0), ([1.5, 0.5], 1.0), ([2.5, 0.5], 0.0), ([0.5, 1.5], 1.0), ([4.5, 1.5], 1.0)];
        let flow = Flow { edge: 1.0, points };
        let tones = Flow::tones(std::slice::from_ref(&flow)).expect("tones");
        let top = TONES - 1;
        let expected = [([0.0, 0.0], 2.0, top), ([2.0, 0.0], 1.0, 0), ([0.0, 1.0], 1.0, top), ([4.0, 1.0], 1.0, top)];
        assert_eq!(flow.runs(&tones), expected);
        assert!(Flow::tones(&[Flow::default()]).is_none());
    }
}
