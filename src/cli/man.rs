//! `comminute man [VERB]…`

use super::{Cli, print};
use clap::CommandFactory;
use clap_mangen::Man;
use comminute::error::{Error, Result};

/// Print a manual page of this program
///
/// The page is in roff, for man(1): of the whole program, or of one verb.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
        comminute man > ~/.local/share/man/man1/comminute.1\n  \
        comminute man calibrate curve > ~/.local/share/man/man1/comminute-calibrate-curve.1")]
pub struct Args {
    /// Verb that the page describes, as in calibrate curve; the whole program if not given
    verb: Vec<String>,
}

pub fn call(args: &Args) -> Result<()> {
    let mut command = Cli::command();
    command.build();
    for word in &args.verb {
        let Some(found) = command.find_subcommand(word) else {
            let words: Vec<&str> = command.get_subcommands().map(clap::Command::get_name).collect();
            let message = match words.is_empty() {
                true => format!("{} has no verbs of its own", command.get_name()),
                false => format!("must be one of {}", words.join(", ")),
            };
            return Err(Error::input(format!("man {word}"), "", None, message));
        };
        command = found.clone();
    }
    let mut text = Vec::new();
    let source = format!("comminute {}", env!("CARGO_PKG_VERSION"));
    Man::new(command).source(source).render(&mut text).map_err(Error::write("standard output"))?;
    print(String::from_utf8_lossy(&text).trim_end())
}
