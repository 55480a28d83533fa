//! `eliteserver builtins`: every registered builtin, from its declaration.

use std::fmt::Write;

use elite_runtime::builtins::{all, declare::Builtin};
use serde_json::{Value, json};

use crate::cli::ListFormat;

/// The list as text.
pub fn list(format: ListFormat) -> String {
    let mut builtins: Vec<&Builtin> = all().collect();
    builtins.sort_by_key(|b| (section_order(b.section), b.name));
    match format {
        ListFormat::Table => table(&builtins),
        ListFormat::Json => {
            let rows: Vec<Value> = builtins.iter().map(|b| row(b)).collect();
            // Values made of text and numbers only always print.
            format!("{:#}\n", Value::Array(rows))
        }
    }
}

/// `3.1.20` after `3.1.4`.
fn section_order(section: &str) -> Vec<u32> {
    section.split('.').map(|part| part.parse().unwrap_or(u32::MAX)).collect()
}

fn table(builtins: &[&Builtin]) -> String {
    let mut out = String::new();
    let width = builtins.iter().map(|b| b.signature().chars().count()).max().unwrap_or(0);
    for b in builtins {
        // Writing to a String cannot fail.
        let _ = writeln!(out, "{:<8} {:<10} {:<width$}  {}", b.section, b.category.name(), b.signature(), b.summary);
    }
    out
}

fn row(b: &Builtin) -> Value {
    let params: Vec<Value> = b
        .params
        .iter()
        .map(|p| {
            json!({
                "name": p.name,
                "aliases": p.aliases,
                "type": p.kind.type_name(),
                "range": p.kind.range_text(),
                "unit": p.unit,
                "written": p.to_string(),
                "meaning": p.meaning,
            })
        })
        .collect();
    json!({
        "name": b.name,
        "signature": b.signature(),
        "section": b.section,
        "category": b.category.name(),
        "summary": b.summary,
        "params": params,
        "returns": b.returns,
        "waits": b.waits,
    })
}
