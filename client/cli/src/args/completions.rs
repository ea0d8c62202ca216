//! `bendtwin completions`: completion of commands and options by a shell.

use clap::{Args, CommandFactory as _};
use clap_complete::Shell;

use super::Arguments;
use crate::output;

#[derive(Debug, Args)]
#[command(
    after_help = "For bash: bendtwin completions bash > ~/.local/share/bash-completion/completions/bendtwin
For zsh, in a folder of $fpath: bendtwin completions zsh > _bendtwin
For fish: bendtwin completions fish > ~/.config/fish/completions/bendtwin.fish"
)]
pub(crate) struct Completions {
    /// The shell
    shell: Shell,
}

pub(crate) fn run(args: &Completions) -> anyhow::Result<()> {
    output::line(&script(args.shell))
}

fn script(shell: Shell) -> String {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "bendtwin", &mut script);
    String::from_utf8_lossy(&script).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shell_knows_the_commands() {
        for shell in [Shell::Bash, Shell::Zsh, Shell::Fish, Shell::PowerShell, Shell::Elvish] {
            let script = script(shell);
            assert!(script.contains("rollout"));
            assert!(script.contains("json"), "{shell}");
        }
    }
}
