//! `eliteserver builtins`: every registered builtin, from its declaration.

use std::fmt::Write;

use elite_runtime::builtins::all;
use elite_runtime::builtins::declare::{Builtin, FROM_OUTPUT};
use messages::{Text, text};
use serde_json::{Value, json};

use editor::analysis::describe;
use editor::analysis::library::searched_text;
use editor::analysis::words::Language;
use elite_syntax::nearest;

use crate::cli::{BuiltinsArgs, ListFormat};
use crate::command::CommandStatus;
use crate::language;

/// Pages of the reference (`cargo dev reference`), by the group of functions.
const REFERENCE: &[(&str, &str)] = &[
    (
        "interpreter",
        include_str!("../../../../docs/reference/interpreter.md"),
    ),
    (
        "motion",
        include_str!("../../../../docs/reference/motion.md"),
    ),
    ("math", include_str!("../../../../docs/reference/math.md")),
    ("force", include_str!("../../../../docs/reference/force.md")),
    ("io", include_str!("../../../../docs/reference/io.md")),
    (
        "register",
        include_str!("../../../../docs/reference/register.md"),
    ),
    (
        "modbus",
        include_str!("../../../../docs/reference/modbus.md"),
    ),
    (
        "socket",
        include_str!("../../../../docs/reference/socket.md"),
    ),
    ("rpc", include_str!("../../../../docs/reference/rpc.md")),
    (
        "serial",
        include_str!("../../../../docs/reference/serial.md"),
    ),
    (
        "modbus_rtu",
        include_str!("../../../../docs/reference/modbus_rtu.md"),
    ),
    (
        "thread",
        include_str!("../../../../docs/reference/thread.md"),
    ),
    (
        "system",
        include_str!("../../../../docs/reference/system.md"),
    ),
    (
        "string",
        include_str!("../../../../docs/reference/string.md"),
    ),
    ("other", include_str!("../../../../docs/reference/other.md")),
];

/// The list, one function or the answer to a search, as text.
pub fn builtins(args: &BuiltinsArgs) -> (String, CommandStatus) {
    let mut shown: Vec<&Builtin> = all().collect();
    shown.sort_by_key(|b| (section_order(b.section), b.name));
    if args.words.is_empty() {
        return (list(&shown, args.format), CommandStatus::Success);
    }
    let asked = args.words.join(" ");
    let one = shown.iter().find(|builtin| {
        let name = asked.trim().trim_end_matches("()");
        builtin.name.eq_ignore_ascii_case(name)
    });
    if let Some(one) = one {
        let text = match args.format {
            ListFormat::Table => description(one, language::chosen()),
            ListFormat::Json => format!("{:#}\n", row(one)),
        };
        return (text, CommandStatus::Success);
    }
    shown.retain(|builtin| has_words(builtin, &asked));
    if shown.is_empty() {
        let near = nearest(asked.trim(), all().map(|builtin| builtin.name));
        return (not_found(&asked, near.as_deref()), CommandStatus::Negative);
    }
    (list(&shown, args.format), CommandStatus::Success)
}

/// Whether all words are in what is said of a function, in either language.
fn has_words(builtin: &Builtin, words: &str) -> bool {
    let text = searched_text(builtin);
    words
        .split_whitespace()
        .all(|word| text.contains(&word.to_lowercase()))
}

fn not_found(asked: &str, near: Option<&str>) -> String {
    let asked: String = asked.chars().take(80).collect();
    let hint = match near {
        Some(near) => text!("; did you mean {near}?", "；是不是 {near}？"),
        None => Text::verbatim(""),
    };
    let said = text!(
        "no function has {asked:?} in its name or description{hint}",
        "没有名称或说明中包含 {asked:?} 的函数{hint}"
    );
    format!("{}\n", language::shown(&said))
}

/// A function as the reference describes it, for a terminal.
fn description(builtin: &Builtin, language: Language) -> String {
    let mut out = format!(
        "{}\n\n  {}\n",
        builtin.signature(),
        builtin.summary.in_language(language)
    );
    let width = builtin
        .params
        .iter()
        .map(|p| p.name.len())
        .max()
        .unwrap_or(0);
    if !builtin.params.is_empty() {
        out.push_str(&format!("\n{}\n", language.pick("Parameters", "参数")));
    }
    for parameter in builtin.params {
        let told = describe::of_parameter(parameter, language);
        let _ = writeln!(out, "  {:<width$}  {told}", parameter.name);
    }
    let returns = language.pick("Returns", "返回值");
    let _ = writeln!(
        out,
        "\n{returns}\n  {}",
        builtin.returns.in_language(language)
    );
    if builtin.waits {
        let waits = language.pick("The call waits until it is done.", "调用会等待到完成。");
        let _ = writeln!(out, "  {waits}");
    }
    let source = match builtin.section {
        FROM_OUTPUT => language
            .pick(FROM_OUTPUT, "来自控制器输出，手册中没有")
            .to_owned(),
        section => format!("{} {section}", language.pick("Manual", "手册")),
    };
    let _ = writeln!(out, "\n{source}");
    if let Some(example) = example(builtin) {
        let title = language.pick("Example", "示例");
        let _ = writeln!(out, "\n{title}");
        for line in example.lines() {
            let _ = writeln!(out, "  {line}");
        }
    }
    out
}

/// The example of the reference, which is a test that is run.
fn example(builtin: &Builtin) -> Option<&'static str> {
    let group = builtin.category.name();
    let (_, page) = REFERENCE.iter().find(|(name, _)| *name == group)?;
    let (_, section) = page.split_once(&format!("\n## {}\n", builtin.name))?;
    let section = section.split("\n## ").next()?;
    let (_, code) = section.split_once("```python\n")?;
    code.split("\n```").next()
}

fn list(builtins: &[&Builtin], format: ListFormat) -> String {
    match format {
        ListFormat::Table => table(builtins, language::chosen()),
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

fn table(builtins: &[&Builtin], language: Language) -> String {
    let mut out = String::new();
    let width = builtins
        .iter()
        .map(|b| b.signature().chars().count())
        .max()
        .unwrap_or(0);
    for b in builtins {
        // What has no section tells its source at the end.
        let (section, source) = match b.section {
            FROM_OUTPUT => (
                "-",
                language.pick(
                    " (from controller output, not from the manual)",
                    "（来自控制器输出，手册中没有）",
                ),
            ),
            section => (section, ""),
        };
        // Writing to a String cannot fail.
        let _ = writeln!(
            out,
            "{section:<8} {:<10} {:<width$}  {}{source}",
            b.category.name(),
            b.signature(),
            b.summary.in_language(language)
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
                "meaning": p.meaning.english(),
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
        "summary": b.summary.english(),
        "params": params,
        "returns": b.returns.english(),
        "waits": b.waits,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_function_has_its_example_from_the_reference() {
        for builtin in all() {
            let example = example(builtin);
            assert!(
                example.is_some_and(|code| !code.trim().is_empty()),
                "{}",
                builtin.name
            );
        }
    }

    fn asked(words: &str) -> (String, CommandStatus) {
        let words = words.split_whitespace().map(str::to_owned).collect();
        builtins(&BuiltinsArgs {
            words,
            format: ListFormat::Table,
            log: crate::cli::LogArgs::default(),
        })
    }

    #[test]
    fn a_name_shows_one_function_and_words_search() {
        let (text, status) = asked("movej");
        assert_eq!(status, CommandStatus::Success);
        for part in [
            "movej(q, ",
            "Parameters\n",
            "target joint positions",
            "Manual 3.1.1",
            "Example\n",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
        assert_eq!(asked("MoveJ()").0, text);
        let (text, _) = asked("blend radius");
        assert!(
            text.contains("movel(") && !text.contains("socket_open"),
            "{text}"
        );
        let (text, _) = asked("直线");
        assert!(text.contains("movel("), "{text}");
        let (text, status) = asked("movjj");
        assert_eq!(status, CommandStatus::Negative);
        assert!(text.contains("did you mean movej?"), "{text}");
    }
}
