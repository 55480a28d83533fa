//! Requests that lead from places to places: definition, references, highlight, rename, symbols, folding.

use std::collections::HashMap;

use elite_syntax::Span;
use ls_types::{
    DocumentHighlight, DocumentHighlightKind, DocumentSymbol, FoldingRange, FoldingRangeKind,
    Location, ReferenceParams, RenameParams, SymbolKind, TextDocumentIdentifier,
    TextDocumentPositionParams, TextEdit, WorkspaceEdit,
};
use serde::Deserialize;
use serde_json::{Value, json};

use super::documents::Document;
use super::positions::Encoding;
use super::requests::{document_and_analysis, to_response};
use super::server::{LanguageServer, RequestError};
use crate::analysis::outline::{FoldKind, OutlineEntry, OutlineKind, folds, outline};
use crate::analysis::{navigate, rename};

/// The parameters of requests about a whole text.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct DocumentParams {
    /// The document that is asked about.
    pub text_document: TextDocumentIdentifier,
}

fn location(document: &Document, span: Span, encoding: Encoding) -> Location {
    Location {
        uri: document.uri.clone(),
        range: document.range(span, encoding),
    }
}

pub(super) fn definition(
    server: &mut LanguageServer,
    params: TextDocumentPositionParams,
) -> Result<Value, RequestError> {
    let encoding = server.documents.encoding;
    let (document, analysis) = document_and_analysis(server, &params.text_document.uri)?;
    let offset = document.offset(params.position, encoding);
    let found = navigate::definition(&analysis, offset).into_iter();
    let found = found.map(|span| location(document, span, encoding));
    to_response(found.collect::<Vec<_>>())
}

pub(super) fn references(
    server: &mut LanguageServer,
    params: ReferenceParams,
) -> Result<Value, RequestError> {
    let encoding = server.documents.encoding;
    let at = params.text_document_position;
    let (document, analysis) = document_and_analysis(server, &at.text_document.uri)?;
    let offset = document.offset(at.position, encoding);
    let with_declaration = params.context.include_declaration;
    let declared = navigate::definition(&analysis, offset);
    let found = navigate::references(&analysis, offset).into_iter();
    let found = found
        .filter(|place| with_declaration || !declared.contains(&place.span))
        .map(|place| location(document, place.span, encoding));
    to_response(found.collect::<Vec<_>>())
}

pub(super) fn highlight(
    server: &mut LanguageServer,
    params: TextDocumentPositionParams,
) -> Result<Value, RequestError> {
    let encoding = server.documents.encoding;
    let (document, analysis) = document_and_analysis(server, &params.text_document.uri)?;
    let offset = document.offset(params.position, encoding);
    let found = navigate::references(&analysis, offset).into_iter();
    let found = found.map(|place| DocumentHighlight {
        range: document.range(place.span, encoding),
        kind: Some(match place.is_bound {
            true => DocumentHighlightKind::WRITE,
            false => DocumentHighlightKind::READ,
        }),
    });
    to_response(found.collect::<Vec<_>>())
}

pub(super) fn prepare_rename(
    server: &mut LanguageServer,
    params: TextDocumentPositionParams,
) -> Result<Value, RequestError> {
    let (encoding, language) = (server.documents.encoding, server.language);
    let (document, analysis) = document_and_analysis(server, &params.text_document.uri)?;
    let offset = document.offset(params.position, encoding);
    let span = rename::renamable(&analysis, offset)
        .map_err(|error| RequestError::failed(&error, language))?;
    Ok(json!({
        "range": document.range(span, encoding),
        "placeholder": analysis.file.slice(span),
    }))
}

pub(super) fn rename(
    server: &mut LanguageServer,
    params: RenameParams,
) -> Result<Value, RequestError> {
    let (encoding, language) = (server.documents.encoding, server.language);
    let at = params.text_document_position;
    let (document, analysis) = document_and_analysis(server, &at.text_document.uri)?;
    let offset = document.offset(at.position, encoding);
    let places = rename::rename(&analysis, offset, &params.new_name)
        .map_err(|error| RequestError::failed(&error, language))?;
    let edits = places.into_iter().map(|span| TextEdit {
        range: document.range(span, encoding),
        new_text: params.new_name.clone(),
    });
    let changes = HashMap::from([(document.uri.clone(), edits.collect())]);
    to_response(WorkspaceEdit {
        changes: Some(changes),
        ..WorkspaceEdit::default()
    })
}

pub(super) fn document_symbols(
    server: &mut LanguageServer,
    params: DocumentParams,
) -> Result<Value, RequestError> {
    let encoding = server.documents.encoding;
    let (document, analysis) = document_and_analysis(server, &params.text_document.uri)?;
    let found = outline(&analysis).into_iter();
    to_response(
        found
            .map(|entry| symbol(document, entry, encoding))
            .collect::<Vec<_>>(),
    )
}

/// The protocol's number for what an entry is.
pub(super) fn symbol_kind(kind: OutlineKind) -> SymbolKind {
    match kind {
        OutlineKind::Function => SymbolKind::FUNCTION,
        OutlineKind::Method => SymbolKind::METHOD,
        OutlineKind::Class => SymbolKind::CLASS,
        OutlineKind::Variable => SymbolKind::VARIABLE,
        OutlineKind::Field => SymbolKind::FIELD,
    }
}

#[allow(deprecated, reason = "the field has to be given")]
fn symbol(document: &Document, entry: OutlineEntry, encoding: Encoding) -> DocumentSymbol {
    let children = entry.children.into_iter();
    DocumentSymbol {
        name: entry.name,
        detail: (!entry.detail.is_empty()).then_some(entry.detail),
        kind: symbol_kind(entry.kind),
        tags: None,
        deprecated: None,
        range: document.range(entry.span, encoding),
        selection_range: document.range(entry.name_span, encoding),
        children: Some(
            children
                .map(|child| symbol(document, child, encoding))
                .collect(),
        ),
    }
}

pub(super) fn folding(
    server: &mut LanguageServer,
    params: DocumentParams,
) -> Result<Value, RequestError> {
    let (_, analysis) = document_and_analysis(server, &params.text_document.uri)?;
    let found = folds(&analysis).into_iter().map(|fold| FoldingRange {
        start_line: fold.first - 1,
        end_line: fold.last - 1,
        kind: match fold.kind {
            FoldKind::Code => None,
            FoldKind::Comment => Some(FoldingRangeKind::Comment),
            FoldKind::Imports => Some(FoldingRangeKind::Imports),
        },
        ..FoldingRange::default()
    });
    to_response(found.collect::<Vec<_>>())
}
