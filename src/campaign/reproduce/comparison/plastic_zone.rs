//! How far plastic strain gathers around the coarse grains of a mixture (Li et al. 2023, Figs 20 and 23).

use laboratory::error::Result;
use std::path::Path;

/// Distance to the surface of a grain, in mean edges of the points, below which a point is next to the grain.
const NEXT: f64 = 1.0;

/// Mean plastic strain of the points next to coarse grains over that of all points, at the end of the run in a folder; `None` without points, grains or plastic strain.
///
/// # Errors
/// Tables that cannot be read.
pub fn around_grains(folder: &Path) -> Result<Option<f64>> {
    let [points, grains] = ["points_final.csv", "grains_final.csv"].map(|name| folder.join(name));
    if !points.exists() || !grains.exists() {
        return Ok(None);
    }
    let rows = |[x, y, z, w]: [Vec<f64>; 4]| (0..x.len()).map(|i| [x[i], y[i], z[i], w[i]]).collect::<Vec<_>>();
    let [x, y, z, strain, volumes] = plot::read_columns(&points, ["x_m", "y_m", "z_m", "plastic_strain", "volume_m3"])?;
    let grains = plot::read_columns(&grains, ["x_m", "y_m", "z_m", "r_m"])?;
    Ok(concentration(&rows([x, y, z, strain]), &volumes, &rows(grains)))
}

/// As [`around_grains`]; `points`: place, m, and plastic strain; `volumes`: theirs, m³; `grains`: centre and radius, m.
fn concentration(points: &[[f64; 4]], volumes: &[f64], grains: &[[f64; 4]]) -> Option<f64> {
    let reach = NEXT * volumes.iter().map(|v| v.cbrt()).sum::<f64>() / volumes.len() as f64;
    let square = |p: &[f64; 4], g: &[f64; 4]| (0..3).map(|a| (p[a] - g[a]).powi(2)).sum::<f64>();
    let is_next = |p: &&[f64; 4]| grains.iter().any(|g| square(p, g) < (g[3] + reach).powi(2));
    let mean = |strains: Vec<f64>| (!strains.is_empty()).then(|| strains.iter().sum::<f64>() / strains.len() as f64);
    let all = mean(points.iter().map(|p| p[3]).collect()).filter(|all| *all > 0.0)?;
    Some(mean(points.iter().filter(is_next).map(|p| p[3]).collect())? / all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_next_to_a_grain_are_those_within_an_edge_of_its_surface() {
        let grains = [[0.0, 0.0, 0.0, 1.0]];
        // edges of 0.2; the surface is at 1
        let points = [[1.1, 0.0, 0.0, 0.3], [0.0, -1.19, 0.0, 0.1], [0.0, 0.0, 1.3, 0.05], [3.0, 0.0, 0.0, 0.05]];
        let found = concentration(&points, &[8e-3; 4], &grains).expect("strain");
        assert!((found - 0.2 / 0.125).abs() < 1e-12, "{found}");
        assert_eq!(concentration(&points, &[8e-3; 4], &[]), None);
        assert_eq!(concentration(&points.map(|p| [p[0], p[1], p[2], 0.0]), &[8e-3; 4], &grains), None);
        let empty = tempfile::tempdir().expect("folder");
        assert_eq!(around_grains(empty.path()).expect("nothing to read"), None);
    }
}
