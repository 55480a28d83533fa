//! Every page whose programs and commands are run, a test each.

use crate::markdown::{name, pages, read, root};
use crate::walk::Walk;

fn walk(page: &str) {
    let mut walk = Walk::new(page);
    for block in read(&root().join(page)).blocks {
        walk.step(&block);
    }
}

macro_rules! walks {
    ($($test:ident: $page:literal),+ $(,)?) => {
        $(#[test] fn $test() { walk($page); })+

        const PAGES: &[&str] = &[$($page),+];
    };
}

walks! {
    contributing: "CONTRIBUTING.md",
    readme: "README.md",
    readme_zh: "README.zh.md",
    api: "docs/api.md",
    cell: "docs/cell.md",
    clients: "docs/clients.md",
    ci: "docs/ci.md",
    debugging: "docs/debugging.md",
    editors: "docs/editors.md",
    dashboard: "docs/protocol/dashboard.md",
    fleet: "docs/fleet.md",
    from_ur: "docs/from-ur.md",
    force: "docs/force.md",
    http: "docs/protocol/http.md",
    import: "docs/import.md",
    index: "docs/index.md",
    interpreter: "docs/protocol/interpreter.md",
    io: "docs/IO.md",
    mcp: "docs/mcp.md",
    packages: "docs/packages.md",
    paths: "docs/paths.md",
    platforms: "docs/platforms.md",
    plc: "docs/plc.md",
    primary: "docs/protocol/primary.md",
    query: "docs/protocol/query.md",
    real_robot: "docs/real-robot.md",
    recording: "docs/recording.md",
    reliability: "docs/RELIABILITY.md",
    ros2: "docs/ros2.md",
    testing: "docs/testing.md",
    troubleshooting: "docs/troubleshooting.md",
    tutorial: "docs/tutorial.md",
    tutorial_zh: "docs/zh/tutorial.md",
    robots: "robots/README.md",
}

/// Pages whose programs others run: docs/python.md and docs/simulation.md are for Python
/// (crates/pybind/tests/test_docs.py).
const ELSEWHERE: &[&str] = &["docs/python.md", "docs/simulation.md"];

#[test]
fn every_page_with_programs_is_walked() {
    for path in pages() {
        let page = name(&path);
        // Examples of the reference are tests of their own (tests/reference.rs).
        if page.contains("reference/") {
            continue;
        }
        let has_programs = read(&path)
            .blocks
            .iter()
            .any(|block| !["", "text"].contains(&&*block.language));
        assert!(
            !has_programs || PAGES.contains(&&*page) || ELSEWHERE.contains(&&*page),
            "{page} has programs that nobody runs: name it in crates/dev/tests/docs/programs.rs"
        );
    }
}
