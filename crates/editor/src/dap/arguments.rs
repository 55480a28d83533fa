//! What each request has to have: names and kinds of its arguments, and a sentence about the first one that is missing
//! or of another kind. Everything behind it may rely on what is checked here.

use messages::{Text, text};
use serde_json::Value as Json;

/// What an argument can be.
enum Kind {
    /// A whole number from 0 to this one.
    Whole(u64),
    /// A text.
    Text,
    /// True or false.
    Flag,
    /// A list of texts.
    Texts,
    /// An object, whatever is in it.
    Any,
    /// An object with these fields.
    Object(&'static [Argument]),
    /// A list of such objects.
    Objects(&'static [Argument]),
}

/// An argument of a request, or a field of one.
struct Argument {
    name: &'static str,
    kind: Kind,
    is_needed: bool,
}

const fn needed(name: &'static str, kind: Kind) -> Argument {
    let is_needed = true;
    Argument {
        name,
        kind,
        is_needed,
    }
}

const fn may(name: &'static str, kind: Kind) -> Argument {
    let is_needed = false;
    Argument {
        name,
        kind,
        is_needed,
    }
}

/// Numbers that the client was given, and counts.
const NUMBER: Kind = Kind::Whole(u32::MAX as u64);
const THREAD: Argument = needed("threadId", NUMBER);
const SOURCE: Kind = Kind::Object(&[
    may("name", Kind::Text),
    may("path", Kind::Text),
    may("sourceReference", NUMBER),
]);
const PLACES: Kind = Kind::Objects(&[
    needed("line", NUMBER),
    may("column", NUMBER),
    may("condition", Kind::Text),
    may("hitCondition", Kind::Text),
    may("logMessage", Kind::Text),
]);
const FUNCTIONS: Kind = Kind::Objects(&[
    needed("name", Kind::Text),
    may("condition", Kind::Text),
    may("hitCondition", Kind::Text),
]);
const CONDITIONS: Kind = Kind::Objects(&[
    needed("dataId", Kind::Text),
    may("condition", Kind::Text),
    may("hitCondition", Kind::Text),
]);

/// The arguments of the requests that take any.
static REQUESTS: &[(&str, &[Argument])] = &[
    (
        "initialize",
        &[
            may("linesStartAt1", Kind::Flag),
            may("columnsStartAt1", Kind::Flag),
        ],
    ),
    (
        "launch",
        &[
            may("program", Kind::Text),
            may("recording", Kind::Text),
            may("stopOnEntry", Kind::Flag),
            may("stopAtEnd", Kind::Flag),
            may("noDebug", Kind::Flag),
        ],
    ),
    ("attach", &[may("drive", Kind::Flag)]),
    ("restart", &[may("arguments", Kind::Any)]),
    (
        "setBreakpoints",
        &[needed("source", SOURCE), may("breakpoints", PLACES)],
    ),
    (
        "setFunctionBreakpoints",
        &[needed("breakpoints", FUNCTIONS)],
    ),
    ("setExceptionBreakpoints", &[needed("filters", Kind::Texts)]),
    ("dataBreakpointInfo", &[needed("name", Kind::Text)]),
    ("setDataBreakpoints", &[needed("breakpoints", CONDITIONS)]),
    (
        "breakpointLocations",
        &[
            needed("source", SOURCE),
            needed("line", NUMBER),
            may("endLine", NUMBER),
        ],
    ),
    ("source", &[needed("sourceReference", NUMBER)]),
    ("continue", &[THREAD]),
    ("next", &[THREAD]),
    ("stepIn", &[THREAD]),
    ("stepOut", &[THREAD]),
    ("pause", &[THREAD]),
    ("stepBack", &[THREAD]),
    ("reverseContinue", &[THREAD]),
    ("exceptionInfo", &[THREAD]),
    ("nextNode", &[may("threadId", NUMBER)]),
    (
        "stackTrace",
        &[THREAD, may("startFrame", NUMBER), may("levels", NUMBER)],
    ),
    ("restartFrame", &[needed("frameId", NUMBER)]),
    ("scopes", &[needed("frameId", NUMBER)]),
    (
        "variables",
        &[
            needed("variablesReference", NUMBER),
            may("filter", Kind::Text),
            may("start", NUMBER),
            may("count", NUMBER),
        ],
    ),
    (
        "evaluate",
        &[
            needed("expression", Kind::Text),
            may("frameId", NUMBER),
            may("context", Kind::Text),
        ],
    ),
    (
        "setVariable",
        &[
            needed("variablesReference", NUMBER),
            needed("name", Kind::Text),
            needed("value", Kind::Text),
        ],
    ),
    (
        "setExpression",
        &[
            needed("expression", Kind::Text),
            needed("value", Kind::Text),
            may("frameId", NUMBER),
        ],
    ),
    ("gotoCycle", &[needed("cycle", Kind::Whole(u64::MAX))]),
];

/// The arguments of a request; nothing for those that take none, and for those that are not known.
fn arguments(command: &str) -> &'static [Argument] {
    let mut known = REQUESTS.iter();
    known
        .find(|(name, _)| *name == command)
        .map_or(&[], |(_, arguments)| *arguments)
}

/// Looks at the arguments of a request.
///
/// # Errors
/// A sentence that names the argument, what was given and what is allowed.
pub(super) fn check(command: &str, given: &Json) -> Result<(), Text> {
    if !given.is_object() {
        return Err(text!(
            "{command}: arguments is {}; allowed is an object",
            "{command}：arguments 为 {}；应为对象",
            shown(given)
        ));
    }
    fields(command, "", arguments(command), given)
}

fn fields(command: &str, within: &str, known: &[Argument], given: &Json) -> Result<(), Text> {
    for Argument {
        name,
        kind,
        is_needed,
    } in known
    {
        let name = format!("{within}{name}");
        let key = name.rsplit('.').next().unwrap_or_default();
        match given.get(key).filter(|value| !value.is_null()) {
            Some(value) => of_kind(command, &name, kind, value)?,
            None if *is_needed => {
                return Err(text!(
                    "{command}: {name} is missing; it is {}",
                    "{command}：缺少 {name}；应为{}",
                    allowed(kind)
                ));
            }
            None => {}
        }
    }
    Ok(())
}

fn of_kind(command: &str, name: &str, kind: &Kind, given: &Json) -> Result<(), Text> {
    let is_right = match kind {
        Kind::Whole(most) => given.as_u64().is_some_and(|number| number <= *most),
        Kind::Text => given.is_string(),
        Kind::Flag => given.is_boolean(),
        Kind::Texts => given
            .as_array()
            .is_some_and(|all| all.iter().all(Json::is_string)),
        Kind::Any => given.is_object(),
        Kind::Object(_) => given.is_object(),
        Kind::Objects(_) => given.is_array(),
    };
    if !is_right {
        return Err(text!(
            "{command}: {name} is {}; allowed is {}",
            "{command}：{name} 为 {}；应为{}",
            shown(given),
            allowed(kind)
        ));
    }
    match kind {
        Kind::Object(known) => fields(command, &format!("{name}."), known, given),
        Kind::Objects(known) => {
            let all = given.as_array().into_iter().flatten().enumerate();
            for (index, one) in all {
                let name = format!("{name}[{index}]");
                of_kind(command, &name, &Kind::Object(known), one)?;
            }
            Ok(())
        }
        _ => Ok(()),
    }
}

fn allowed(kind: &Kind) -> Text {
    match kind {
        Kind::Whole(u64::MAX) => text!("a whole number from 0", "从 0 起的整数"),
        Kind::Whole(most) => text!("a whole number from 0 to {most}", "0 到 {most} 的整数"),
        Kind::Text => text!("a text", "文本"),
        Kind::Flag => text!("true or false", "true 或 false"),
        Kind::Texts => text!("a list of texts", "文本的列表"),
        Kind::Any | Kind::Object(_) => text!("an object", "对象"),
        Kind::Objects(_) => text!("a list of objects", "对象的列表"),
    }
}

/// What was given, short enough for a sentence.
fn shown(given: &Json) -> Text {
    const SHOWN_MAX: usize = 60;
    let text = match given {
        Json::Array(_) => return text!("a list", "列表"),
        Json::Object(_) => return text!("an object", "对象"),
        other => other.to_string(),
    };
    match text.char_indices().nth(SHOWN_MAX) {
        Some((end, _)) => Text::verbatim(format!("{}…", &text[..end])),
        None => Text::verbatim(text),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::check;

    #[test]
    fn what_is_missing_or_of_another_kind_is_named() {
        for (command, given, said) in [
            (
                "scopes",
                json!({}),
                "scopes: frameId is missing; it is a whole number from 0 to 4294967295",
            ),
            (
                "next",
                json!({"threadId": "1"}),
                "next: threadId is \"1\"; allowed is a whole number from 0 to 4294967295",
            ),
            (
                "gotoCycle",
                json!({"cycle": -1}),
                "gotoCycle: cycle is -1; allowed is a whole number from 0",
            ),
            (
                "launch",
                json!({"stopOnEntry": "yes"}),
                "launch: stopOnEntry is \"yes\"; allowed is true or false",
            ),
            (
                "setExceptionBreakpoints",
                json!({"filters": [1]}),
                "setExceptionBreakpoints: filters is a list; allowed is a list of texts",
            ),
            (
                "setBreakpoints",
                json!({"source": {"path": 3}}),
                "setBreakpoints: source.path is 3; allowed is a text",
            ),
            (
                "setBreakpoints",
                json!({"source": {}, "breakpoints": [{"line": 1}, {}]}),
                "setBreakpoints: breakpoints[1].line is missing; it is a whole number from 0 to 4294967295",
            ),
            (
                "evaluate",
                json!([1]),
                "evaluate: arguments is a list; allowed is an object",
            ),
        ] {
            assert_eq!(check(command, &given).unwrap_err(), said);
        }
        assert_eq!(
            check("evaluate", &json!({"expression": "x", "frameId": null})),
            Ok(())
        );
        assert_eq!(check("dance", &json!({"threadId": "x"})), Ok(()));
    }
}
