//! `comminute completions SHELL`

use super::{Cli, print};
use clap::CommandFactory;
use clap_complete::{Shell, generate};
use comminute::error::Result;

/// Print what makes a shell complete the words of this program
///
/// Once the text is in the right file, the shell completes verbs, options, their words and file names at the tab key.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
        comminute completions bash > ~/.local/share/bash-completion/completions/comminute\n  \
        comminute completions zsh > ~/.zfunc/_comminute    (with fpath+=~/.zfunc before compinit in ~/.zshrc)\n  \
        comminute completions fish > ~/.config/fish/completions/comminute.fish")]
pub struct Args {
    /// The shell
    shell: Shell,
}

pub fn call(args: &Args) -> Result<()> {
    let mut text = Vec::new();
    generate(args.shell, &mut Cli::command(), "comminute", &mut text);
    print(String::from_utf8_lossy(&text).trim_end())
}
