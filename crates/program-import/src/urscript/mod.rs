//! URScript as text: tokens, syntax tree.
//!
//! Knows the grammar that controllers of Universal Robots accept, the labels (`$ 3 "Waypoint"`) of programs that
//! PolyScope makes included, and nothing of robots.
use messages::{Localized, Text};

pub mod ast;
mod lexer;
mod parser;

pub use lexer::Comment;
pub use parser::{Source, parse};

/// A reason why a text is no URScript: a sentence and the line, counted from 1.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Localized)]
#[error("line {line}: {text}")]
#[zh("第 {line} 行：{text}")]
pub struct SyntaxError {
    /// Line of the text, from 1.
    pub line: u32,
    /// What is wrong.
    pub text: Text,
}

impl SyntaxError {
    const fn new(line: u32, text: Text) -> Self {
        Self { line, text }
    }
}
