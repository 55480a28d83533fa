//! URScript to EliteScript.
//!
//! [`translate`] reads a text ([`crate::urscript`]), finds out what its names and values are (`scopes`, `analysis`),
//! and writes every statement anew (`statements`, `expressions`, `calls`), with the functions of the table
//! (`functions`) in place of those of Universal Robots. What a program needs beyond that comes with it (`helpers`).

mod analysis;
mod calls;
mod expressions;
pub mod functions;
mod helpers;
mod kinds;
mod messages;
mod names;
mod poses;
mod report;
mod scopes;
mod statements;

use std::collections::{BTreeMap, BTreeSet};

use ::messages::{Language, Text, text};

pub use messages::{Message, MessageKind};

use crate::urscript::{self, Comment, SyntaxError};
use analysis::Analysis;

/// A translated program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Translation {
    /// The program in EliteScript; it needs nothing but itself.
    pub text: String,
    /// What was changed, by line.
    pub messages: Vec<Message>,
}

impl Translation {
    /// Whether something of the original has no counterpart.
    pub fn is_complete(&self) -> bool {
        self.messages
            .iter()
            .all(|message| message.kind != MessageKind::Missing)
    }

    /// The remarks as a page of Markdown.
    pub fn report(&self, name: &str, language: Language) -> String {
        report::page(self, name, language)
    }
}

/// Translates a text of URScript; `name` is what its first line calls the original.
///
/// # Errors
///
/// The text is no URScript.
pub fn translate(text: &str, name: &str) -> Result<Translation, SyntaxError> {
    let source = urscript::parse(text)?;
    let (body, program) = scopes::program_body(&source.body);
    let mut translator = Translator {
        analysis: Analysis::of(body),
        lines: text.lines().collect(),
        comments: source.comments.iter().peekable(),
        out: String::new(),
        level: 0,
        last_line: 1,
        has_break: true,
        messages: Vec::new(),
        said: BTreeSet::new(),
        names: BTreeMap::new(),
        line: 1,
    };
    if let Some(program) = program {
        // Comments above the `def` of the program stand above its first statement.
        let first = program.body.first().map_or(1, |stmt| stmt.line);
        translator.last_line = first;
    }
    translator.write_body(body, 0);
    translator.flush_comments(u32::MAX);
    let name: String = name.chars().filter(|c| !c.is_control()).collect();
    Ok(Translation {
        text: with_helpers(&translator.out, &name),
        messages: {
            let mut messages = translator.messages;
            messages.sort_by_key(|message| message.line);
            messages
        },
    })
}

fn with_helpers(body: &str, name: &str) -> String {
    let mut text = format!("# Translated from {name}\n\n");
    for helper in helpers::definitions(body) {
        text.push_str(helper.text);
        text.push('\n');
    }
    text.push_str(body.trim_start_matches('\n'));
    text
}

/// Writes a text anew, statement by statement.
struct Translator<'t> {
    analysis: Analysis,
    lines: Vec<&'t str>,
    comments: std::iter::Peekable<std::slice::Iter<'t, Comment>>,
    out: String,
    /// Blocks around the statement that is written.
    level: usize,
    /// Line of the original that was written last.
    last_line: u32,
    /// Whether an empty line was just written, or nothing yet.
    has_break: bool,
    messages: Vec<Message>,
    /// What was said already: once a line is enough.
    said: BTreeSet<(u32, MessageKind, String)>,
    names: BTreeMap<String, String>,
    /// Line of the statement that is written.
    line: u32,
}

impl Translator<'_> {
    fn say(&mut self, line: u32, kind: MessageKind, name: &str, text: Text) {
        if self.said.insert((line, kind, name.to_owned())) {
            self.messages.push(Message {
                line,
                kind,
                name: name.to_owned(),
                text,
            });
        }
    }

    /// A name of the original as it is called here.
    fn name(&mut self, name: &str, line: u32) -> String {
        if let Some(known) = self.names.get(name) {
            return known.clone();
        }
        let new = names::renamed(name);
        if new != name {
            self.say(
                line,
                MessageKind::Renamed,
                name,
                text!(
                    "is called {new}, because {name} means something else here",
                    "称为 {new}，因为 {name} 在这里另有含义"
                ),
            );
        }
        self.names.insert(name.to_owned(), new.clone());
        new
    }

    /// A call that raises, for what has no counterpart.
    fn missing(&mut self, line: u32, name: &str, why: Text) -> String {
        let why = match why.is_empty() {
            true => text!("it has no counterpart", "它没有对应"),
            false => why,
        };
        self.say(line, MessageKind::Missing, name, why.clone());
        format!(
            "not_available({})",
            expressions::quoted(&format!("{name}: {why}"))
        )
    }
}
