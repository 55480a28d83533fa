//! Bundles the page from `web/` where Node (18 or newer) is there; otherwise builds a page that says so.
//!
//! The libraries of the page come from the npm registry by `npm ci`, in the versions of the lock file. Nothing of them
//! is committed, and a build without network or Node still works.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// The oldest Node that bundles the page.
const NODE_MIN: u32 = 18;

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    let here = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let web = here.join("../../web");
    for part in [
        "src",
        "package.json",
        "package-lock.json",
        "bundle.mjs",
        "tsconfig.json",
    ] {
        println!("cargo:rerun-if-changed={}", web.join(part).display());
    }
    println!("cargo:rerun-if-env-changed=ELITESERVER_PAGE");
    let listed = match bundle(&web, &out) {
        Ok(()) => files(&out),
        Err(reason) => {
            println!("cargo:warning=the pendant page is not in this build: {reason}");
            placeholder(&out, &reason)
        }
    };
    fs::write(out.join("assets.rs"), listed).unwrap_or_else(|error| panic!("assets.rs: {error}"));
}

/// Puts `index.html`, `app.js.gz`, `view.js.gz` and `app.css.gz` into the folder.
fn bundle(web: &Path, out: &Path) -> Result<(), String> {
    if env::var("ELITESERVER_PAGE").is_ok_and(|value| value == "off") {
        return Err("ELITESERVER_PAGE=off".to_owned());
    }
    let version = Command::new("node")
        .arg("--version")
        .output()
        .map_err(|_| format!("there is no Node; version {NODE_MIN} or newer bundles the page"))?;
    let version = String::from_utf8_lossy(&version.stdout).trim().to_owned();
    let major = version.trim_start_matches('v').split('.').next();
    if major.and_then(|major| major.parse::<u32>().ok()) < Some(NODE_MIN) {
        return Err(format!(
            "Node is {version}, {NODE_MIN} or newer bundles the page"
        ));
    }
    if !web.join("node_modules/.package-lock.json").exists() {
        let arguments = ["ci", "--no-audit", "--no-fund", "--ignore-scripts"];
        run(Command::new("npm").args(arguments).current_dir(web))?;
    }
    run(Command::new("node")
        .arg("bundle.mjs")
        .arg(out)
        .current_dir(web))
}

fn run(command: &mut Command) -> Result<(), String> {
    let output = command
        .output()
        .map_err(|error| format!("{command:?}: {error}"))?;
    if output.status.success() {
        return Ok(());
    }
    let text = String::from_utf8_lossy(&output.stderr);
    let last: Vec<&str> = text.lines().rev().take(3).collect();
    let last: Vec<&str> = last.into_iter().rev().collect();
    Err(format!("{command:?} failed: {}", last.join("; ")))
}

/// What tells one content of a file from another.
fn mark(bytes: &[u8]) -> String {
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    format!("\"{:016x}\"", hasher.finish())
}

/// The list of what was bundled.
fn files(out: &Path) -> String {
    let row = |path: &str, file: &str, kind: &str, gzipped: bool| {
        let file = out.join(file);
        let name = file.display().to_string();
        let bytes = fs::read(&file).unwrap_or_else(|error| panic!("{name}: {error}"));
        let mark = mark(&bytes);
        format!(
            "    Asset {{ path: {path:?}, media_type: {kind:?}, bytes: include_bytes!({name:?}), is_gzipped: \
             {gzipped}, mark: {mark:?} }},\n"
        )
    };
    let mut text = String::from(
        "/// Whether the page is in this build.\npub const IS_BUNDLED: bool = true;\n/// Every file.\n\
         pub const ASSETS: &[Asset] = &[\n",
    );
    text += &row("/", "index.html", "text/html; charset=utf-8", false);
    text += &row(
        "/app.js",
        "app.js.gz",
        "text/javascript; charset=utf-8",
        true,
    );
    text += &row(
        "/view.js",
        "view.js.gz",
        "text/javascript; charset=utf-8",
        true,
    );
    text += &row("/app.css", "app.css.gz", "text/css; charset=utf-8", true);
    text += &row("/icon.svg", "icon.svg.gz", "image/svg+xml", true);
    text + "];\n"
}

/// The list with a page that says why it is empty.
fn placeholder(out: &Path, reason: &str) -> String {
    let escaped = reason.replace('&', "&amp;").replace('<', "&lt;");
    let page = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>eliteserver</title><h1>eliteserver</h1>\
         <p>This build has no pendant page: {escaped}.</p>\
         <p>Build it again with Node {NODE_MIN} or newer. The interface under /api/v1 is there.</p></html>\n"
    );
    let file = out.join("index.html");
    fs::write(&file, &page).unwrap_or_else(|error| panic!("index.html: {error}"));
    format!(
        "/// Whether the page is in this build.\npub const IS_BUNDLED: bool = false;\n/// Every file.\n\
         pub const ASSETS: &[Asset] = &[Asset {{ path: \"/\", media_type: \"text/html; charset=utf-8\", bytes: \
         include_bytes!({:?}), is_gzipped: false, mark: {:?} }}];\n",
        file.display().to_string(),
        mark(page.as_bytes())
    )
}
