//! Many runs by one command, as a user types it: ensembles, plans, studies, verification, calibrations. One program, so that no long test leaves a core idle.

mod calibrate_curve;
mod calibration;
#[path = "../common/called.rs"]
mod called;
mod campaign;
#[path = "../common/left.rs"]
mod left;
#[path = "../common/processes.rs"]
mod processes;
mod reproduce;
#[path = "../common/scenes_small.rs"]
mod scenes_small;
mod study;
mod verify;

/// The folder of the repository.
const ROOT: &str = env!("CARGO_MANIFEST_DIR");
