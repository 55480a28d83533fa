//! How well names and comments of the code can be read by strangers, as figures: `cargo dev names`.
//!
//! Five questions to each crate and to all of them: how many types are named by participles and function words, which
//! names stand for more than two types, which comments need another line to be understood, which functions and which
//! lines are long.

mod scan;
mod words;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

pub use scan::{Function, Inventory, Mention, scan_crate};

/// Longest line, columns.
pub const LINE_MAX: usize = 120;
/// Longest function, lines.
pub const FUNCTION_LINES_MAX: usize = 100;
/// Most types that may share a name.
pub const NAME_SHARERS_MAX: usize = 2;

/// What keeps the figures from being made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NamesError {
    /// A file or folder that cannot be read.
    #[error("{}: {source}", path.display())]
    File {
        /// Path of the file or folder.
        path: PathBuf,
        /// What the system answered.
        source: std::io::Error,
    },
    /// Source text that is not Rust.
    #[error("{}: {message}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// What the parser answered.
        message: String,
    },
    /// A crate that the workspace does not have.
    #[error("there is no crate {name:?}; there are {}", known.join(", "))]
    Crate {
        /// The name that was given.
        name: String,
        /// The crates of the workspace.
        known: Vec<String>,
    },
}

/// The inventories of the crates in `root/crates`, by name; `only` selects some of them, an empty list all.
///
/// # Errors
/// A name in `only` that is no crate, and whatever keeps a crate from being read.
pub fn scan_workspace(
    root: &Path,
    only: &[String],
) -> Result<BTreeMap<String, Inventory>, NamesError> {
    let folder = root.join("crates");
    let unreadable = |source| NamesError::File {
        path: folder.clone(),
        source,
    };
    let mut names = Vec::new();
    for entry in std::fs::read_dir(&folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        if entry.path().join("Cargo.toml").is_file() {
            names.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
    names.sort();
    if let Some(unknown) = only.iter().find(|name| !names.contains(name)) {
        return Err(NamesError::Crate {
            name: unknown.clone(),
            known: names,
        });
    }
    names.retain(|name| only.is_empty() || only.contains(name));
    names
        .into_iter()
        .map(|name| {
            let inventory = scan_crate(&folder.join(&name))?;
            Ok((name, inventory))
        })
        .collect()
}

/// The findings of one inventory.
#[derive(Debug, Default)]
pub struct Findings<'a> {
    /// Types named by a participle or a function word.
    pub weak_types: Vec<&'a Mention>,
    /// Types whose name more than [`NAME_SHARERS_MAX`] types have, by name.
    pub shared_names: BTreeMap<&'a str, Vec<&'a Mention>>,
    /// Comments of documentation that lean on another line.
    pub leaning_docs: Vec<&'a Mention>,
    /// Other comments that lean on another line.
    pub leaning_remarks: Vec<&'a Mention>,
    /// Functions of more than [`FUNCTION_LINES_MAX`] lines.
    pub long_functions: Vec<&'a Function>,
    /// Lines of more than [`LINE_MAX`] columns.
    pub long_lines: Vec<&'a Mention>,
}

impl<'a> Findings<'a> {
    /// Judges an inventory.
    #[must_use]
    pub fn of(inventory: &'a Inventory) -> Self {
        let leaning = |comments: &'a [Mention]| {
            comments
                .iter()
                .filter(|comment| words::leans(&comment.text))
                .collect()
        };
        let mut shared_names: BTreeMap<&str, Vec<&Mention>> = BTreeMap::new();
        for mention in &inventory.types {
            shared_names.entry(&mention.text).or_default().push(mention);
        }
        shared_names.retain(|_, mentions| mentions.len() > NAME_SHARERS_MAX);
        Self {
            weak_types: inventory
                .types
                .iter()
                .filter(|name| words::is_no_noun(&name.text))
                .collect(),
            shared_names,
            leaning_docs: leaning(&inventory.docs),
            leaning_remarks: leaning(&inventory.remarks),
            long_functions: inventory
                .functions
                .iter()
                .filter(|function| function.lines > FUNCTION_LINES_MAX)
                .collect(),
            long_lines: inventory.long_lines.iter().collect(),
        }
    }

    /// Every finding on a line of its own: place, kind, what stands there.
    #[must_use]
    pub fn list(&self, root: &Path) -> String {
        let mut out = String::new();
        let mut add = |mention: &Mention, kind: &str, text: &str| {
            let path = mention.path.strip_prefix(root).unwrap_or(&mention.path);
            let _ = writeln!(out, "{}:{}: {kind}: {text}", path.display(), mention.line);
        };
        for mention in &self.weak_types {
            add(mention, "no noun", &mention.text);
        }
        for (name, mentions) in &self.shared_names {
            for mention in mentions {
                add(
                    mention,
                    "shared name",
                    &format!("{name} ({} types)", mentions.len()),
                );
            }
        }
        for mention in &self.leaning_docs {
            add(mention, "leaning documentation", &mention.text);
        }
        for mention in &self.leaning_remarks {
            add(mention, "leaning comment", &mention.text);
        }
        for function in &self.long_functions {
            let text = format!("{} ({} lines)", function.mention.text, function.lines);
            add(&function.mention, "long function", &text);
        }
        for mention in &self.long_lines {
            add(mention, "long line", &mention.text);
        }
        out
    }
}

/// The figures as a table with a line for each crate and one for all.
///
/// The last line is not the sum of the others where names are shared across crates.
#[must_use]
pub fn table(crates: &BTreeMap<String, Inventory>, all: &Inventory) -> String {
    let mut out = format!(
        "{:14} {:>16} {:>14} {:>16} {:>16} {:>14} {:>16}\n",
        "crate",
        "no noun",
        "shared names",
        "leaning docs",
        "leaning comments",
        "functions>100",
        "lines>120"
    );
    for (name, inventory) in crates {
        out += &table_row(name, inventory);
    }
    out + &table_row("all", all)
}

fn table_row(name: &str, inventory: &Inventory) -> String {
    let findings = Findings::of(inventory);
    format!(
        "{name:14} {:>16} {:>14} {:>16} {:>16} {:>14} {:>16}\n",
        share(findings.weak_types.len(), inventory.types.len()),
        findings.shared_names.len(),
        share(findings.leaning_docs.len(), inventory.docs.len()),
        share(findings.leaning_remarks.len(), inventory.remarks.len()),
        share(findings.long_functions.len(), inventory.functions.len()),
        share(findings.long_lines.len(), inventory.lines),
    )
}

/// A count, and what part of a whole it is.
fn share(count: usize, whole: usize) -> String {
    format!(
        "{count} ({:.2} %)",
        100.0 * count as f64 / whole.max(1) as f64
    )
}
