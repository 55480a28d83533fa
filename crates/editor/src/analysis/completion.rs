//! What could be written at the cursor.

use controller::cell::point::IoPointName;
use elite_lang::library::{LibraryMember, MemberKind};
use elite_runtime::builtins::declare::ParameterType;
use elite_syntax::Span;
use elite_syntax::lexer::TokenKind as T;

use super::cursor::CursorContext;
use super::scopes::SymbolKind;
use super::signature::callable;
use super::types::{Type, TypeRef, class_and_ancestors};
use super::words::Language;
use super::{Analysis, describe, library};

/// What a completion is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompletionKind {
    /// A function.
    Function,
    /// A method.
    Method,
    /// A class.
    Class,
    /// A variable.
    Variable,
    /// An attribute.
    Field,
    /// A module.
    Module,
    /// A keyword of the language.
    Keyword,
    /// A keyword argument.
    Argument,
    /// A text in quotes.
    Text,
}

/// Something that could be written.
#[derive(Debug)]
pub struct CompletionItem {
    /// What is shown and inserted.
    pub label: String,
    /// What it is.
    pub kind: CompletionKind,
    /// A short text behind it.
    pub detail: String,
    /// Nearer things come first.
    pub rank: u8,
}

/// The completions at a place, and the text that they replace.
pub struct Completions {
    /// What could be written.
    pub items: Vec<CompletionItem>,
    /// What it replaces.
    pub span: Span,
}

/// Words of the language that can begin or join something.
const KEYWORDS: &[&str] = &[
    "False", "None", "True", "and", "as", "assert", "break", "class", "continue", "def", "del",
    "elif", "else", "end", "except", "finally", "for", "from", "global", "if", "import", "in",
    "is", "lambda", "nonlocal", "not", "or", "pass", "raise", "return", "sec", "try", "while",
    "with", "yield",
];

/// What could be written at `offset`.
pub fn complete(analysis: &Analysis, offset: u32, language: Language) -> Completions {
    let cursor = CursorContext::at(analysis, offset);
    let mut found = CompletionBuilder {
        analysis,
        language,
        typed: cursor.typed().to_lowercase(),
        items: Vec::new(),
    };
    let mut span = cursor.word;
    if cursor.is_comment {
        return Completions {
            items: Vec::new(),
            span,
        };
    }
    if let Some(string) = cursor.string {
        span = found.in_string(&cursor, string);
    } else if let Some(value) = cursor.receiver() {
        found.attributes(&value);
    } else {
        found.words(&cursor);
    }
    let mut items = found.items;
    items.sort_by(|a, b| (a.rank, &a.label).cmp(&(b.rank, &b.label)));
    items.dedup_by(|a, b| a.label == b.label);
    Completions { items, span }
}

/// The long text about a completion that stands at `offset`.
pub fn resolve(label: &str, language: Language) -> Option<String> {
    match library::robot(label) {
        Some(builtin) => Some(describe::robot(builtin, language)),
        None => library::PYTHON
            .get(label)
            .map(|member| describe::member(member, "", language)),
    }
}

struct CompletionBuilder<'a> {
    analysis: &'a Analysis,
    language: Language,
    /// What has been typed, in small letters.
    typed: String,
    items: Vec<CompletionItem>,
}

impl CompletionBuilder<'_> {
    fn push(&mut self, label: &str, kind: CompletionKind, detail: impl Into<String>, rank: u8) {
        // Names that begin with an underscore are there for those who ask for them.
        let hidden = label.starts_with('_') && !self.typed.starts_with('_');
        if hidden || !is_like(label, &self.typed) {
            return;
        }
        self.items.push(CompletionItem {
            label: label.to_owned(),
            kind,
            detail: detail.into(),
            rank,
        });
    }

    fn members(&mut self, members: &[LibraryMember], method: bool) {
        for member in members {
            let kind = match member.kind {
                MemberKind::Function if method => CompletionKind::Method,
                MemberKind::Function => CompletionKind::Function,
                MemberKind::Class => CompletionKind::Class,
                MemberKind::Module => CompletionKind::Module,
                MemberKind::Value => CompletionKind::Field,
            };
            let detail = member.signature.clone().unwrap_or_default();
            self.push(&member.name, kind, detail, 1);
        }
    }

    fn attributes(&mut self, value: &TypeRef) {
        let names = &self.analysis.names;
        match self.analysis.infer(value) {
            Type::Instance(class) | Type::Class(class) => {
                for (distance, class) in class_and_ancestors(names, class).into_iter().enumerate() {
                    for attribute in &names.classes[class].attributes {
                        let (kind, detail) = match attribute.function {
                            Some(function) => (
                                CompletionKind::Method,
                                names.functions[function].signature(),
                            ),
                            None => {
                                let types = attribute.values.iter().map(|v| self.analysis.infer(v));
                                let told = types.filter_map(|found| found.describe(names)).next();
                                (CompletionKind::Field, told.unwrap_or_default())
                            }
                        };
                        self.push(&attribute.name, kind, detail, distance.min(9) as u8);
                    }
                }
            }
            Type::Value(owner) | Type::Container(owner, _) => {
                self.members(library::members_of_type(&owner), true);
            }
            Type::Module(module) => {
                self.members(library::members_of_module(&module), false);
                let inner = format!("{module}.");
                for name in elite_syntax::python_names::module_names() {
                    if let Some(rest) = name.strip_prefix(&inner) {
                        self.push(rest, CompletionKind::Module, "", 1);
                    }
                }
            }
            Type::Test => {
                for (name, _) in script_test::function_parameters() {
                    let detail = describe::test_signature(name).unwrap_or_default();
                    self.push(name, CompletionKind::Method, detail, 0);
                }
            }
            _ => {}
        }
    }

    fn words(&mut self, cursor: &CursorContext<'_>) {
        let before = cursor.before();
        let kind = |back: usize| before.len().checked_sub(back).map(|at| before[at].kind);
        match kind(1) {
            Some(T::Def | T::Class) => return,
            Some(T::Int | T::Float) => return,
            Some(T::Import) if kind(3) != Some(T::From) && kind(2) != Some(T::Name) => {
                return self.modules();
            }
            Some(T::From) => return self.modules(),
            _ => {}
        }
        if let Some(module) = imported_from(self.analysis, cursor) {
            return self.members(library::members_of_module(&module), false);
        }
        if let Some(call) = cursor.call() {
            self.arguments(&call);
        }
        self.names_in_scope(cursor.scope);
        for (name, builtin) in library::ROBOT.iter() {
            if !name.contains('.') && *name != "print" {
                self.push(name, CompletionKind::Function, builtin.signature(), 4);
            }
        }
        for (name, member) in library::PYTHON.iter() {
            let kind = match member.kind {
                MemberKind::Class => CompletionKind::Class,
                _ => CompletionKind::Function,
            };
            let detail = member.signature.clone().unwrap_or_default();
            self.push(name, kind, detail, 5);
        }
        if self.analysis.kind == super::TextKind::Test {
            self.push(script_test::OBJECT, CompletionKind::Variable, "", 3);
        }
        for keyword in KEYWORDS {
            self.push(keyword, CompletionKind::Keyword, "", 6);
        }
    }

    fn modules(&mut self) {
        for name in elite_syntax::python_names::module_names() {
            self.push(name, CompletionKind::Module, "", 1);
        }
    }

    fn arguments(&mut self, call: &super::cursor::OpenCall) {
        if call.keyword.is_some() {
            return;
        }
        let function = self.analysis.infer(&call.function);
        let Some(callable) = callable(self.analysis, &function, self.language) else {
            return;
        };
        for (index, parameter) in callable.parameters.iter().enumerate() {
            let Some(name) = &parameter.name else {
                continue;
            };
            if parameter.is_rest || index < call.positional() || call.given.contains(name) {
                continue;
            }
            let label = format!("{name}=");
            self.push(&label, CompletionKind::Argument, parameter.text.clone(), 0);
        }
    }

    fn names_in_scope(&mut self, scope: usize) {
        let names = &self.analysis.names;
        for symbol in names.visible(scope) {
            let symbol = &names.symbols[symbol];
            let types = symbol.values.iter().map(|value| self.analysis.infer(value));
            let found = types
                .into_iter()
                .find(|found| !matches!(found, Type::Unknown))
                .unwrap_or(Type::Unknown);
            let (kind, detail) = match (&symbol.kind, &found) {
                (_, Type::Function(function)) => (
                    CompletionKind::Function,
                    names.functions[*function].signature(),
                ),
                (SymbolKind::Class, _) => (CompletionKind::Class, String::new()),
                (_, Type::Module(_)) => (CompletionKind::Module, String::new()),
                (_, found) => (
                    CompletionKind::Variable,
                    found.describe(names).unwrap_or_default(),
                ),
            };
            let rank = if symbol.scope == 0 { 3 } else { 2 };
            self.push(&symbol.name, kind, detail, rank);
        }
    }

    /// Texts that an argument can be: names of inputs and outputs, the words that a parameter takes.
    fn in_string(&mut self, cursor: &CursorContext<'_>, string: Span) -> Span {
        let written = self.analysis.file.slice(string);
        let quote = written.find(['"', '\'']).map_or(written.len(), |at| at + 1);
        let span = Span {
            start: string.start + quote as u32,
            end: string.end,
        };
        self.typed = written.get(quote..).unwrap_or("").to_lowercase();
        let Some(call) = cursor.call() else {
            return span;
        };
        match self.analysis.infer(&call.function) {
            Type::TestFunction(name)
                if matches!(&*name, "set" | "get")
                    && (call.position == 0 || call.keyword.as_deref() == Some("name")) =>
            {
                for point in IoPointName::all() {
                    let level = match point.group.is_digital() {
                        true => "bool",
                        false => "float",
                    };
                    self.push(&point.to_string(), CompletionKind::Text, level, 0);
                }
            }
            Type::Robot(builtin) => {
                let parameter = match &call.keyword {
                    Some(keyword) => builtin.params.iter().find(|p| p.name == keyword),
                    None => builtin.params.get(call.position),
                };
                let words: &[&str] = match parameter.map(|parameter| parameter.kind) {
                    Some(ParameterType::Word(words)) => words,
                    Some(ParameterType::Frame) => &["base", "tool"],
                    _ => &[],
                };
                for word in words {
                    self.push(word, CompletionKind::Text, builtin.name, 0);
                }
            }
            _ => {}
        }
        span
    }
}

/// The module of `from module import …` that the cursor is in.
fn imported_from(analysis: &Analysis, cursor: &CursorContext<'_>) -> Option<String> {
    let before = cursor.before();
    let start = before
        .iter()
        .rposition(|token| token.kind == T::Newline)
        .map_or(0, |at| at + 1);
    let line = &before[start..];
    if line.first()?.kind != T::From {
        return None;
    }
    let import = line.iter().position(|token| token.kind == T::Import)?;
    let name: String = line[1..import]
        .iter()
        .map(|token| analysis.file.slice(token.span))
        .collect();
    Some(name)
}

/// Whether the letters that were typed are in a name in this order, the first one at its beginning or a word's.
fn is_like(name: &str, typed: &str) -> bool {
    let mut letters = typed.chars();
    let Some(mut wanted) = letters.next() else {
        return true;
    };
    let mut at_word = true;
    let mut begun = false;
    for c in name.chars() {
        let fits = c.to_lowercase().eq(std::iter::once(wanted));
        if fits && (begun || at_word) {
            begun = true;
            match letters.next() {
                Some(next) => wanted = next,
                None => return true,
            }
        }
        at_word = c == '_' || c == '.';
    }
    false
}
