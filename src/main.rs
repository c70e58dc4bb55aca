//! The command line: parse, call a verb, print errors, set the exit code.

mod cli;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    match cli::Cli::parse().call() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let told = error.to_string();
            for line in told.lines() {
                eprintln!("error: {line}");
            }
            if told.contains("the processor") {
                eprintln!("the processor does the steps with --backend cpu; comminute resume RUN --backend cpu goes on with a run");
            }
            ExitCode::from(error.exit_code())
        }
    }
}
