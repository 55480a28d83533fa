//! What the program is linked from: every crate comes from the registry, has a licence that may be handed out with
//! ours, and is there once. What is there twice is listed here with who needs it; a new pair is a decision, not an
//! accident.
//!
//! What changes without a change here, yanked versions and advisories, is asked by packaging/audit.py.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "test helpers fail by panicking"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Licences that ask for no more than their text (packaging/inventory.py collects the texts).
const LICENCES: &[&str] = &[
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-1-Clause",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "MIT",
    "MIT-0",
    "Unicode-3.0",
    "Unicode-DFS-2016",
    "Unlicense",
    "Zlib",
];

/// Crates under another licence, and why that is right.
const OTHER_LICENCES: &[(&str, &str)] = &[
    // Weak copyleft by file: the crate is linked as it was published, its sources are where it came from.
    ("serialport", "MPL-2.0"),
];

/// Crates of which more than one version is linked, and who holds the older one.
const TWICE: &[(&str, &str)] = &[
    ("bitflags", "nix of serialport (1), everybody else (2)"),
    ("hashbrown", "spade of parry3d (0.16), others (0.17)"),
    ("miniz_oxide", "png (0.8), flate2 (0.9)"),
    ("nix", "serialport (0.26), ours (0.31)"),
    (
        "thiserror",
        "clarabel and serde-xml-rs (1), everybody else (2)",
    ),
];

/// A crate that ends up in the program.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Linked {
    name: String,
    version: String,
    /// Where it comes from if that is not the registry; empty otherwise.
    place: String,
    licence: String,
}

/// The crates that end up in the program, ours included: no tests, no macros, no build scripts.
fn linked() -> BTreeSet<Linked> {
    let output = Command::new(env!("CARGO"))
        .args([
            "tree",
            "--locked",
            "--package",
            "server",
            "--prefix",
            "none",
        ])
        .args(["--edges", "normal,no-proc-macro", "--format", "{p}|{l}"])
        .args(["--target", "x86_64-unknown-linux-gnu"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    // `name v1.2.3 (place)|licence`, and a star in brackets behind what was listed before.
    let of_line = |line: &str| {
        let (package, licence) = line.split_once('|').unwrap();
        let mut words = package.splitn(3, ' ');
        let mut word = || words.next().unwrap_or_default().to_owned();
        Linked {
            name: word(),
            version: word(),
            place: word(),
            licence: licence.trim_end_matches("(*)").trim().to_owned(),
        }
    };
    text.lines().map(of_line).collect()
}

/// Whether an SPDX expression can be met with the allowed licences: one of each `OR`, all of each `AND`.
fn is_allowed(expression: &str, allowed: &[&str]) -> bool {
    // Older crates write a slash; brackets stand around whole alternatives only, so that AND binds what is outside
    // them.
    let expression = expression.replace('/', " OR ");
    let mut depth = 0;
    let mut parts = vec![String::new()];
    for word in expression
        .replace('(', " ( ")
        .replace(')', " ) ")
        .split_whitespace()
    {
        match word {
            "(" => depth += 1,
            ")" => depth -= 1,
            "AND" if depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        let part = parts.last_mut().unwrap();
        if word != "(" && word != ")" {
            part.push_str(word);
            part.push(' ');
        }
    }
    let any = |part: &String| part.split(" OR ").any(|one| allowed.contains(&one.trim()));
    parts.iter().all(any)
}

#[test]
fn expressions_are_read_as_spdx_means_them() {
    let allowed = &["MIT", "Apache-2.0", "Unicode-3.0"];
    for good in [
        "MIT",
        "MIT/Apache-2.0",
        "GPL-3.0 OR MIT",
        "(MIT OR GPL-3.0) AND Unicode-3.0",
    ] {
        assert!(is_allowed(good, allowed), "{good}");
    }
    for bad in [
        "",
        "GPL-3.0",
        "MIT AND GPL-3.0",
        "(MIT OR Zlib) AND BSD-2-Clause",
    ] {
        assert!(!is_allowed(bad, allowed), "{bad}");
    }
}

#[test]
fn every_crate_has_a_licence_that_may_be_handed_out() {
    let linked = linked();
    assert!(linked.len() > 100, "{}", linked.len());
    for package in &linked {
        let named = (package.name.as_str(), package.licence.as_str());
        assert!(
            OTHER_LICENCES.contains(&named) || is_allowed(named.1, LICENCES),
            "{}: the licence is {:?}",
            named.0,
            named.1
        );
    }
    for (name, licence) in OTHER_LICENCES {
        let found = linked.iter().find(|package| package.name == *name);
        let found = found.map(|package| package.licence.as_str());
        assert_eq!(found, Some(*licence), "{name} is listed for nothing");
    }
}

#[test]
fn every_crate_is_ours_or_comes_from_the_registry() {
    for package in linked() {
        let is_ours = package.place.contains("/crates/");
        assert!(
            package.place.is_empty() || is_ours,
            "{} comes from {}",
            package.name,
            package.place
        );
    }
}

#[test]
fn crates_that_are_there_twice_are_known() {
    let mut versions: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for package in linked() {
        let entry = versions.entry(package.name).or_default();
        entry.insert(package.version);
    }
    versions.retain(|_, versions| versions.len() > 1);
    let found: BTreeSet<&str> = versions.keys().map(String::as_str).collect();
    let known: BTreeSet<&str> = TWICE.iter().map(|(name, _)| *name).collect();
    assert_eq!(found, known, "{versions:?}");
}
