//! Deviatoric stress and volumetric strain against axial strain of triaxial tests (Ciantia et al. 2015, Fig. 12).

use super::Input;
use super::axis::Axis;
use super::colour;
use super::curves::title;
use super::error::Result;
use super::plot::Plot;

/// Name of the figure of volumetric strain, and of the column that it shows.
const VOLUMETRIC: &str = "volumetric_strain";

/// Whether any of the runs is a triaxial test.
pub fn is(input: &Input) -> bool {
    input.groups.iter().any(|group| group.runs.iter().any(super::run::Run::is_triaxial))
}

/// The two figures, each if the records have its columns.
pub fn plots(input: &Input) -> Result<Vec<Plot>> {
    let strain = || Axis::linear("axial strain ε_{a} (%)", "axial_strain_percent").including(&[0.0]);
    let q = Axis::linear("deviatoric stress q (kPa)", "q_kPa").including(&[0.0]);
    let volume = Axis::linear("volumetric strain ε_{v} (%)", "volumetric_strain_percent").including(&[0.0]).downwards();
    let mut out = Vec::new();
    for (name, column, factor, y) in [("deviatoric_stress", "q_kPa", 1.0, q), (VOLUMETRIC, VOLUMETRIC, 100.0, volume)] {
        let mut series = Vec::new();
        for (i, group) in input.groups.iter().enumerate() {
            series.extend(group.series(&group.label, colour::kind(i), colour::dash(i), false, |run| {
                run.branches(("axial_strain", 100.0), (column, factor))
            })?);
        }
        for data in &input.data {
            series.extend(data.against_strain(column, factor)?);
        }
        if !series.is_empty() {
            out.push(Plot { name: name.into(), title: title(input), legend_title: None, x: strain(), y, series, equal: false });
        }
    }
    Ok(out)
}
