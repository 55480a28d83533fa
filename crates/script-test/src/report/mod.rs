//! What became of tests, for people (`human`), for programs (`json`), for GitHub's pages (`github`), as JUnit's XML
//! (`junit`) and as executed lines (`lcov`). Makes texts; writes no file.

pub mod github;
pub mod human;
pub mod json;
pub mod junit;
pub mod lcov;

use crate::runner::TestResult;

/// The command that runs a test alone with its seed.
pub fn repeat_command(result: &TestResult) -> String {
    let path = result.case.file.path.display().to_string();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:@%".contains(c);
    let path = match path.chars().all(is_plain) {
        true => path,
        false => format!("'{}'", path.replace('\'', "'\\''")),
    };
    let (name, seed) = (&result.case.name, result.seed);
    let mut command = format!("eliteserver test {path} -k {name} --seed {seed}");
    if let Some(timeout) = result.timeout {
        command.push_str(&format!(" --timeout {}", timeout.get()));
    }
    if let Some(timeout) = result.wall_timeout {
        command.push_str(&format!(" --wall-timeout {}", timeout.as_secs_f64()));
    }
    command
}

/// Control characters of what a program says must not steer the terminal of who reads it.
fn plain(text: &str) -> String {
    let shown = |c: char| match c {
        '\n' | '\t' => c.to_string(),
        c if c.is_control() => c.escape_default().to_string(),
        c => c.to_string(),
    };
    text.chars().map(shown).collect()
}
