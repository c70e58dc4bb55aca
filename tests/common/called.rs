//! The program as a user calls it in a folder.
#![allow(dead_code)] // each test binary uses its part

use assert_cmd::cargo::cargo_bin;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// The program with these arguments and without input.
pub fn command(dir: impl AsRef<Path>, args: &[&str]) -> Command {
    let mut command = Command::new(cargo_bin("comminute"));
    command.current_dir(dir).args(args).stdin(Stdio::null());
    command
}

/// What it does with these arguments, where it must end with the exit code `code`.
#[track_caller]
pub fn call(dir: impl AsRef<Path>, args: &[&str], code: i32) -> Output {
    let output = command(dir, args).output().expect("started");
    assert_eq!(output.status.code(), Some(code), "{args:?}\n{}", said(&output));
    output
}

/// What it said.
pub fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The text of a file that it left.
#[track_caller]
pub fn text(dir: impl AsRef<Path>, file: &str) -> String {
    let path = dir.as_ref().join(file);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}
