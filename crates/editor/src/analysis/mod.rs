//! What there is to say about the text of a program: names and their places, types, and the answers that editors ask
//! for.
//!
//! Plain functions over a text and a byte offset; the language server and the page of the pendant call the same ones.
//! Knows no protocol. Findings are those of `eliteserver check`.

mod collect;
pub mod completion;
mod cursor;
pub mod describe;
pub mod fixes;
pub mod format;
pub mod hover;
mod incremental;
pub mod inlay;
pub mod library;
pub mod navigate;
pub mod outline;
pub mod rename;
pub mod scopes;
pub mod semantic;
pub mod signature;
mod type_ref;
pub mod types;
pub mod words;

use std::sync::{Arc, LazyLock};

use elite_syntax::ParsedDocument;
use elite_syntax::ast::Module;
use elite_syntax::lexer::{Token, TokenKind};
use elite_syntax::{Diagnostic, KnownNames, SourceFile, Span};

use scopes::NameTables;
use types::{Type, TypeRef};

/// What a text is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextKind {
    /// A program of the robot.
    Program,
    /// A test of programs, which finds the object `test`.
    Test,
}

impl TextKind {
    /// Told by the name of a file, as `eliteserver test` finds its files.
    pub fn of_path(path: &std::path::Path) -> Self {
        match script_test::is_test_file(path) {
            true => TextKind::Test,
            false => TextKind::Program,
        }
    }

    /// The names that its programs find.
    fn known(self) -> &'static KnownNames {
        static PROGRAM: LazyLock<KnownNames> = LazyLock::new(elite_runtime::builtins::known_names);
        static TEST: LazyLock<KnownNames> = LazyLock::new(|| {
            elite_runtime::builtins::known_names()
                .with_object(script_test::OBJECT, script_test::function_names())
        });
        match self {
            TextKind::Program => &PROGRAM,
            TextKind::Test => &TEST,
        }
    }
}

/// Everything about one text.
#[derive(Debug)]
pub struct Analysis {
    /// The text.
    pub file: Arc<SourceFile>,
    /// Purpose of the text.
    pub kind: TextKind,
    /// Tree, tokens and findings of the text.
    pub reading: ParsedDocument,
    /// Names in the text.
    pub names: NameTables,
}

impl Analysis {
    /// Reads a text. `name` is how findings call it.
    pub fn of(name: &str, text: &str, kind: TextKind) -> Self {
        let file = SourceFile::new(name, text);
        let reading = ParsedDocument::of(file.clone(), kind.known());
        let names = elite_syntax::with_deep_stack(|| incremental::names(&reading, None));
        Analysis {
            file,
            kind,
            reading,
            names,
        }
    }

    /// Reads what has become of the text; what the change leaves alone is not read anew.
    pub fn change(self, text: &str) -> Self {
        let file = SourceFile::new(self.file.name(), text);
        let reading = self.reading.reparse(file.clone(), self.kind.known());
        let names = Some(self.names);
        let names = elite_syntax::with_deep_stack(|| incremental::names(&reading, names));
        Analysis {
            file,
            kind: self.kind,
            reading,
            names,
        }
    }

    /// The tree.
    pub fn module(&self) -> &Module {
        self.reading.module()
    }

    /// The text.
    pub fn text(&self) -> &str {
        self.file.text()
    }

    /// What `eliteserver check` finds.
    pub fn findings(&self) -> &[Diagnostic] {
        self.reading.findings()
    }

    /// The tokens.
    pub fn tokens(&self) -> &[Token] {
        self.reading.tokens()
    }

    /// Whether the text has errors, so that parts of it may not have been understood.
    pub fn has_errors(&self) -> bool {
        let errors = |finding: &Diagnostic| finding.severity == elite_syntax::Severity::Error;
        self.findings().iter().any(errors)
    }

    /// The type of a value.
    pub fn infer(&self, shape: &TypeRef) -> Type {
        types::infer(&self.names, shape, self.kind == TextKind::Test)
    }

    /// The innermost scope at `offset`.
    pub fn scope_at(&self, offset: u32) -> scopes::ScopeId {
        let text = self.text();
        let offset_in = (offset as usize).min(text.len());
        let line = text[..text.floor_char_boundary(offset_in)]
            .rfind('\n')
            .map_or(0, |at| at + 1);
        let rest = &text[line..];
        let blanks = rest.len() - rest.trim_start_matches([' ', '\t']).len();
        let column = blanks.min(offset_in - line);
        self.names.scope_at(offset, column as u32)
    }

    /// The token at `offset`, which may touch its end; names and strings before what follows them.
    pub fn token_at(&self, offset: u32) -> Option<Token> {
        let tokens = self.tokens();
        let after = tokens.partition_point(|token| token.span.start <= offset);
        let candidates = tokens[..after].iter().rev().take(4);
        let mut hits = candidates
            .filter(|token| token.span.end > token.span.start && offset <= token.span.end);
        let first = *hits.next()?;
        let is_word = |token: &Token| token.kind == TokenKind::Name || token.kind.is_keyword();
        if is_word(&first) || offset < first.span.end && first.span.start < offset {
            return Some(first);
        }
        Some(hits.find(|token| is_word(token)).copied().unwrap_or(first))
    }

    /// The spans of comments and `$` directives: what lies between the tokens and is no blank.
    pub fn comments(&self) -> Vec<Span> {
        let text = self.text();
        let mut found = Vec::new();
        let mut at = 0;
        for token in self.tokens() {
            let start = (token.span.start as usize).max(at);
            comments_between(text, at, start, &mut found);
            at = at.max(token.span.end as usize);
        }
        comments_between(text, at, text.len(), &mut found);
        found
    }
}

fn comments_between(text: &str, start: usize, end: usize, found: &mut Vec<Span>) {
    let Some(gap) = text.get(start..end) else {
        return;
    };
    let mut at = start;
    for line in gap.split_inclusive(['\n', '\r']) {
        if let Some(mark) = line.find(['#', '$']) {
            let comment = line[mark..].trim_end_matches(['\n', '\r']);
            found.push(Span::new(at + mark, at + mark + comment.len()));
        }
        at += line.len();
    }
}
