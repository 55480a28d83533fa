//! Finds the tests: files by their names, functions by theirs.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use elite_syntax::{KnownNames, SourceFile, compile, picture};
use messages::{Localized, Text};
use thiserror::Error;

use crate::files::FileScope;

/// Longest test file, bytes.
const FILE_BYTES_MAX: u64 = 8 << 20;
/// Most files and folders that are looked at, and how deep folders may be nested.
const ENTRIES_MAX: usize = 100_000;
const DEPTH_MAX: usize = 64;

/// A reason why there is nothing to run.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum DiscoverError {
    /// A path is not there, or cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    #[zh("无法读取 {}：{source}", path.display())]
    Unreadable {
        /// The file or folder as it was given.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A file is larger than any test.
    #[error("{} has {bytes} bytes, at most {FILE_BYTES_MAX} are read", path.display())]
    #[zh("{} 有 {bytes} 字节，最多读取 {FILE_BYTES_MAX} 字节", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Length of the file, bytes.
        bytes: u64,
    },
    /// A folder holds more than a project does.
    #[error("{} holds more than {ENTRIES_MAX} files; name the folders with the tests", path.display())]
    #[zh("{} 中超过 {ENTRIES_MAX} 个文件；请指明测试所在的文件夹", path.display())]
    TooMany {
        /// The folder.
        path: PathBuf,
    },
    /// A file does not compile.
    #[error("{report}")]
    NotCompiled {
        /// What is wrong, with the places.
        report: Text,
    },
    /// Two tests of one file have the same name.
    #[error("{}:{line}: there are two tests called {name}; only the second would ever run", path.display())]
    #[zh("{}:{line}：有两个名为 {name} 的测试；只有第二个会运行", path.display())]
    DuplicateName {
        /// The file.
        path: PathBuf,
        /// Line of the second.
        line: u32,
        /// Name that both tests have.
        name: String,
    },
    /// A test wants arguments.
    #[error("{}:{line}: {name} takes arguments; a test is called without any", path.display())]
    #[zh("{}:{line}：{name} 有参数；测试调用时没有参数", path.display())]
    Arguments {
        /// The file.
        path: PathBuf,
        /// Line of the test.
        line: u32,
        /// Name of the test.
        name: String,
    },
}

/// A file with tests.
#[derive(Debug)]
pub struct TestFile {
    /// Path under which the file was found, below the path that was asked for.
    pub path: PathBuf,
    /// Text of the file.
    pub text: String,
}

/// One test.
#[derive(Clone, Debug)]
pub struct TestCase {
    /// File of the test.
    pub file: Arc<TestFile>,
    /// Name of the function.
    pub name: String,
    /// Line of the function, from 1.
    pub line: u32,
    /// The argument under which it was found: settings are looked for up to there.
    pub root: PathBuf,
}

/// Whether a file of this name holds tests.
pub fn is_test_file(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    name.and_then(|name| name.strip_suffix(".script"))
        .is_some_and(|stem| stem.starts_with("test_") || stem.ends_with("_test"))
}

/// All tests of some files and folders, in the order of paths and lines. A file that is named is taken whatever its
/// name.
///
/// # Errors
/// [`DiscoverError`]
pub fn discover(paths: &[PathBuf]) -> Result<Vec<TestCase>, DiscoverError> {
    discover_in(paths, &FileScope::default())
}

/// All tests of some files and folders in the order of paths and lines, found in `among` only.
///
/// # Errors
/// [`DiscoverError`]
pub fn discover_in(paths: &[PathBuf], among: &FileScope) -> Result<Vec<TestCase>, DiscoverError> {
    let mut seen = BTreeSet::new();
    let mut cases = Vec::new();
    for root in paths {
        let unreadable = |source| DiscoverError::Unreadable {
            path: root.clone(),
            source,
        };
        let place = among.find(root).map_err(unreadable)?;
        let kind = std::fs::metadata(&place).map_err(unreadable)?;
        let files = match kind.is_dir() {
            true => files_below(root, among, is_test_file)?,
            false => vec![root.clone()],
        };
        let root = match (kind.is_dir(), root.parent()) {
            (false, Some(parent)) => parent.to_owned(),
            _ => root.clone(),
        };
        for path in files {
            let whole = path.canonicalize().unwrap_or_else(|_| path.clone());
            if seen.insert(whole) {
                cases.extend(cases_of(path, &root, among)?);
            }
        }
    }
    Ok(cases)
}

/// All scripts below a folder, in the order of their paths; tests are among them.
///
/// # Errors
/// [`DiscoverError`]
pub fn scripts_below(root: &Path) -> Result<Vec<PathBuf>, DiscoverError> {
    let is_script = |path: &Path| path.extension().is_some_and(|end| end == "script");
    files_below(root, &FileScope::default(), is_script)
}

fn files_below(
    root: &Path,
    among: &FileScope,
    is_wanted: impl Fn(&Path) -> bool,
) -> Result<Vec<PathBuf>, DiscoverError> {
    let mut found = Vec::new();
    let mut open = vec![(root.to_owned(), 0)];
    let mut entries = 0;
    while let Some((folder, depth)) = open.pop() {
        let unreadable = |source| DiscoverError::Unreadable {
            path: folder.clone(),
            source,
        };
        let place = among.find(&folder).map_err(unreadable)?;
        for entry in std::fs::read_dir(&place).map_err(unreadable)? {
            let entry = entry.map_err(unreadable)?;
            entries += 1;
            if entries > ENTRIES_MAX {
                let path = root.to_owned();
                return Err(DiscoverError::TooMany { path });
            }
            let path = folder.join(entry.file_name());
            // Links to folders are not followed: they may lead round and round.
            let kind = entry.file_type().map_err(unreadable)?;
            let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
            if kind.is_dir() && !is_hidden && depth < DEPTH_MAX {
                open.push((path, depth + 1));
            } else if !kind.is_dir() && is_wanted(&path) {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

fn cases_of(path: PathBuf, root: &Path, among: &FileScope) -> Result<Vec<TestCase>, DiscoverError> {
    let text = match among.text(&path, FILE_BYTES_MAX) {
        Ok(text) => text,
        Err(Ok(bytes)) => return Err(DiscoverError::TooLong { path, bytes }),
        Err(Err(source)) => return Err(DiscoverError::Unreadable { path, source }),
    };
    let name = path.display().to_string();
    let source = SourceFile::new(name, text.clone());
    let builtins = elite_runtime::builtins::names().map(str::to_owned);
    let known = KnownNames::new(builtins.chain([crate::OBJECT.to_owned()]));
    let program = compile(source.clone(), &known).map_err(|findings| {
        let pictures = findings.iter().map(|f| picture(f, &source));
        let report = Text::joined(pictures, "\n", "\n");
        DiscoverError::NotCompiled { report }
    })?;
    let functions: BTreeSet<&str> = program.global_names().collect();
    let mut cases: Vec<TestCase> = Vec::new();
    let file = Arc::new(TestFile { path, text });
    for (index, line) in file.text.lines().enumerate() {
        let Some((name, rest)) = line.strip_prefix("def ").and_then(|l| l.split_once('(')) else {
            continue;
        };
        let (name, line) = (name.trim(), index as u32 + 1);
        if !name.starts_with("test_") || !functions.contains(name) {
            continue;
        }
        let (path, name) = (file.path.clone(), name.to_owned());
        if !rest.trim_start().starts_with(')') {
            return Err(DiscoverError::Arguments { path, line, name });
        }
        if cases.iter().any(|case| case.name == name) {
            return Err(DiscoverError::DuplicateName { path, line, name });
        }
        cases.push(TestCase {
            file: file.clone(),
            name,
            line,
            root: root.to_owned(),
        });
    }
    Ok(cases)
}
