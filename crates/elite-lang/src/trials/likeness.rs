//! The library is our own: no module of it is CPython's with other words. Each script of `stdlib/lib` is compared with
//! the module of the same name of the machine's CPython.
//!
//! Lines count without comments and spacing. Signatures, decorators, imports, bare keywords and one-word returns say
//! what the interface is and do not count. A module is too alike when more than a quarter of its counted lines stand in
//! CPython's, or a run of five does.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Most of a module's lines, in percent, that may stand in CPython's, too.
const SHARE_MAX: usize = 25;
/// Lines one behind the other that may not.
const RUN: usize = 5;
/// Lines of the interface begin so.
const INTERFACE: &[&str] = &[
    "def ", "class ", "@", "import ", "from ", "else:", "try:", "finally:", "\"\"\"",
];
/// Lines that are no more than this.
const BARE: &[&str] = &["pass", "return", "return self", "raise"];
/// Shorter lines say nothing.
const SHORT: usize = 8;

/// A line as it counts; None if it does not.
fn counted(line: &str) -> Option<String> {
    let code = match line.trim_start().starts_with('#') {
        true => "",
        false => line.split(" #").next().unwrap_or_default(),
    };
    let words: Vec<&str> = code.split_whitespace().collect();
    let line = words.join(" ");
    let is_kept = line
        .strip_prefix("self.")
        .and_then(|rest| rest.split_once(" = "))
        .is_some_and(|(name, value)| name == value);
    let is_name = |text: &str| text.chars().all(|c| c == '_' || c.is_alphanumeric());
    let returns_a_name = line.strip_prefix("return ").is_some_and(is_name);
    let is_interface = INTERFACE.iter().any(|begin| line.starts_with(begin))
        || BARE.contains(&&*line)
        || is_kept
        || returns_a_name;
    (line.chars().count() > SHORT && !is_interface).then_some(line)
}

fn counted_lines(path: &Path) -> Vec<String> {
    let bytes = std::fs::read(path).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    text.lines().filter_map(counted).collect()
}

fn scripts(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut found: Vec<PathBuf> = entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "py"))
        .collect();
    found.sort();
    found
}

/// How much of `ours` stands in `theirs` in percent, and the longest run that does.
fn likeness<'l>(ours: &'l [String], theirs: &[String]) -> (usize, &'l [String]) {
    let known: HashSet<&String> = theirs.iter().collect();
    let shared = ours.iter().filter(|line| known.contains(line)).count();
    let mut longest: &[String] = &[];
    // Lengths of the runs that end at each line of theirs and at the line of ours before.
    let mut before = vec![0usize; theirs.len() + 1];
    for (end, line) in ours.iter().enumerate() {
        let mut now = vec![0usize; theirs.len() + 1];
        for (place, other) in theirs.iter().enumerate() {
            if line == other {
                now[place + 1] = before[place] + 1;
                if now[place + 1] > longest.len() {
                    longest = &ours[end + 1 - now[place + 1]..=end];
                }
            }
        }
        before = now;
    }
    (shared * 100 / ours.len().max(1), longest)
}

/// Where CPython has its modules; None where there is none.
fn cpython_library() -> Option<PathBuf> {
    let ask = "import sysconfig; print(sysconfig.get_paths()['stdlib'])";
    let output = Command::new("python3").args(["-c", ask]).output().ok()?;
    let path = PathBuf::from(String::from_utf8(output.stdout).ok()?.trim());
    path.join("heapq.py").is_file().then_some(path)
}

/// CPython's lines for our module `name` (`os_path`, `collections_abc`).
fn theirs(library: &Path, name: &str) -> Vec<String> {
    let also = match name {
        "os_path" => "posixpath.py",
        "collections_abc" => "_collections_abc.py",
        _ => "",
    };
    let mut files = vec![library.join(format!("{name}.py")), library.join(also)];
    files.extend(scripts(&library.join(name)));
    let files = files.iter().filter(|path| path.is_file());
    files.flat_map(|path| counted_lines(path)).collect()
}

#[test]
fn no_module_is_like_cpythons() {
    let Some(library) = cpython_library() else {
        println!("not compared: there is no CPython library on this machine");
        return;
    };
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/stdlib/lib");
    let mut compared = 0;
    let mut alike = Vec::new();
    for path in scripts(&own) {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let (ours, theirs) = (counted_lines(&path), theirs(&library, &name));
        if ours.is_empty() || theirs.is_empty() {
            continue;
        }
        compared += 1;
        let (share, longest) = likeness(&ours, &theirs);
        if share > SHARE_MAX || longest.len() >= RUN {
            alike.push(format!(
                "{name}: {share} % of {} lines, {longest:#?}",
                ours.len()
            ));
        }
    }
    assert!(
        compared > 15,
        "only {compared} modules of {} found",
        library.display()
    );
    assert!(alike.is_empty(), "{}", alike.join("\n"));
}

#[test]
fn a_copied_module_is_found() {
    let lines = |text: &str| -> Vec<String> { text.lines().filter_map(counted).collect() };
    let copied = "total = first + second\nwhile total > 10:\n    total //= 2  # half\nprint(total, first)\n\
                  values.append(total)\n";
    let reworded = copied.replace("total", "sum_of_both");
    let found = |ours: &str, theirs: &str| {
        let ours = lines(ours);
        let (share, longest) = likeness(&ours, &lines(theirs));
        (share, longest.len())
    };
    assert_eq!(found(copied, &format!("x = [1, 2]\n{copied}")), (100, 5));
    assert_eq!(found(&reworded, copied), (0, 0));
    // What the interface says does not count.
    let interface = "def total(self, first):\n    self.first = first\n    return first\nimport itertools\n@property\n";
    assert_eq!(lines(interface), Vec::<String>::new());
}
