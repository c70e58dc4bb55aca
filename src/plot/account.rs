//! The energy account of a continuum or mixture (`account.csv`): what was given and what it has become, against axial strain, in a
//! free scene against time.

use super::Input;
use super::axis::Axis;
use super::colour;
use super::energy::unit;
use super::error::Result;
use super::plot::{Plot, Series};
use super::table::Table;

/// A line of the figure: its legend entry, and the columns that it sums, each with its sign.
type Sum = (&'static str, &'static [(&'static str, f64)]);

/// The lines in the order of the legend; together they have every column once.
const SUMS: [Sum; 8] = [
    ("given", &[("platen_work_J", 1.0), ("gravity_work_J", 1.0), ("released_J", 1.0), ("broken_grains_J", 1.0)]),
    ("elastic", &[("elastic_points_J", 1.0), ("elastic_contacts_J", 1.0)]),
    ("kinetic", &[("kinetic_J", 1.0)]),
    ("plastic work", &[("plastic_work_J", 1.0)]),
    (
        "friction, dashpots",
        &[
            ("slip_grains_J", 1.0),
            ("slip_points_J", 1.0),
            ("viscous_grains_J", 1.0),
            ("viscous_points_J", 1.0),
            ("wall_friction_J", 1.0),
        ],
    ),
    ("local damping", &[("damping_grains_J", 1.0), ("damping_nodes_J", 1.0)]),
    (
        "transfer, lags",
        &[
            ("transfer_J", 1.0),
            ("wall_impact_J", 1.0),
            ("strain_lag_J", 1.0),
            ("gravity_lag_J", 1.0),
            ("contact_lag_J", 1.0),
            ("step_change_J", 1.0),
        ],
    ),
    (
        "laws, breakage",
        &[
            ("volume_J", 1.0),
            ("nonconservative_J", 1.0),
            ("ended_contacts_J", 1.0),
            ("born_contacts_J", -1.0),
            ("lost_mass_J", 1.0),
        ],
    ),
];

/// The figure of the account; `None` for several runs, or a run that keeps none.
pub fn plot(input: &Input) -> Result<Option<Plot>> {
    let [group] = &input.groups[..] else { return Ok(None) };
    let [run] = &group.runs[..] else { return Ok(None) };
    let Some(table) = Table::read_if_there(&run.dir.join("account.csv"))? else { return Ok(None) };
    let strained = table.has("axial_strain");
    let (column, factor) = if strained { ("axial_strain", 100.0) } else { ("time_s", 1.0) };
    let at: Vec<f64> = table.numbers(column)?.into_iter().map(|x| factor * x).collect();
    let x =
        if strained { Axis::linear("axial strain ε_{a} (%)", "axial_strain_percent") } else { Axis::linear("time (s)", "time_s") };
    let mut lines = Vec::new();
    for (name, columns) in SUMS {
        let mut sum = vec![0.0; at.len()];
        for (column, sign) in columns {
            sum.iter_mut().zip(table.numbers(column)?).for_each(|(sum, value)| *sum += sign * value);
        }
        lines.push((name, sum));
    }
    let largest = lines.iter().flat_map(|line| &line.1).map(|x| x.abs()).fold(0.0, f64::max);
    if largest <= 0.0 {
        return Ok(None);
    }
    let (unit, factor) = unit(largest);
    let line = |(i, (name, sum)): (usize, (&str, Vec<f64>))| {
        // black for what was given, colours for the other lines
        let tone = colour::kind(if i == 0 { 6 } else { (i - 1) % 6 });
        Series::line(name, tone, colour::dash(i), at.iter().copied().zip(sum.into_iter().map(|x| factor * x)).collect())
    };
    let series = lines.into_iter().enumerate().map(line).collect();
    let y = Axis::linear(&format!("energy ({unit})"), &format!("energy_{unit}")).including(&[0.0]);
    let title = vec![run.label()];
    Ok(Some(Plot { name: "account".into(), title, legend_title: None, x: x.including(&[0.0]), y, series, equal: false }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_has_one_line() {
        let sheet = laboratory::record::dictionary::SHEETS.iter().find(|sheet| sheet.files == "account.csv").expect("the account");
        let terms = sheet.columns.iter().map(|c| c.name).filter(|name| name.ends_with("_J") && *name != "account_scale_J");
        for name in terms {
            let lines = SUMS.iter().flat_map(|(_, columns)| *columns).filter(|(column, _)| *column == name).count();
            assert_eq!(lines, 1, "{name}");
        }
    }
}
