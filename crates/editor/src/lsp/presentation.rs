//! Requests about how a text is shown and changed as a whole: colours, hints, formatting, code actions.

use std::collections::HashMap;

use ls_types::{
    CodeActionParams, DocumentFormattingParams, InlayHint, InlayHintLabel, InlayHintParams,
    InlayHintTooltip, Range, TextDocumentIdentifier, TextEdit, WorkspaceEdit,
};
use serde::Deserialize;
use serde_json::{Value, json};

use super::diagnostics;
use super::documents::Document;
use super::navigation::DocumentParams;
use super::positions::Encoding;
use super::requests::{document_and_analysis, markdown, span_of, to_response};
use super::server::{LanguageServer, RequestError};
use crate::analysis::fixes::{Edit, fixes};
use crate::analysis::format::{Indent, format};
use crate::analysis::inlay::hints;
use crate::analysis::semantic::{SemanticToken, semantic_tokens};

/// The parameters of requests about a part of a text.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct PartOfText {
    /// The document that is asked about.
    pub text_document: TextDocumentIdentifier,
    /// The part of the document that is asked about.
    pub range: Range,
}

pub(super) fn colours(
    server: &mut LanguageServer,
    params: DocumentParams,
) -> Result<Value, RequestError> {
    let encoding = server.documents.encoding;
    let (document, analysis) = document_and_analysis(server, &params.text_document.uri)?;
    let all = elite_syntax::Span::new(0, document.text.len());
    Ok(encoded(
        document,
        &semantic_tokens(&analysis, all),
        encoding,
    ))
}

pub(super) fn colours_in(
    server: &mut LanguageServer,
    params: PartOfText,
) -> Result<Value, RequestError> {
    let encoding = server.documents.encoding;
    let (document, analysis) = document_and_analysis(server, &params.text_document.uri)?;
    let within = span_of(document, params.range, encoding);
    Ok(encoded(
        document,
        &semantic_tokens(&analysis, within),
        encoding,
    ))
}

/// Five numbers a word, places counted from the word before.
fn encoded(document: &Document, words: &[SemanticToken], encoding: Encoding) -> Value {
    let mut data: Vec<u32> = Vec::with_capacity(5 * words.len());
    let (mut line, mut column) = (0, 0);
    for word in words {
        let range = document.range(word.span, encoding);
        if range.start.line != range.end.line {
            continue;
        }
        let start = range.start;
        let from = if start.line == line { column } else { 0 };
        let modifiers = u32::from(word.is_declared) | u32::from(word.is_builtin) << 1;
        data.extend([
            start.line - line,
            start.character - from,
            range.end.character - start.character,
            word.kind as u32,
            modifiers,
        ]);
        (line, column) = (start.line, start.character);
    }
    json!({ "data": data })
}

pub(super) fn inlay_hints(
    server: &mut LanguageServer,
    params: InlayHintParams,
) -> Result<Value, RequestError> {
    let (encoding, language) = (server.documents.encoding, server.language);
    let (document, analysis) = document_and_analysis(server, &params.text_document.uri)?;
    let within = span_of(document, params.range, encoding);
    let found = hints(&analysis, within, language).into_iter();
    let found = found
        .filter(|hint| within.start <= hint.at && hint.at <= within.end)
        .map(|hint| InlayHint {
            position: document.lines.position(&document.text, hint.at, encoding),
            label: InlayHintLabel::String(hint.unit),
            kind: None,
            text_edits: None,
            tooltip: Some(InlayHintTooltip::MarkupContent(markdown(hint.text))),
            padding_left: Some(true),
            padding_right: None,
            data: None,
        });
    to_response(found.collect::<Vec<_>>())
}

fn text_edits(document: &Document, edits: Vec<Edit>, encoding: Encoding) -> Vec<TextEdit> {
    let edits = edits.into_iter();
    edits
        .map(|edit| TextEdit {
            range: document.range(edit.span, encoding),
            new_text: edit.text,
        })
        .collect()
}

pub(super) fn formatting(
    server: &mut LanguageServer,
    params: DocumentFormattingParams,
) -> Result<Value, RequestError> {
    let (encoding, language) = (server.documents.encoding, server.language);
    let (document, analysis) = document_and_analysis(server, &params.text_document.uri)?;
    let indent = Indent {
        blanks: params.options.tab_size,
        tabs: !params.options.insert_spaces,
    };
    let edits =
        format(&analysis, indent).map_err(|error| RequestError::failed(&error, language))?;
    to_response(text_edits(document, edits, encoding))
}

pub(super) fn code_actions(
    server: &mut LanguageServer,
    params: CodeActionParams,
) -> Result<Value, RequestError> {
    let (encoding, language) = (server.documents.encoding, server.language);
    let wanted = params.context.only.unwrap_or_default();
    let takes_fixes = wanted.is_empty() || wanted.iter().any(|kind| kind.as_str() == "quickfix");
    let (document, analysis) = document_and_analysis(server, &params.text_document.uri)?;
    let within = span_of(document, params.range, encoding);
    let mut actions = Vec::new();
    for finding in analysis.findings().iter().filter(|_| takes_fixes) {
        if finding.span.end < within.start || within.end < finding.span.start {
            continue;
        }
        let told_as = diagnostics::diagnostic(document, finding, encoding, language);
        for fix in fixes(&analysis, finding, language) {
            let edits = text_edits(document, fix.edits, encoding);
            let changes = HashMap::from([(document.uri.clone(), edits)]);
            let edit = to_response(WorkspaceEdit {
                changes: Some(changes),
                ..WorkspaceEdit::default()
            })?;
            actions.push(json!({
                "title": fix.title,
                "kind": "quickfix",
                "diagnostics": [told_as],
                "isPreferred": fix.is_preferred,
                "edit": edit,
            }));
        }
    }
    Ok(Value::Array(actions))
}
