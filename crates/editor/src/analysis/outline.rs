//! What a program consists of: its functions, classes and variables as a tree, and what can be folded.

use elite_syntax::Span;
use elite_syntax::ast::Stmt;
use elite_syntax::ast::visit::blocks;
use elite_syntax::lexer::TokenKind;

use super::Analysis;
use super::scopes::SymbolKind;

/// What an entry of the outline is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutlineKind {
    /// A function.
    Function,
    /// A method.
    Method,
    /// A class.
    Class,
    /// A variable of the program.
    Variable,
    /// An attribute.
    Field,
}

/// An entry of the outline.
#[derive(Debug)]
pub struct OutlineEntry {
    /// Name of the function, class or variable.
    pub name: String,
    /// What it is.
    pub kind: OutlineKind,
    /// Parameters of a function or method; empty without any.
    pub detail: String,
    /// The whole definition.
    pub span: Span,
    /// Place of the name in the text.
    pub name_span: Span,
    /// Entries inside of this one.
    pub children: Vec<OutlineEntry>,
}

/// The functions, classes and variables of a program.
pub fn outline(analysis: &Analysis) -> Vec<OutlineEntry> {
    within(analysis, 0, 0)
}

/// Levels of functions within functions that are shown.
const LEVELS_MAX: u32 = 20;

fn within(analysis: &Analysis, scope: usize, level: u32) -> Vec<OutlineEntry> {
    let names = &analysis.names;
    let mut found = Vec::new();
    if level == LEVELS_MAX {
        return found;
    }
    let is_child = |inner: usize| names.scopes[inner].parent == Some(scope);
    for info in names.functions.iter().filter(|f| is_child(f.scope)) {
        let signature = info.signature();
        let kind = match info.class {
            Some(_) => OutlineKind::Method,
            None => OutlineKind::Function,
        };
        found.push(OutlineEntry {
            name: info.name.to_string(),
            kind,
            detail: signature[info.name.len()..].to_owned(),
            span: info.span,
            name_span: info.name_span,
            children: within(analysis, info.scope, level + 1),
        });
    }
    for info in names.classes.iter().filter(|class| is_child(class.scope)) {
        let mut children = within(analysis, info.scope, level + 1);
        for attribute in info.attributes.iter().filter(|a| a.function.is_none()) {
            if let Some(place) = attribute.places.first() {
                children.push(OutlineEntry {
                    name: attribute.name.to_string(),
                    kind: OutlineKind::Field,
                    detail: String::new(),
                    span: *place,
                    name_span: *place,
                    children: Vec::new(),
                });
            }
        }
        children.sort_by_key(|entry| entry.span.start);
        found.push(OutlineEntry {
            name: info.name.to_string(),
            kind: OutlineKind::Class,
            detail: String::new(),
            span: info.span,
            name_span: info.name_span,
            children,
        });
    }
    if scope == 0 {
        for symbol in &names.symbols {
            let first = symbol.bindings().next();
            if let (0, SymbolKind::Variable, Some(first)) = (symbol.scope, symbol.kind, first) {
                found.push(OutlineEntry {
                    name: symbol.name.to_string(),
                    kind: OutlineKind::Variable,
                    detail: String::new(),
                    span: first.span,
                    name_span: first.span,
                    children: Vec::new(),
                });
            }
        }
    }
    // Definitions whose text does not parse may lack their name.
    found.retain(|entry| entry.name_span.end > entry.name_span.start);
    for entry in &mut found {
        entry.span = entry.span.to(entry.name_span);
    }
    found.sort_by_key(|entry| entry.span.start);
    found
}

/// What kind of lines can be folded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FoldKind {
    /// A block, a bracket or a long string.
    Code,
    /// Lines of comments.
    Comment,
    /// Lines of imports.
    Imports,
}

/// Lines that can be folded: from the end of the first to the end of the last. Counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fold {
    /// The line that stays.
    pub first: u32,
    /// The last one that goes.
    pub last: u32,
    /// What they are.
    pub kind: FoldKind,
}

/// What can be folded, in the order of the text.
pub fn folds(analysis: &Analysis) -> Vec<Fold> {
    let file = &analysis.file;
    let mut found = Vec::new();
    let mut put = |span: Span, kind: FoldKind| {
        let first = file.line_of(span.start);
        // A block ends where the next statement begins, behind its indentation.
        let whole = file.text().get(span.start as usize..span.end as usize);
        let length = whole.map_or(0, |text| text.trim_end().len()) as u32;
        let last = file.line_of(span.start + length.max(1) - 1);
        if last > first {
            found.push(Fold { first, last, kind });
        }
    };
    for statement in &analysis.module().body {
        statement_folds(statement, &mut put);
    }
    let mut open: Vec<u32> = Vec::new();
    for token in analysis.tokens() {
        match token.kind {
            TokenKind::LeftParen | TokenKind::LeftBracket | TokenKind::LeftBrace => {
                open.push(token.span.start);
            }
            TokenKind::RightParen | TokenKind::RightBracket | TokenKind::RightBrace => {
                if let Some(start) = open.pop() {
                    // The line of the closing bracket stays when something follows; editors like it so.
                    put(
                        Span {
                            start,
                            end: token.span.start.max(start),
                        },
                        FoldKind::Code,
                    );
                }
            }
            TokenKind::Str => put(token.span, FoldKind::Code),
            _ => {}
        }
    }
    let mut run: Option<Span> = None;
    let mut last_line = 0;
    for comment in analysis.comments() {
        let line = file.line_of(comment.start);
        let alone = file.line_text(line).trim_start().starts_with('#');
        run = match run {
            Some(before) if alone && line == last_line + 1 => Some(before.to(comment)),
            before => {
                before
                    .into_iter()
                    .for_each(|span| put(span, FoldKind::Comment));
                alone.then_some(comment)
            }
        };
        last_line = line;
    }
    run.into_iter()
        .for_each(|span| put(span, FoldKind::Comment));
    let imports = analysis
        .module()
        .body
        .iter()
        .take_while(|statement| is_import(statement));
    if let Some(all) = imports.map(|statement| statement.span).reduce(Span::to) {
        put(all, FoldKind::Imports);
    }
    found.sort_by_key(|fold| (fold.first, std::cmp::Reverse(fold.last)));
    found.dedup_by_key(|fold| fold.first);
    found
}

fn is_import(statement: &Stmt) -> bool {
    use elite_syntax::ast::StmtKind;
    matches!(
        statement.kind,
        StmtKind::Import(_) | StmtKind::ImportFrom { .. }
    )
}

fn statement_folds(statement: &Stmt, put: &mut impl FnMut(Span, FoldKind)) {
    let bodies = blocks(statement);
    let last = bodies.iter().rev().find_map(|body| body.last());
    let Some(last) = last else { return };
    put(statement.span.to(last.span), FoldKind::Code);
    for body in bodies {
        for inner in body {
            statement_folds(inner, put);
        }
    }
}
