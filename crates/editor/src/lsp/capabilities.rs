//! What the server says of itself.

use serde_json::{Value, json};

use crate::analysis::semantic::SemanticTokenKind;

/// The answer to `initialize`.
pub fn answer(columns_are_bytes: bool) -> Value {
    let encoding = if columns_are_bytes { "utf-8" } else { "utf-16" };
    json!({
        "serverInfo": { "name": "eliteserver", "version": env!("CARGO_PKG_VERSION") },
        "capabilities": {
            "positionEncoding": encoding,
            "textDocumentSync": { "openClose": true, "change": 2 },
            "hoverProvider": true,
            "completionProvider": {
                "triggerCharacters": [".", "\"", "'"],
                "resolveProvider": true,
            },
            "signatureHelpProvider": {
                "triggerCharacters": ["(", ","],
                "retriggerCharacters": [")"],
            },
            "definitionProvider": true,
            "referencesProvider": true,
            "documentHighlightProvider": true,
            "renameProvider": { "prepareProvider": true },
            "documentSymbolProvider": true,
            "workspaceSymbolProvider": true,
            "foldingRangeProvider": true,
            "semanticTokensProvider": {
                "legend": {
                    "tokenTypes": SemanticTokenKind::NAMES,
                    "tokenModifiers": ["declaration", "defaultLibrary"],
                },
                "full": true,
                "range": true,
            },
            "inlayHintProvider": true,
            "documentFormattingProvider": true,
            "codeActionProvider": { "codeActionKinds": ["quickfix"] },
            "workspace": {
                "workspaceFolders": { "supported": true, "changeNotifications": true },
            },
        },
    })
}
