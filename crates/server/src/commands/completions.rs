//! `eliteserver completions`: the completion script of a shell, made from the command line's own declaration.

use clap::CommandFactory as _;
use clap_complete::Shell;

use crate::cli::Cli;

/// The name under which the program is called.
const NAME: &str = "eliteserver";

/// The completion script of a shell.
pub fn script(shell: Shell) -> Vec<u8> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), NAME, &mut script);
    script
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shell_gets_a_script_that_knows_the_commands() {
        for shell in [
            Shell::Bash,
            Shell::Zsh,
            Shell::Fish,
            Shell::PowerShell,
            Shell::Elvish,
        ] {
            let script = String::from_utf8(script(shell)).unwrap();
            for word in ["replay", "doctor", "primary-port"] {
                assert!(script.contains(word), "{shell}: {word}");
            }
        }
    }
}
