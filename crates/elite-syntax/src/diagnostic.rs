//! The one model for findings in program text: syntax errors, scope errors, warnings.
//!
//! Owns the data and its two forms, for people (annotate-snippets) and for editors (flat fields).
//! Errors of running programs are `ScriptError`, not diagnostics.

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use messages::{Language, Text, text};

use crate::excerpt::Excerpt;
use crate::source::{SourceFile, Span};
use crate::task_node::TaskNode;

/// How serious a finding is. Only errors keep a program from running.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The program runs, but probably not as meant.
    Warning,
    /// The program does not compile.
    Error,
}

/// A second place that explains a finding, with its text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Where.
    pub span: Span,
    /// What about it.
    pub text: Text,
}

/// A change of the text that is likely to do away with a finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// What is to be replaced.
    pub span: Span,
    /// By this.
    pub text: String,
}

/// One finding in a program text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Stable short name, for example `syntax`, `indentation`, `undefined-name`.
    pub code: &'static str,
    /// Error or warning.
    pub severity: Severity,
    /// A sentence for people.
    pub message: Text,
    /// The place it is about.
    pub span: Span,
    /// Further places.
    pub labels: Vec<Label>,
    /// What to do about it, if there is advice.
    pub help: Option<Text>,
    /// The change that the advice comes to, where that is known.
    pub fix: Option<Fix>,
    /// The node of the pendant's task that it is in: that of the last directive before it.
    pub node: Option<TaskNode>,
}

/// The flat fields of a finding as editors and `check --format json` want them: lines and columns from 1,
/// columns in characters, `end_column` exclusive.
#[derive(Clone, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct DiagnosticFields {
    pub file: String,
    pub line: u32,
    pub column: u32,
    pub end_line: u32,
    pub end_column: u32,
    pub code: &'static str,
    pub message: String,
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error without further labels.
    pub fn error(code: &'static str, span: Span, message: Text) -> Self {
        Diagnostic {
            code,
            severity: Severity::Error,
            message,
            span,
            labels: Vec::new(),
            help: None,
            fix: None,
            node: None,
        }
    }

    /// A warning without further labels.
    pub fn warning(code: &'static str, span: Span, message: Text) -> Self {
        Diagnostic {
            severity: Severity::Warning,
            ..Self::error(code, span, message)
        }
    }

    /// Adds a second place.
    pub fn with_label(mut self, span: Span, text: Text) -> Self {
        self.labels.push(Label { span, text });
        self
    }

    /// Adds the change that the advice comes to.
    pub fn with_fix(mut self, span: Span, text: impl Into<String>) -> Self {
        let text = text.into();
        self.fix = Some(Fix { span, text });
        self
    }

    /// Adds advice.
    pub fn with_help(mut self, help: Text) -> Self {
        self.help = Some(help);
        self
    }

    /// The fields of this finding for editors.
    pub fn fields(&self, file: &SourceFile) -> DiagnosticFields {
        let start = file.position(self.span.start);
        let end = file.position(self.span.end.max(self.span.start));
        DiagnosticFields {
            file: file.name().to_owned(),
            line: start.line,
            column: start.column,
            end_line: end.line,
            end_column: end.column,
            code: self.code,
            message: self.message.english().to_owned(),
            help: self.help.as_ref().map(|help| help.english().to_owned()),
        }
    }
}

/// Renders a finding for people: title, source lines with carets, labels, node, help. With `ansi`, in colour.
pub fn render_human(
    diagnostic: &Diagnostic,
    file: &SourceFile,
    language: Language,
    ansi: bool,
) -> String {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let own = diagnostic.span;
    let labels = diagnostic.labels.iter().map(|label| label.span);
    let excerpt = Excerpt::new(
        file,
        &std::iter::once(own).chain(labels).collect::<Vec<_>>(),
    );
    let mut snippet = Snippet::source(&*excerpt.text).line_start(excerpt.first_line as usize);
    let mut far = Vec::new();
    if let Some(range) = excerpt.range_of(file, own) {
        snippet = snippet.annotation(AnnotationKind::Primary.span(range));
    }
    for label in &diagnostic.labels {
        match excerpt.range_of(file, label.span) {
            Some(range) => {
                let annotation = AnnotationKind::Context
                    .span(range)
                    .label(label.text.in_language(language));
                snippet = snippet.annotation(annotation);
            }
            None => far.push((label, Excerpt::new(file, &[label.span]))),
        }
    }
    let title = level
        .primary_title(diagnostic.message.in_language(language))
        .id(diagnostic.code);
    let mut group = Group::with_title(title);
    if excerpt.is_cut(file, own) {
        // The columns of a line that is cut are not those of the file.
        let place = file.position(own.start);
        let origin = Origin::path(file.name()).line(place.line as usize);
        group = group.element(origin.char_column(place.column as usize));
    } else {
        snippet = snippet.path(file.name());
    }
    group = group.element(snippet);
    for (label, excerpt) in &far {
        let range = excerpt.range_of(file, label.span).unwrap_or_default();
        let annotation = AnnotationKind::Context
            .span(range)
            .label(label.text.in_language(language));
        let snippet = Snippet::source(&*excerpt.text).line_start(excerpt.first_line as usize);
        group = group.element(snippet.path(file.name()).annotation(annotation));
    }
    if let Some(node) = &diagnostic.node {
        let place = text!("in {node}", "位于{node}");
        group = group.element(Level::NOTE.message(place.in_language(language).to_owned()));
    }
    if let Some(help) = &diagnostic.help {
        group = group.element(Level::HELP.message(help.in_language(language)));
    }
    let renderer = if ansi {
        Renderer::styled()
    } else {
        Renderer::plain()
    };
    renderer.render(&[group]).to_string()
}

/// A finding as [`render_human`] shows it, without colour, in both languages.
pub fn picture(diagnostic: &Diagnostic, file: &SourceFile) -> Text {
    let [english, chinese] = [Language::English, Language::Chinese]
        .map(|language| render_human(diagnostic, file, language, false));
    Text::new(english, chinese)
}
