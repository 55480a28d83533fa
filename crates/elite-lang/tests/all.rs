//! Tests of the language as programs and embedders see it, in one binary: a file each.

mod support;

mod block_ends;
mod compile_time;
mod diagnostics;
mod embedding;
mod endless;
mod growth;
mod language_doc;
mod limits;
mod long_integers;
mod nesting;
mod nodes;
mod pace;
mod robustness;
mod scripts;
mod stacks;
mod statements;
mod stops;
mod stretch;
mod warnings;
