//! Data flows one way through the crates: this test holds `cargo metadata` against the table of ARCHITECTURE.md.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "test helpers fail by panicking"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Holds the texts for people, so every crate may import it.
const MESSAGES: &str = "messages";

/// Which of our crates each crate may import.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("messages-macros", &[]),
    (MESSAGES, &["messages-macros"]),
    ("platform", &[]),
    ("kinematics", &[]),
    ("supervision", &[]),
    ("wire", &[]),
    ("mesh", &["kinematics"]),
    ("program-import", &["kinematics"]),
    (
        "robot-client",
        &["io-bus", "kinematics", "motion-api", "recorder", "wire"],
    ),
    ("task-memory", &["platform"]),
    ("elite-syntax", &["task-memory"]),
    ("elite-lang", &["elite-syntax", "platform", "task-memory"]),
    ("motion-api", &["kinematics"]),
    ("force", &["kinematics", "motion-api"]),
    (
        "motion",
        &[
            "kinematics",
            "motion-api",
            "force",
            "platform",
            "supervision",
        ],
    ),
    ("world", &["kinematics", "mesh", "motion-api"]),
    ("path-planning", &["kinematics"]),
    ("io-bus", &["motion-api", "platform", "supervision"]),
    (
        "recorder",
        &["kinematics", "mesh", "motion-api", "supervision"],
    ),
    ("ros2", &["kinematics", "motion-api"]),
    (
        "elite-runtime",
        &[
            "elite-lang",
            "elite-syntax",
            "kinematics",
            "motion-api",
            "io-bus",
            "platform",
            "supervision",
            "task-memory",
        ],
    ),
    (
        "controller",
        &[
            "elite-lang",
            "elite-runtime",
            "elite-syntax",
            "force",
            "io-bus",
            "kinematics",
            "mesh",
            "motion",
            "motion-api",
            "path-planning",
            "platform",
            "recorder",
            "supervision",
            "world",
        ],
    ),
    (
        "script-test",
        &[
            "controller",
            "elite-lang",
            "elite-runtime",
            "elite-syntax",
            "io-bus",
            "kinematics",
            "motion-api",
            "platform",
            "recorder",
            "supervision",
        ],
    ),
    (
        "editor",
        &[
            "controller",
            "elite-lang",
            "elite-runtime",
            "elite-syntax",
            "io-bus",
            "kinematics",
            "motion-api",
            "platform",
            "recorder",
            "script-test",
            "supervision",
            "task-memory",
        ],
    ),
    (
        "pendant",
        &[
            "controller",
            "editor",
            "elite-runtime",
            "elite-syntax",
            "io-bus",
            "kinematics",
            "mesh",
            "motion-api",
            "recorder",
            "supervision",
        ],
    ),
    (
        "server",
        &[
            "controller",
            "editor",
            "elite-lang",
            "elite-runtime",
            "elite-syntax",
            "force",
            "io-bus",
            "kinematics",
            "mesh",
            "motion",
            "motion-api",
            "path-planning",
            "pendant",
            "platform",
            "program-import",
            "recorder",
            "robot-client",
            "ros2",
            "script-test",
            "supervision",
            "wire",
        ],
    ),
    (
        "pybind",
        &[
            "controller",
            "elite-runtime",
            "kinematics",
            "motion-api",
            "recorder",
            "server",
        ],
    ),
    // Tries the decoders of all of them; nothing imports it.
    (
        "dev",
        &[
            "controller",
            "editor",
            "elite-lang",
            "elite-runtime",
            "elite-syntax",
            "io-bus",
            "kinematics",
            "mesh",
            "motion-api",
            "program-import",
            "recorder",
            "ros2",
            "server",
            "supervision",
            "task-memory",
            "wire",
        ],
    ),
];

/// Libraries that must stay behind one crate: the crate's name and who alone may name it.
const KEPT_IN: &[(&str, &[&str])] = &[
    ("rapier3d-f64", &["motion", "world"]),
    ("parry3d-f64", &["path-planning"]),
    ("rsruckig", &["motion"]),
    ("clarabel", &["force", "world"]),
    ("corosensei", &["elite-lang", "elite-syntax"]),
    // What depends on the system; `dev` starts and limits processes of its own.
    ("nix", &["platform", "dev"]),
    ("libc", &["platform"]),
    ("signal-hook", &["platform"]),
    ("thread-priority", &["platform"]),
    ("mcap", &["recorder", "server"]),
    // `supervision` starts tasks for those who have it, behind a feature that motion and recorder leave off
    // and `dev` holds whole connections to the ports
    (
        "tokio",
        &[
            "io-bus",
            "controller",
            "elite-runtime",
            "platform",
            "robot-client",
            "script-test",
            "server",
            "supervision",
            "dev",
        ],
    ),
    ("tokio-modbus", &["io-bus"]),
    ("ls-types", &["editor"]),
    ("lsp-server", &["editor"]),
    ("rmcp", &["server"]),
    ("pyo3", &["pybind"]),
    ("ros2-client", &["ros2"]),
    ("cdr-encoding", &["ros2"]),
];

/// Normal (not dev, not build) dependencies of every workspace crate.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--no-deps",
            "--offline",
            "--format-version",
            "1",
        ])
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .output()
        .expect("cargo runs");
    let metadata: serde_json::Value =
        serde_json::from_slice(&output.stdout).expect("cargo prints JSON");
    let packages = metadata["packages"].as_array().expect("a list of packages");
    packages
        .iter()
        .map(|package| {
            let normal = package["dependencies"]
                .as_array()
                .expect("a list")
                .iter()
                .filter(|d| d["kind"].is_null());
            let names = normal
                .map(|d| d["name"].as_str().expect("a name").to_owned())
                .collect();
            (package["name"].as_str().expect("a name").to_owned(), names)
        })
        .collect()
}

#[test]
fn crates_import_only_what_the_architecture_allows() {
    let dependencies = dependencies();
    let ours: BTreeSet<&str> = MAY_IMPORT.iter().map(|(name, _)| *name).collect();
    for (name, imports) in &dependencies {
        let allowed = MAY_IMPORT
            .iter()
            .find(|(n, _)| n == name)
            .map(|(_, allowed)| *allowed);
        let allowed = allowed.unwrap_or_else(|| panic!("crate {name} is not in the table"));
        for import in imports.iter().filter(|i| ours.contains(i.as_str())) {
            assert!(
                import == MESSAGES || allowed.contains(&import.as_str()),
                "{name} must not import {import}"
            );
        }
    }
    assert_eq!(
        dependencies.len(),
        MAY_IMPORT.len(),
        "a crate of the table is missing"
    );
}

#[test]
fn heavy_libraries_stay_behind_the_crate_that_owns_them() {
    for (name, imports) in dependencies() {
        for (library, owners) in KEPT_IN {
            if imports.contains(*library) {
                assert!(
                    owners.contains(&name.as_str()),
                    "{name} must not import {library}"
                );
            }
        }
    }
}
