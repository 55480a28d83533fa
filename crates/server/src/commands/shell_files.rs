//! `eliteserver completions` and `eliteserver man`: what a package installs beside the binary, made from the command
//! line's own declaration.

use std::io;
use std::path::Path;

use clap::CommandFactory as _;
use clap_complete::Shell;

use crate::cli::Cli;

/// The name under which the program is called.
const NAME: &str = "eliteserver";

/// The completion script of a shell.
pub fn completions(shell: Shell) -> Vec<u8> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), NAME, &mut script);
    script
}

/// Writes a page of the program and one of every command into a folder, which is made.
///
/// # Errors
/// The folder cannot be made, or a page not be written.
pub fn manual(folder: &Path) -> io::Result<()> {
    std::fs::create_dir_all(folder)?;
    clap_mangen::generate_to(Cli::command(), folder)
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
            let script = String::from_utf8(completions(shell)).unwrap();
            for word in ["replay", "doctor", "primary-port"] {
                assert!(script.contains(word), "{shell}: {word}");
            }
        }
    }

    #[test]
    fn every_command_has_a_page_with_its_options() {
        let folder = tempfile::tempdir().unwrap();
        manual(&folder.path().join("man1")).unwrap();
        let read = |name: &str| {
            let path = folder.path().join("man1").join(name);
            std::fs::read_to_string(path).unwrap()
        };
        let pages = std::fs::read_dir(folder.path().join("man1"))
            .unwrap()
            .count();
        assert_eq!(pages, Cli::command().get_subcommands().count() + 1);
        assert!(read("eliteserver.1").contains(r"eliteserver\-replay(1)"));
        let replay = read("eliteserver-replay.1");
        assert!(replay.contains(r"\-\-find") && replay.contains(r"eliteserver\-replay"));
    }
}
