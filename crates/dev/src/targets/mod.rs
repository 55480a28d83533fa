//! The table of everything that reads bytes from outside.

#[cfg(feature = "ports")]
mod builtins;
#[cfg(feature = "ports")]
mod cell_worlds;
#[cfg(feature = "ports")]
mod editors;
#[cfg(feature = "ports")]
mod files;
mod language;
#[cfg(feature = "ports")]
mod ports;

use fastrand::Rng;

use crate::mutation::mutate;

/// One decoder, or the evaluator, with what it is tried with.
pub struct Target {
    /// What it is called on the command line.
    pub name: &'static str,
    /// What it reads.
    pub about: &'static str,
    /// Panics when a promise is broken; anything else is an answer.
    pub check: fn(&[u8]),
    /// The input of a case that is not made by changing seeds: from the bytes of a generator.
    pub render_input: fn(&[u8]) -> Vec<u8>,
    /// Inputs that are right.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Words that mean something to it.
    pub words: &'static [&'static [u8]],
    /// Longest input.
    pub bytes_max: usize,
}

/// All of them; those of the language first.
pub fn targets() -> Vec<&'static Target> {
    let all = language::TARGETS.iter();
    #[cfg(feature = "ports")]
    let all = all
        .chain(builtins::TARGETS)
        .chain(ports::TARGETS)
        .chain(files::TARGETS)
        .chain(editors::TARGETS);
    all.collect()
}

/// The target of this name.
pub fn target(name: &str) -> Option<&'static Target> {
    targets().into_iter().find(|target| target.name == name)
}

impl Target {
    /// The input of one case: a function of the campaign's seed and the number of the case.
    pub fn input(&self, seeds: &[Vec<u8>], seed: u64, number: u64) -> Vec<u8> {
        // Neighbouring numbers must not give neighbouring inputs.
        let mixed = (seed ^ number.rotate_left(32)).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ number;
        let mut rng = Rng::with_seed(mixed);
        let bytes = mutate(&mut rng, seeds, self.words, self.bytes_max);
        (self.render_input)(&bytes)
    }
}

/// The bytes unchanged, for targets whose input they are.
fn as_they_are(bytes: &[u8]) -> Vec<u8> {
    bytes.to_vec()
}

/// The files of folders below the repository, by the ends of their names.
fn files_of(folders: &[&str], ending: &str) -> Vec<Vec<u8>> {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let mut open: Vec<std::path::PathBuf> = folders
        .iter()
        .map(|folder| format!("{root}/{folder}").into())
        .collect();
    let mut found = Vec::new();
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(
                std::fs::read_dir(path)
                    .into_iter()
                    .flatten()
                    .flatten()
                    .map(|entry| entry.path()),
            );
        } else if path.to_string_lossy().ends_with(ending) {
            found.push(path);
        }
    }
    found.sort();
    found.into_iter().flat_map(std::fs::read).collect()
}
