//! The energy ledger of one run against vertical stress; for a triaxial test, whose vertical stress
//! falls again, against axial strain.

use super::Input;
use super::axis::Axis;
use super::colour;
use super::curves::{stress_axis, title};
use super::error::Result;
use super::plot::{Plot, Series};

/// Ledger columns with their legend entries, in the order of the legend: the work of the walls,
/// then the terms that balance this work.
const TERMS: [(&str, &str); 12] = [
    ("energy_wall_J", "work of the walls"),
    ("energy_slip_J", "slip"),
    ("energy_stored_J", "stored"),
    ("energy_damping_J", "damping"),
    ("energy_viscous_J", "viscous"),
    ("energy_kinetic_J", "kinetic"),
    ("energy_lost_kinetic_J", "motion of lost mass"),
    ("energy_contacts_removed_J", "contacts removed"),
    ("energy_contacts_made_J", "contacts made"),
    ("energy_points_J", "work on fines"),
    ("energy_growth_J", "growth of fragments"),
    ("energy_release_J", "hold of broken grains"),
];
/// Column and legend entry of the kinetic energy that came from changes of scaled inertia.
const INERTIA: (&str, &str) = ("energy_inertia_J", "re-scaled inertia");
/// Terms that always stay below this share of the largest term are left out.
const SMALL: f64 = 2e-3;

/// The figure of the ledger; `None` for several runs, or without energies to show.
pub fn plot(input: &Input) -> Result<Option<Plot>> {
    let [group] = &input.groups[..] else {
        return Ok(None);
    };
    let [run] = &group.runs[..] else {
        return Ok(None);
    };
    let (against, x) = if run.is_triaxial() {
        (("axial_strain", 100.0), Axis::linear("axial strain ε_{a} (%)", "axial_strain_percent").including(&[0.0]))
    } else {
        (("sigma_v_kPa", 1e-3), stress_axis())
    };
    let mut terms = Vec::new();
    for (column, name) in TERMS.into_iter().chain([INERTIA]) {
        let branches = run.branches(against, (column, 1.0))?;
        let points: Vec<_> = branches.into_iter().flat_map(|b| b.points).collect();
        let most = points.iter().map(|p| p.1.abs()).fold(0.0, f64::max);
        terms.push((name, points, most));
    }
    let largest = terms.iter().map(|t| t.2).fold(0.0, f64::max);
    if largest <= 0.0 {
        return Ok(None);
    }
    let (unit, factor) = unit(largest);
    let mut series = Vec::new();
    terms.retain(|t| t.2 >= SMALL * largest);
    for (i, (name, mut points, _)) in terms.into_iter().enumerate() {
        points.dedup();
        for p in &mut points {
            p.1 *= factor;
        }
        // Black for the work of the walls, colours for the other terms.
        let tone = colour::kind(if i == 0 { 6 } else { (i - 1) % 6 });
        series.push(Series::line(name, tone, colour::dash(i), points));
    }
    let mut heading = title(input);
    heading.insert(0, group.label.clone());
    Ok(Some(Plot {
        name: "energy".into(),
        title: heading,
        legend_title: None,
        x,
        y: Axis::linear(&format!("energy ({unit})"), &format!("energy_{unit}")).including(&[0.0]),
        series,
        equal: false,
    }))
}

/// Unit of energy in which the largest value, J, is between about 0.1 and 10 000, and the factor
/// from J.
pub fn unit(largest: f64) -> (&'static str, f64) {
    match largest {
        v if v >= 1e4 => ("kJ", 1e-3),
        v if v >= 0.1 => ("J", 1.0),
        v if v >= 1e-4 => ("mJ", 1e3),
        _ => ("µJ", 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_keep_numbers_readable() {
        for v in [3e-6, 2e-3, 5.0, 3e3, 8e5] {
            let (_, factor) = unit(v);
            assert!((0.1..1e4).contains(&(v * factor)), "{v}");
        }
    }
}
