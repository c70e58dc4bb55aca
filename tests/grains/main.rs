//! Specimens of grains, and single grains, as a user has them tested: whole runs. One program, so that no long test leaves a core idle.

#[path = "../common/mod.rs"]
mod common;
mod crushing;
mod fines;
mod isotropic;
mod ledger;
mod platen;
mod preparation;
mod triaxial;
mod void_ratio;
