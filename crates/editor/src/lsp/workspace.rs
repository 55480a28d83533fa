//! Names in all programs: those that are open, and the files in the folders of the client.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use elite_syntax::Span;
use ls_types::{Location, Uri, WorkspaceSymbolParams};
use serde_json::{Value, json};

use super::navigation::symbol_kind;
use super::positions::{Encoding, LineIndex};
use super::server::{LanguageServer, RequestError};
use crate::analysis::outline::{OutlineEntry, outline};
use crate::analysis::{Analysis, TextKind};

/// Files that are looked into, and bytes of all of them.
const FILES_MAX: usize = 500;
const BYTES_MAX: u64 = 16 << 20;
/// Folders that are looked into, and how deep.
const FOLDERS_MAX: usize = 2000;
const DEPTH_MAX: u32 = 8;
/// Names that are told.
const FOUND_MAX: usize = 1000;

pub(super) fn symbols(
    server: &mut LanguageServer,
    params: WorkspaceSymbolParams,
) -> Result<Value, RequestError> {
    let encoding = server.documents.encoding;
    let query = params.query.to_lowercase();
    let mut found = Vec::new();
    let mut open = BTreeSet::new();
    for document in server.documents.all() {
        open.extend(document.uri.to_file_path().map(|path| path.into_owned()));
        let analysis = document.analysis();
        let place = |span: Span| Location {
            uri: document.uri.clone(),
            range: document.range(span, encoding),
        };
        matching(&outline(&analysis), "", &query, &place, &mut found);
    }
    for path in files(&server.folders) {
        if found.len() >= FOUND_MAX {
            break;
        }
        if !open.contains(&path) {
            in_file(&path, &query, encoding, &mut found);
        }
    }
    found.truncate(FOUND_MAX);
    Ok(Value::Array(found))
}

fn in_file(path: &Path, query: &str, encoding: Encoding, found: &mut Vec<Value>) {
    let (Ok(text), Some(uri)) = (
        kinematics::text_file::read_text_file(path),
        Uri::from_file_path(path),
    ) else {
        // What cannot be read has no names; nobody asked for this very file.
        return;
    };
    let lines = LineIndex::of(&text);
    let analysis = Analysis::of(uri.as_str(), &text, TextKind::of_path(path));
    let place = |span: Span| Location {
        uri: uri.clone(),
        range: lines.range(&text, span, encoding),
    };
    matching(&outline(&analysis), "", query, &place, found);
}

fn matching(
    entries: &[OutlineEntry],
    container: &str,
    query: &str,
    place: &dyn Fn(Span) -> Location,
    found: &mut Vec<Value>,
) {
    for entry in entries {
        if found.len() >= FOUND_MAX {
            return;
        }
        if entry.name.to_lowercase().contains(query) {
            found.push(json!({
                "name": entry.name,
                "kind": symbol_kind(entry.kind),
                "containerName": container,
                "location": place(entry.name_span),
            }));
        }
        matching(&entry.children, &entry.name, query, place, found);
    }
}

/// The programs in some folders, in an order that does not change.
fn files(folders: &[PathBuf]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut bytes = 0;
    let mut open: Vec<(PathBuf, u32)> = folders.iter().map(|folder| (folder.clone(), 0)).collect();
    let mut looked_at = 0;
    while let Some((folder, depth)) = open.pop() {
        looked_at += 1;
        let Ok(entries) = std::fs::read_dir(&folder) else {
            continue;
        };
        if looked_at > FOLDERS_MAX {
            break;
        }
        let mut paths: Vec<PathBuf> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .collect();
        paths.sort();
        for path in paths {
            let Ok(about) = std::fs::symlink_metadata(&path) else {
                continue;
            };
            let name = path
                .file_name()
                .and_then(|name| name.to_str())
                .unwrap_or(".");
            if about.is_dir() {
                let skipped = name.starts_with('.') || matches!(name, "node_modules" | "target");
                if depth < DEPTH_MAX && !skipped {
                    open.push((path, depth + 1));
                }
            } else if about.is_file() && name.ends_with(".script") {
                bytes += about.len();
                if found.len() >= FILES_MAX || bytes > BYTES_MAX {
                    return found;
                }
                found.push(path);
            }
        }
    }
    found
}
