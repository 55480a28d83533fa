//! What is wrong with the options of a `launch`, in the words of the request: its keys are the options of `run` without
//! dashes.

use std::error::Error as _;

use clap::error::{ContextKind, ContextValue, ErrorKind};

/// A sentence about a command line that was made from a request.
pub(super) fn of_request(error: &clap::Error) -> String {
    let context = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.clone()),
        Some(ContextValue::Strings(texts)) => texts.first().cloned(),
        _ => None,
    };
    let Some(key) = context(ContextKind::InvalidArg).map(|option| key_of(&option)) else {
        return first_line(error);
    };
    match error.kind() {
        ErrorKind::UnknownArgument => {
            let near = context(ContextKind::SuggestedArg).map(|option| key_of(&option));
            let near = near.map_or_else(String::new, |near| format!(", but {near}"));
            format!(
                "launch knows no key {key}{near}; there are the options of run, without their dashes"
            )
        }
        ErrorKind::InvalidValue | ErrorKind::ValueValidation => {
            let value = context(ContextKind::InvalidValue).unwrap_or_default();
            let why = match error.source() {
                Some(reason) => reason.to_string(),
                None => match error.get(ContextKind::ValidValue) {
                    Some(ContextValue::Strings(valid)) => {
                        format!("allowed are {}", valid.join(", "))
                    }
                    _ => "it is not taken".to_owned(),
                },
            };
            format!("{key} is '{value}': {why}")
        }
        ErrorKind::TooManyValues | ErrorKind::WrongNumberOfValues => {
            format!("{key} takes no value")
        }
        ErrorKind::ArgumentConflict => format!("{key} is given twice, or beside what it excludes"),
        _ => first_line(error),
    }
}

/// `--step-ms <MS>` as the request names it.
fn key_of(option: &str) -> String {
    let name = option.trim_start_matches('-');
    let end = name.find([' ', '=', '<']).unwrap_or(name.len());
    name[..end].to_owned()
}

fn first_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let first = text.lines().next().unwrap_or_default();
    first.trim_start_matches("error: ").to_owned()
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;
    use crate::cli::Cli;

    #[test]
    fn keys_are_named_as_the_request_has_them() {
        let said = |option: &str| {
            let line = ["eliteserver", "run", option, "--", "p.script"];
            of_request(&Cli::try_parse_from(line).unwrap_err())
        };
        let unknown = said("--nonsens=1");
        assert!(
            unknown.starts_with("launch knows no key nonsens;"),
            "{unknown}"
        );
        let near = said("--modle=cs66");
        assert!(
            near.starts_with("launch knows no key modle, but model;"),
            "{near}"
        );
        let value = said("--step-ms=9");
        assert!(value.starts_with("step-ms is '9': "), "{value}");
        let choice = said("--clock=sundial");
        assert!(
            choice.contains("clock is 'sundial': ") && choice.contains("virtual"),
            "{choice}"
        );
        for text in [unknown, near, value, choice] {
            assert!(!text.contains("--"), "{text}");
        }
    }
}
