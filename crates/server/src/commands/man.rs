//! `eliteserver man`: the manual pages, made from the command line's own declaration.

use std::io;
use std::path::Path;

use clap::CommandFactory as _;
use messages::text;

use crate::cli::{Cli, ManArgs};
use crate::command::{CommandError, CommandResult, CommandStatus};

/// Exit status: 0 written, 2 not.
pub fn man(args: &ManArgs) -> CommandResult {
    let folder = args.folder.display();
    write_pages(&args.folder).map_err(|error| {
        CommandError::sentence(text!(
            "cannot write the pages into {folder}: {error}",
            "无法将手册页写入 {folder}：{error}"
        ))
    })?;
    Ok(CommandStatus::Success)
}

/// Writes a page of the program and one of every command into a folder, which is made.
///
/// # Errors
/// The folder cannot be made, or a page not be written.
fn write_pages(folder: &Path) -> io::Result<()> {
    std::fs::create_dir_all(folder)?;
    clap_mangen::generate_to(Cli::command(), folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page_with_its_options() {
        let folder = tempfile::tempdir().unwrap();
        write_pages(&folder.path().join("man1")).unwrap();
        let read = |name: &str| {
            let path = folder.path().join("man1").join(name);
            std::fs::read_to_string(path).unwrap()
        };
        let pages = std::fs::read_dir(folder.path().join("man1"))
            .unwrap()
            .count();
        let cli = Cli::command();
        let shown = cli
            .get_subcommands()
            .filter(|command| !command.is_hide_set());
        assert_eq!(pages, shown.count() + 1);
        assert!(read("eliteserver.1").contains(r"eliteserver\-replay(1)"));
        let replay = read("eliteserver-replay.1");
        assert!(replay.contains(r"\-\-find") && replay.contains(r"eliteserver\-replay"));
    }
}
