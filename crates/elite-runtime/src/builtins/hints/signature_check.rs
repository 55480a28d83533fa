//! Calls in the text that their declaration refuses whatever the program does: arguments that are too many, missing,
//! unknown or given twice, and literals outside the declared range, in the words of the error that the call would
//! raise.
//!
//! What cannot be told for certain is left to the call: values that are worked out, types, starred arguments.

use elite_syntax::{ArgumentLiteral, CallArgument, CallHint, CallSite};
use messages::{Text, text};

use super::super::declare::{
    Builtin, Parameter, ParameterDefault, ParameterType, Range, alternatives,
};
use super::parameter;

/// What is wrong with the arguments of a call.
pub(super) fn signature_errors(builtin: &Builtin, site: &CallSite<'_>) -> Vec<CallHint> {
    let mut found = Vec::new();
    check_arity(builtin, site, &mut found);
    for (index, arg) in site.args.iter().enumerate() {
        let out_of_range = parameter(builtin, index, arg.name)
            .and_then(|parameter| outside(builtin, parameter, &arg.value));
        if let Some(message) = out_of_range {
            found.push(hint(Some(index), "out-of-range", message, None));
        }
    }
    found
}

/// Arguments that have no place, and places that have no argument.
fn check_arity(builtin: &Builtin, site: &CallSite<'_>, found: &mut Vec<CallHint>) {
    let name = builtin.name;
    let takes_any = builtin
        .params
        .iter()
        .any(|p| p.kind == ParameterType::Variadic);
    let is_by_place = |arg: &&CallArgument<'_>| arg.name.is_none();
    let by_place = site.args.iter().filter(is_by_place).count();
    let most = builtin.params.len();
    if by_place > most && !takes_any {
        let message = text!(
            "{name}() takes at most {most} arguments, got {by_place}",
            "{name}() 最多接受 {most} 个参数，给出了 {by_place} 个"
        );
        found.push(hint(Some(most), "argument-count", message, None));
        return;
    }
    let mut is_given: Vec<bool> = (0..most).map(|place| place < by_place).collect();
    for (index, arg) in site.args.iter().enumerate() {
        let Some(word) = arg.name else { continue };
        let wanted =
            parameter(builtin, index, Some(word)).filter(|p| p.kind != ParameterType::Variadic);
        let place = wanted.and_then(|p| builtin.params.iter().position(|own| own.name == p.name));
        match place {
            None => {
                let message = text!(
                    "{name}() has no parameter '{word}'",
                    "{name}() 没有参数 '{word}'"
                );
                let known: Vec<&str> = builtin.params.iter().map(|p| p.name).collect();
                let help = (!known.is_empty())
                    .then(|| text!("its parameters are {}", "它的参数有 {}", known.join(", ")));
                found.push(hint(Some(index), "unknown-argument", message, help));
            }
            Some(place) if is_given[place] => {
                let message = text!(
                    "{name}(): '{word}' is given twice",
                    "{name}()：'{word}' 给出了两次"
                );
                found.push(hint(Some(index), "argument-twice", message, None));
            }
            Some(place) => is_given[place] = true,
        }
    }
    let missing = builtin.params.iter().zip(&is_given).find(|(p, given)| {
        !**given && p.default == ParameterDefault::Required && p.kind != ParameterType::Variadic
    });
    // Where a name is wrong, that is why another is missing.
    if let Some((missing, _)) = missing
        && site.is_whole
        && found.is_empty()
    {
        let message = text!("{name}() needs '{}'", "{name}() 需要 '{}'", missing.name);
        found.push(hint(None, "missing-argument", message, None));
    }
}

/// A literal that the parameter does not take.
fn outside(builtin: &Builtin, parameter: &Parameter, value: &ArgumentLiteral<'_>) -> Option<Text> {
    let place = text!("{}(): {}", "{}()：{}", builtin.name, parameter.name);
    let (allowed, given) = match (parameter.kind, value) {
        (ParameterType::Number(range), ArgumentLiteral::Integer(n))
            if !range.contains(*n as f64) =>
        {
            (Text::of(&range), n.to_string())
        }
        (ParameterType::Number(range), ArgumentLiteral::Number(x)) if !range.contains(*x) => {
            (Text::of(&range), format!("{x:?}"))
        }
        (ParameterType::Number(range @ Range::Any), ArgumentLiteral::Number(x))
            if !x.is_finite() =>
        {
            (Text::of(&range), format!("{x:?}"))
        }
        (ParameterType::Integer(min, max), ArgumentLiteral::Integer(n))
            if !(min..=max).contains(n) =>
        {
            let allowed = match max {
                i64::MAX => text!("at least {min}", "至少 {min}"),
                _ => text!("{min} to {max}", "{min} 到 {max}"),
            };
            (allowed, n.to_string())
        }
        (ParameterType::OneOf(allowed), ArgumentLiteral::Integer(n)) if !allowed.contains(n) => {
            (alternatives(allowed), n.to_string())
        }
        (ParameterType::Word(words), ArgumentLiteral::Text(text)) if !words.contains(text) => {
            let text: String = text.chars().take(60).collect();
            (alternatives(words), format!("{text:?}"))
        }
        (ParameterType::Joints, ArgumentLiteral::List(items)) => {
            let words = text!("six joint positions in rad", "六个关节位置（rad）");
            return count(&place, &words, 6, items);
        }
        (ParameterType::Pose, ArgumentLiteral::List(items)) => {
            let words = text!(
                "a pose [x, y, z, Rx, Ry, Rz] in m and rad",
                "位姿 [x, y, z, Rx, Ry, Rz]（m 和 rad）"
            );
            return count(&place, &words, 6, items);
        }
        (ParameterType::Numbers(wanted), ArgumentLiteral::List(items)) => {
            let words = text!("a list of {wanted} numbers", "{wanted} 个数的列表");
            return count(&place, &words, wanted, items);
        }
        _ => return None,
    };
    Some(text!(
        "{place} must be {allowed}, got {given}",
        "{place} 必须是{allowed}，给出的是 {given}"
    ))
}

/// A list of numbers that are more or fewer than wanted.
fn count(place: &Text, words: &Text, wanted: usize, items: &[ArgumentLiteral<'_>]) -> Option<Text> {
    let given = items.len();
    (given != wanted).then(|| {
        text!(
            "{place} must be {words}, got {given} numbers",
            "{place} 必须是{words}，给出了 {given} 个数"
        )
    })
}

fn hint(
    argument: Option<usize>,
    code: &'static str,
    message: Text,
    help: Option<Text>,
) -> CallHint {
    CallHint {
        argument,
        code,
        message,
        help,
    }
}
