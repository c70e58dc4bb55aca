//! The program `comminute`: calls the command line of the library, and sets the exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(comminute::command(std::env::args_os()))
}
