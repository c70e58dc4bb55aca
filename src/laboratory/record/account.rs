//! Records of the energy account of a continuum or mixture: `account.csv` has a row at every row of the history.

use crate::rig::continuum::{EnergyAccount, TERMS};
use table::Row;

/// Table of the energy account.
pub const ACCOUNT: &str = "account.csv";

/// A row of [`ACCOUNT`] at step `step`, time `time`, s, and axial strain `strain` (none in a free scene).
pub fn row(account: &EnergyAccount, step: u64, time: f64, strain: Option<f64>) -> Row {
    let mut row: Row = vec![("step", step.into()), ("time_s", time.into())];
    if let Some(strain) = strain {
        row.push(("axial_strain", strain.into()));
    }
    row.extend(TERMS.iter().zip(account.terms).map(|((name, _), term)| (*name, term.into())));
    row.push(("account_scale_J", account.scale.into()));
    row.push(("account_error", account.error().into()));
    row
}
