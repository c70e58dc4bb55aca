//! The program `comminute`: reads the command line, calls one verb, prints its error with advice, sets the exit code.

mod cli;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    comminute::interrupt::outlive_size_limit();
    match cli::Cli::parse().call() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            for line in error.to_string().lines() {
                eprintln!("error: {line}");
            }
            if let Some(advice) = cli::advice(&error) {
                eprintln!("{advice}");
            }
            ExitCode::from(error.exit_code())
        }
    }
}
