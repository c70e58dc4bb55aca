//! Force on each wall of a free scene against the way of the wall that moves furthest.

use super::Input;
use super::axis::Axis;
use super::colour;
use super::error::Result;
use super::plot::{Plot, Series};
use super::table::Table;

/// The figure of a run in which a wall moves; none for other runs, and none for several runs.
pub fn plots(input: &Input) -> Result<Vec<Plot>> {
    let [group] = &input.groups[..] else { return Ok(Vec::new()) };
    let [run] = &group.runs[..] else { return Ok(Vec::new()) };
    let Some(table) = Table::read_if_there(&run.dir.join("walls.csv"))? else { return Ok(Vec::new()) };
    let [wall, way, force] = ["wall", "displacement_mm", "force_N"].map(|name| table.numbers(name));
    let (wall, way, force) = (wall?, way?, force?);
    let count = wall.iter().fold(0.0_f64, |most, k| most.max(*k)) as usize + 1;
    let of = |values: &[f64], k: usize| -> Vec<f64> {
        wall.iter().zip(values).filter(|(w, _)| **w as usize == k).map(|(_, x)| *x).collect()
    };
    let ways: Vec<Vec<f64>> = (0..count).map(|k| of(&way, k)).collect();
    let furthest = |way: &Vec<f64>| way.iter().map(|x| x.abs()).fold(0.0, f64::max);
    let Some(moved) = ways.iter().max_by(|a, b| furthest(a).total_cmp(&furthest(b))).filter(|way| furthest(way) > 0.0) else {
        return Ok(Vec::new());
    };
    let line = |k: usize| {
        let points = moved.iter().copied().zip(of(&force, k).into_iter().map(|f| 1e-3 * f)).collect();
        Series::line(&format!("wall {k}"), colour::kind(k), colour::dash(k), points)
    };
    Ok(vec![Plot {
        name: "wall_forces".into(),
        title: vec![run.label()],
        legend_title: None,
        x: Axis::linear("way of the moving wall (mm)", "displacement_mm").including(&[0.0]),
        y: Axis::linear("normal force on the wall (kN)", "force_kN").including(&[0.0]),
        series: (0..count).map(line).collect(),
        equal: false,
    }])
}
