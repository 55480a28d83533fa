//! Every example of the manual whose result is settled, as a script through the interpreter and the real builtins.
//!
//! Examples that need a peer (sockets, serial lines, port 30020, inputs) belong to the tests of those; the one
//! of the encoders is run as soon as they are there.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot read its input fails"
)]

use crate::common;

use common::{Standing, run};
use elite_runtime::TaskEnd;
use serde_json::Value as Json;

/// Matches that are about a peer, not about a value.
const WITH_A_PEER: [&str; 4] = [
    "wire",
    "successive calls",
    "reply on 30020",
    "io:configurable_out[1]",
];

fn examples() -> Vec<Json> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/vectors/manual_examples.json"
    );
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// What Python's `repr` wrote, as JSON: lists, numbers, truth values, plain strings, dictionaries.
fn from_repr(text: &str) -> Json {
    let mut json = String::new();
    let mut quoted = false;
    let mut word = String::new();
    for c in text.trim_end().chars().chain([' ']) {
        if !quoted && (c.is_ascii_alphanumeric() || "._+-".contains(c)) {
            word.push(c);
            continue;
        }
        json.push_str(match word.as_str() {
            "True" => "true",
            "False" => "false",
            "None" => "null",
            "nan" => "\"nan\"",
            "inf" => "\"inf\"",
            "-inf" => "\"-inf\"",
            other => other,
        });
        word.clear();
        if c == '\'' {
            quoted = !quoted;
            json.push('"');
        } else {
            json.push(c);
        }
    }
    serde_json::from_str(&json).unwrap_or_else(|e| panic!("{text}: {e}"))
}

fn assert_same(code: &str, is: &Json, should: &Json, tolerance: f64) {
    match (is, should) {
        (Json::Array(a), Json::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{code}: {is}, not {should}");
            for (a, b) in a.iter().zip(b) {
                assert_same(code, a, b, tolerance);
            }
        }
        (Json::Number(a), Json::Number(b)) => {
            let off = (a.as_f64().unwrap() - b.as_f64().unwrap()).abs();
            assert!(off <= tolerance.max(1e-15), "{code}: {is}, not {should}");
        }
        _ => assert_eq!(is, should, "{code}"),
    }
}

/// Functions that came after this test; their examples are run as soon as they are registered.
const LATER: [&str; 1] = ["encoder_unwind_delta_tick_count"];

fn is_registered(example: &Json) -> bool {
    let code = example["code"].as_str().unwrap();
    let missing = |name: &&str| !elite_runtime::builtins::all().any(|b| b.name == *name);
    !LATER
        .iter()
        .any(|name| code.contains(name) && missing(name))
}

fn check(example: &Json) {
    let code = example["code"].as_str().unwrap();
    let setup = example["setup"].as_str().unwrap_or("");
    let standing = Standing {
        model: match example["model"].as_str() {
            None | Some("CS66") => "cs66",
            Some("CS63") => "cs63",
            Some("CS612") => "cs612",
            Some("CS616") => "cs616",
            Some("CS620") => "cs620",
            Some("CS625") => "cs625",
            Some(other) => panic!("{other}"),
        },
        ..Standing::default()
    };
    let expect = &example["expect"];
    let tolerance = example["tolerance"].as_f64().unwrap();
    let evaluated = |shown: &str| {
        let ran = run(&standing, &format!("{setup}\n{shown}\n"));
        assert_eq!(ran.end, TaskEnd::Finished, "{code}: {}", ran.error);
        ran
    };
    match example["match"].as_str().unwrap() {
        "value" | "value, same order" => {
            let ran = evaluated(&format!("print(repr({code}))"));
            assert_same(code, &from_repr(&ran.printed), expect, tolerance);
        }
        "codepoints" => {
            let ran = evaluated(&format!("print(repr([ord(c) for c in {code}]))"));
            assert_same(code, &from_repr(&ran.printed), expect, tolerance);
        }
        "in range" => {
            let value = from_repr(&evaluated(&format!("print(repr({code}))")).printed);
            let (value, range) = (value.as_f64().unwrap(), expect.as_array().unwrap());
            assert!(value >= range[0].as_f64().unwrap() && value <= range[1].as_f64().unwrap());
        }
        "stdout" => assert_eq!(evaluated(code).printed, expect.as_str().unwrap(), "{code}"),
        "log messages" => {
            let wanted: Vec<&str> = expect
                .as_array()
                .unwrap()
                .iter()
                .map(|t| t.as_str().unwrap())
                .collect();
            assert_eq!(evaluated(code).log, wanted, "{code}");
        }
        "variables" => {
            for (name, wanted) in expect.as_object().unwrap() {
                // JSON has no integer keys: both sides with text keys.
                let show = format!(
                    "{code}\nif isinstance({name}, type({{}})):\n    {name} = {{str(k): v for k, v in {name}.items()}}\
                     \nprint(repr({name}))"
                );
                assert_same(
                    code,
                    &from_repr(&evaluated(&show).printed),
                    wanted,
                    tolerance,
                );
            }
        }
        "error" => {
            let ran = run(&standing, &format!("{setup}\n{code}\n"));
            assert_eq!(ran.end, TaskEnd::Failed, "{code}");
            let words = expect.as_str().unwrap().split(": ").last().unwrap();
            assert!(
                ran.error.contains(words),
                "{code}: {} has no \"{words}\"",
                ran.error
            );
        }
        other => panic!("{code}: match \"{other}\" is not known"),
    }
}

#[test]
fn every_example_of_the_manual_comes_out_of_a_script() {
    let (mut tested, mut left_out) = (0, 0);
    for example in examples() {
        let section = example["section"].as_str().unwrap();
        let chapter = section.split('.').next().unwrap();
        if WITH_A_PEER.contains(&example["match"].as_str().unwrap())
            || ["6", "7", "8"].contains(&chapter)
        {
            continue;
        }
        if is_registered(&example) {
            check(&example);
            tested += 1;
        } else {
            left_out += 1;
        }
    }
    assert!(tested >= 147, "{tested} tested, {left_out} left out");
}
