//! Findings as the protocol's diagnostics.

use elite_syntax::{Diagnostic, Severity};
use serde_json::{Value, json};

use super::documents::Document;
use super::positions::Encoding;
use crate::analysis::words::Language;

/// The parameters of `textDocument/publishDiagnostics`.
pub fn of(document: &mut Document, encoding: Encoding, language: Language) -> Value {
    let analysis = document.analysis();
    let findings = analysis.findings().iter();
    let all: Vec<Value> = findings
        .map(|f| diagnostic(document, f, encoding, language))
        .collect();
    json!({ "uri": document.uri, "version": document.version, "diagnostics": all })
}

/// One finding.
pub fn diagnostic(
    document: &Document,
    finding: &Diagnostic,
    encoding: Encoding,
    language: Language,
) -> Value {
    let severity = match finding.severity {
        Severity::Error => 1,
        Severity::Warning => 2,
    };
    let mut message = finding.message.in_language(language).to_owned();
    if let Some(help) = &finding.help {
        message = format!("{message}\n{}", help.in_language(language));
    }
    let related: Vec<Value> = finding
        .labels
        .iter()
        .map(|label| {
            let range = document.range(label.span, encoding);
            json!({
                "location": { "uri": document.uri, "range": range },
                "message": label.text.in_language(language),
            })
        })
        .collect();
    let mut told = json!({
        "range": document.range(finding.span, encoding),
        "severity": severity,
        "code": finding.code,
        "source": "eliteserver",
        "message": message,
    });
    if !related.is_empty() {
        told["relatedInformation"] = Value::Array(related);
    }
    // 1: editors show it faded.
    if matches!(
        finding.code,
        "unused-variable" | "unused-import" | "unreachable"
    ) {
        told["tags"] = json!([1]);
    }
    told
}
