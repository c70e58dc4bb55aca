//! `comminute bench`: the engine's speed on this machine.

use comminute::error::Result;

/// Measure the engine's speed on this machine
#[derive(Debug, clap::Args)]
pub struct Args {}

pub fn call(_: &Args) -> Result<()> {
    Ok(())
}
