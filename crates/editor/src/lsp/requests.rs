//! Requests about texts: parameters in, the answer of the analysis out.

use std::sync::Arc;

use elite_syntax::Span;
use ls_types::{
    CompletionItem, CompletionItemKind, CompletionList, CompletionTextEdit, Documentation, Hover,
    HoverContents, MarkupContent, MarkupKind, ParameterInformation, ParameterLabel, SignatureHelp,
    SignatureInformation, TextDocumentPositionParams, TextEdit, Uri,
};
use lsp_server::{ErrorCode, Request};
use serde::Serialize;
use serde_json::Value;

use super::documents::Document;
use super::server::{LanguageServer, RequestError, parsed};
use super::{navigation, presentation, workspace};
use crate::analysis::completion::{self, CompletionKind};
use crate::analysis::{Analysis, hover, signature};

/// Answers a request.
///
/// # Errors
/// The refusal that the client gets.
pub fn answer(server: &mut LanguageServer, request: Request) -> Result<Value, RequestError> {
    let params = request.params;
    match &*request.method {
        "textDocument/hover" => hover(server, parsed(params)?),
        "textDocument/completion" => completion(server, parsed(params)?),
        "completionItem/resolve" => resolve(server, parsed(params)?),
        "textDocument/signatureHelp" => signature_help(server, parsed(params)?),
        "textDocument/definition" => navigation::definition(server, parsed(params)?),
        "textDocument/references" => navigation::references(server, parsed(params)?),
        "textDocument/documentHighlight" => navigation::highlight(server, parsed(params)?),
        "textDocument/prepareRename" => navigation::prepare_rename(server, parsed(params)?),
        "textDocument/rename" => navigation::rename(server, parsed(params)?),
        "textDocument/documentSymbol" => navigation::document_symbols(server, parsed(params)?),
        "textDocument/foldingRange" => navigation::folding(server, parsed(params)?),
        "workspace/symbol" => workspace::symbols(server, parsed(params)?),
        "textDocument/semanticTokens/full" => presentation::colours(server, parsed(params)?),
        "textDocument/semanticTokens/range" => presentation::colours_in(server, parsed(params)?),
        "textDocument/inlayHint" => presentation::inlay_hints(server, parsed(params)?),
        "textDocument/formatting" => presentation::formatting(server, parsed(params)?),
        "textDocument/codeAction" => presentation::code_actions(server, parsed(params)?),
        other => Err(RequestError {
            code: ErrorCode::MethodNotFound,
            message: format!(
                "'{}' is not known here",
                other.chars().take(80).collect::<String>()
            ),
        }),
    }
}

/// A text that a request is about, with its analysis.
pub(super) fn document_and_analysis<'s>(
    server: &'s mut LanguageServer,
    uri: &Uri,
) -> Result<(&'s mut Document, Arc<Analysis>), RequestError> {
    let language = server.language;
    let document = server
        .documents
        .get(uri)
        .map_err(|error| RequestError::failed(&error, language))?;
    let analysis = document.analysis();
    Ok((document, analysis))
}

/// An answer in the protocol's form.
pub(super) fn to_response(answer: impl Serialize) -> Result<Value, RequestError> {
    serde_json::to_value(answer).map_err(|error| RequestError {
        code: ErrorCode::InternalError,
        message: format!("the answer has no JSON form: {error}"),
    })
}

pub(super) fn markdown(text: String) -> MarkupContent {
    MarkupContent {
        kind: MarkupKind::Markdown,
        value: text,
    }
}

fn hover(
    server: &mut LanguageServer,
    params: TextDocumentPositionParams,
) -> Result<Value, RequestError> {
    let (encoding, language) = (server.documents.encoding, server.language);
    let (document, analysis) = document_and_analysis(server, &params.text_document.uri)?;
    let offset = document.offset(params.position, encoding);
    let found = hover::hover(&analysis, offset, language);
    to_response(found.map(|found| Hover {
        contents: HoverContents::Markup(markdown(found.text)),
        range: Some(document.range(found.span, encoding)),
    }))
}

fn completion(
    server: &mut LanguageServer,
    params: TextDocumentPositionParams,
) -> Result<Value, RequestError> {
    let (encoding, language) = (server.documents.encoding, server.language);
    let (document, analysis) = document_and_analysis(server, &params.text_document.uri)?;
    let offset = document.offset(params.position, encoding);
    let found = completion::complete(&analysis, offset, language);
    let range = document.range(found.span, encoding);
    let items = found.items.into_iter().map(|item| CompletionItem {
        kind: Some(item_kind(item.kind)),
        detail: (!item.detail.is_empty()).then_some(item.detail),
        sort_text: Some(format!("{}{}", item.rank, item.label)),
        text_edit: Some(CompletionTextEdit::Edit(TextEdit {
            range,
            new_text: item.label.clone(),
        })),
        label: item.label,
        ..CompletionItem::default()
    });
    to_response(CompletionList {
        is_incomplete: false,
        items: items.collect(),
    })
}

fn item_kind(kind: CompletionKind) -> CompletionItemKind {
    match kind {
        CompletionKind::Function => CompletionItemKind::FUNCTION,
        CompletionKind::Method => CompletionItemKind::METHOD,
        CompletionKind::Class => CompletionItemKind::CLASS,
        CompletionKind::Variable => CompletionItemKind::VARIABLE,
        CompletionKind::Field => CompletionItemKind::FIELD,
        CompletionKind::Module => CompletionItemKind::MODULE,
        CompletionKind::Keyword => CompletionItemKind::KEYWORD,
        CompletionKind::Argument => CompletionItemKind::PROPERTY,
        CompletionKind::Text => CompletionItemKind::VALUE,
    }
}

fn resolve(server: &mut LanguageServer, mut item: CompletionItem) -> Result<Value, RequestError> {
    let is_given = matches!(
        item.kind,
        Some(CompletionItemKind::FUNCTION | CompletionItemKind::CLASS)
    );
    if item.documentation.is_none() && is_given {
        let text = completion::resolve(&item.label, server.language);
        item.documentation = text.map(|text| Documentation::MarkupContent(markdown(text)));
    }
    to_response(item)
}

fn signature_help(
    server: &mut LanguageServer,
    params: TextDocumentPositionParams,
) -> Result<Value, RequestError> {
    let (encoding, language) = (server.documents.encoding, server.language);
    let (document, analysis) = document_and_analysis(server, &params.text_document.uri)?;
    let offset = document.offset(params.position, encoding);
    let Some(found) = signature::signature(&analysis, offset, language) else {
        return Ok(Value::Null);
    };
    let parameters = found
        .parameters
        .into_iter()
        .map(|(written, text)| ParameterInformation {
            label: ParameterLabel::Simple(written),
            documentation: (!text.is_empty()).then(|| Documentation::MarkupContent(markdown(text))),
        });
    let active = found.active.map(|active| active as u32);
    to_response(SignatureHelp {
        signatures: vec![SignatureInformation {
            label: found.label,
            documentation: (!found.text.is_empty())
                .then(|| Documentation::MarkupContent(markdown(found.text))),
            parameters: Some(parameters.collect()),
            active_parameter: active,
        }],
        active_signature: Some(0),
        active_parameter: active,
    })
}

/// The span from `start` to `end` of a range.
pub(super) fn span_of(
    document: &Document,
    range: ls_types::Range,
    encoding: super::positions::Encoding,
) -> Span {
    let (a, b) = (
        document.offset(range.start, encoding),
        document.offset(range.end, encoding),
    );
    Span {
        start: a.min(b),
        end: a.max(b),
    }
}
