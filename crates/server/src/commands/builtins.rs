//! `eliteserver builtins`: every registered builtin, from its declaration.

use std::fmt::Write;

use elite_runtime::builtins::all;
use elite_runtime::builtins::declare::{Builtin, FROM_OUTPUT};
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
    section
        .split('.')
        .map(|part| part.parse().unwrap_or(u32::MAX))
        .collect()
}

fn table(builtins: &[&Builtin]) -> String {
    let mut out = String::new();
    let width = builtins
        .iter()
        .map(|b| b.signature().chars().count())
        .max()
        .unwrap_or(0);
    for b in builtins {
        // What has no section tells its source at the end.
        let (section, source) = match b.section {
            FROM_OUTPUT => ("-", format!(" ({FROM_OUTPUT})")),
            section => (section, String::new()),
        };
        // Writing to a String cannot fail.
        let _ = writeln!(
            out,
            "{section:<8} {:<10} {:<width$}  {}{source}",
            b.category.name(),
            b.signature(),
            b.summary
        );
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
        "source": match b.section {
            FROM_OUTPUT => FROM_OUTPUT.to_owned(),
            section => format!("manual {section}"),
        },
        "category": b.category.name(),
        "summary": b.summary,
        "params": params,
        "returns": b.returns,
        "waits": b.waits,
    })
}
