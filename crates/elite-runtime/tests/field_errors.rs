//! Every parameter of every function of chapters 5 to 8 with values that do not fit: the exception names the function,
//! the argument, what was given and what is allowed.
//!
//! `tests/vectors/field_functions.json` holds names, types and ranges as the manual prints them, so that the
//! declarations in the code are checked against the manual and not against themselves. The texts are golden.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot read its input fails"
)]

use crate::common;

use std::fmt::Write as _;

use common::{Standing, run};
use serde_json::Value as Json;

/// What the script does first: signals and ports that the calls refer to. Nothing listens there.
const PREPARE: &str = r#"
modbus_add_signal("127.0.0.1", 255, 0, 3, "x", False, 2, 1)
"#;

/// Values outside the range that the manual takes all the same, and what becomes of them.
const TAKEN: [(&str, &str, &str); 4] = [
    (
        "set_standard_analog_out",
        "f",
        "5.12: above 1 is 1, below 0 is 0",
    ),
    (
        "modbus_set_output_register",
        "register_value",
        "6.1.6: cut to 16 bits",
    ),
    (
        "tool_modbus_write_single_bit",
        "data",
        "8.2.5: an integer; as 8.2.6, any but 0 is True",
    ),
    (
        "masterboard_modbus_rtu_write_single_bit",
        "data",
        "8.2.13: an integer; as 8.2.14, any but 0 is True",
    ),
];

/// A call with one argument that does not fit.
struct Case {
    function: String,
    parameter: String,
    /// The call as the script writes it.
    call: String,
    /// What the message must contain beside the names.
    words: Vec<String>,
    error: &'static str,
}

fn functions() -> Vec<Json> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/vectors/field_functions.json"
    );
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn text<'a>(json: &'a Json, key: &str) -> &'a str {
    json[key].as_str().unwrap_or_default()
}

/// An argument that fits, as the script writes it.
fn good(parameter: &Json) -> String {
    if let Some(first) = parameter["one_of"].get(0) {
        return first.to_string();
    }
    if let Some(first) = parameter["words"].get(0) {
        return first.to_string();
    }
    if let Some(lowest) = parameter["interval"].get(0) {
        return lowest.as_i64().unwrap().max(0).to_string();
    }
    let kind = text(parameter, "type");
    match kind {
        "bool" => "True",
        "int" => "1",
        "float" => "0.5",
        "str" => "\"x\"",
        _ if kind.contains("list") => "[1]",
        _ => "1",
    }
    .to_owned()
}

/// Arguments that do not fit, what must be said about them, and as what.
fn bad(parameter: &Json) -> Vec<(String, Vec<String>, &'static str)> {
    let mut cases = Vec::new();
    if let Some(interval) = parameter["interval"].as_array() {
        let ends: Vec<Option<i64>> = interval.iter().map(Json::as_i64).collect();
        let words = || {
            ends.iter()
                .flatten()
                .map(i64::to_string)
                .collect::<Vec<_>>()
        };
        let outside = [
            ends[0].map(|lowest| lowest - 1),
            ends[1].map(|highest| highest + 1),
        ];
        for value in outside.into_iter().flatten() {
            let value = value.to_string();
            let words = [words(), vec![format!("got {value}")]].concat();
            cases.push((value, words, "ValueError"));
        }
    }
    if let Some(items) = parameter["one_of"].as_array() {
        let words: Vec<String> = items.iter().map(Json::to_string).collect();
        let words = [words, vec!["got 3".to_owned()]].concat();
        cases.push(("3".to_owned(), words, "ValueError"));
    }
    if let Some(items) = parameter["words"].as_array() {
        let words: Vec<String> = items.iter().map(Json::to_string).collect();
        let words = [words, vec!["got \"nonsense\"".to_owned()]].concat();
        cases.push(("\"nonsense\"".to_owned(), words, "ValueError"));
    }
    if let Some(interval) = parameter["item_interval"].as_array() {
        let highest = interval[1].as_i64().unwrap();
        for value in [-1, highest + 1].map(|n| n.to_string()) {
            let words = vec!["0".to_owned(), highest.to_string(), format!("got {value}")];
            cases.push((format!("[{value}]"), words, "ValueError"));
        }
    }
    let wrong_type = match text(parameter, "type") {
        "bool" => Some(("\"x\"", "'x'")),
        "int" | "float" => Some(("\"1\"", "'1'")),
        "str" => Some(("5", "5")),
        kind if kind.contains("list[int]") && !kind.contains("str") => Some(("\"x\"", "'x'")),
        _ => None,
    };
    if let Some((value, shown)) = wrong_type {
        let shown = format!("({shown})");
        cases.push((value.to_owned(), vec![shown], "TypeError"));
    }
    cases
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for function in functions() {
        let name = text(&function, "name");
        let parameters = function["params"].as_array().unwrap();
        for (k, parameter) in parameters.iter().enumerate() {
            for (value, words, error) in bad(parameter) {
                let arguments: Vec<String> = parameters[..k]
                    .iter()
                    .map(good)
                    .chain([value])
                    .chain(
                        parameters[k + 1..]
                            .iter()
                            .filter(|p| p["optional"] != true)
                            .map(|p| format!("{}={}", text(p, "name"), good(p))),
                    )
                    .collect();
                cases.push(Case {
                    function: name.to_owned(),
                    parameter: text(parameter, "name").to_owned(),
                    call: format!("{name}({})", arguments.join(", ")),
                    words,
                    error,
                });
            }
        }
    }
    cases
}

#[test]
fn every_argument_that_does_not_fit_is_named_with_what_was_given_and_what_is_allowed() {
    let cases = cases();
    let mut script = format!("def probe():{}", PREPARE.replace('\n', "\n "));
    for (k, case) in cases.iter().enumerate() {
        let call = &case.call;
        write!(
            script,
            "\n try:\n  {call}\n  print(\"{k}|nothing was raised|\")\n except Exception as e:\
             \n  print(\"{k}|\" + type(e).__name__ + \"|\" + str(e))"
        )
        .unwrap();
    }
    script.push_str("\nend\n");
    let ran = run(&Standing::default(), &script);
    assert!(ran.error.is_empty(), "{}", ran.error);
    let mut golden = String::new();
    let mut wrong = Vec::new();
    let mut lines = ran.printed.lines();
    for (k, case) in cases.iter().enumerate() {
        let line = lines.next().unwrap_or_default();
        let answer = line.strip_prefix(&format!("{k}|")).unwrap_or(line);
        let (error, message) = answer.split_once('|').unwrap_or((answer, ""));
        let names = format!("{}(): {}", case.function, case.parameter);
        let is_taken = TAKEN.iter().any(|(function, parameter, _)| {
            case.error == "ValueError"
                && (*function, *parameter) == (&case.function, &case.parameter)
        });
        if is_taken {
            assert_eq!(error, "nothing was raised", "{}: {message}", case.call);
            continue;
        }
        let is_good = error == case.error
            && message.starts_with(&names)
            && case.words.iter().all(|word| message.contains(word));
        if !is_good {
            wrong.push(format!(
                "{}\n    {error}: {message}\n    wanted {}: {names} … {:?}",
                case.call, case.error, case.words
            ));
        }
        writeln!(golden, "{}\n    {error}: {message}", case.call).unwrap();
    }
    assert!(
        wrong.is_empty(),
        "{} of {}:\n{}",
        wrong.len(),
        cases.len(),
        wrong.join("\n")
    );
    insta::assert_snapshot!(golden);
}
