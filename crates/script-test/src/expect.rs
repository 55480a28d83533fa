//! What a test expects, as functions of `test`: values that are near, exceptions, ways, conditions over the whole test,
//! peaks, distances.

use elite_lang::{ExceptionKind, NativeCall, Unwind, Value};
use messages::{Text, text};

use crate::golden_path;
use crate::near::near;
use crate::test_context::{Invariant, InvariantCheck};
use crate::test_object::{
    CallContext, argument_error, failed, normalized_path, number, raise, text,
};

type NativeResult<T = Value> = Result<T, Unwind>;

pub(crate) fn is_near(_: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let tolerance = number(call, 2, "tolerance", (0.0, f64::MAX), Some(1e-6))?;
    let arg = |index| call.arg(index).cloned().unwrap_or_default();
    let (a, b) = (arg(0), arg(1));
    match near(&a, &b, tolerance) {
        Ok(()) => Ok(Value::Bool(true)),
        Err(difference) => {
            let (a, b) = (call.repr(&a)?, call.repr(&b)?);
            let text = text!(
                "{a} is not within {tolerance} of {b}: {difference}",
                "{a} 与 {b} 的差不在 {tolerance} 以内：{difference}"
            );
            Err(failed(call, &text))
        }
    }
}

pub(crate) fn raises(_: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let wanted = match call.arg(0) {
        // The class itself is as good as its name.
        Some(class) if class.is_callable() => {
            let shown = call.repr(class)?;
            let name = shown.trim_start_matches("<class '").trim_end_matches("'>");
            name.to_owned()
        }
        _ => text(call, 0, "type_name")?,
    };
    let function = call.arg(1).cloned().unwrap_or_default();
    if !function.is_callable() {
        let text = text!(
            "function must be callable, not {}",
            "function 必须可调用，不能是 {}",
            function.type_name()
        );
        return Err(raise(call, ExceptionKind::TypeError, &text));
    }
    match call.call_value(&function, &[]) {
        Ok(value) => {
            let shown = call.repr(&value)?;
            let text = text!(
                "{wanted} was expected, but nothing was raised: the value is {shown}",
                "应引发 {wanted}，却没有引发异常：值为 {shown}"
            );
            Err(failed(call, &text))
        }
        Err(Unwind::Stop) => Err(Unwind::Stop),
        Err(raised) => match call.ancestors(&raised) {
            names if names.contains(&wanted) => Ok(Value::Bool(true)),
            _ => {
                let report = call.report(&raised);
                let met = report.map_or(Text::fixed("", ""), |error| error.headline());
                let text = text!(
                    "{wanted} was expected, but this was raised: {met}",
                    "应引发 {wanted}，却引发了：{met}"
                );
                Err(failed(call, &text))
            }
        },
    }
}

pub(crate) fn path_near(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let file = site.bench.folder.join(text(call, 0, "golden_csv")?);
    let tolerance = number(call, 1, "tolerance", (0.0, f64::MAX), Some(1e-3))?;
    let places = site.bench.trace.tcp_path();
    let file = (&site.bench.files, &*normalized_path(&file));
    let checked = golden_path::check(&places, file, tolerance, site.bench.goldens);
    match checked {
        Ok(()) => Ok(Value::Bool(true)),
        Err(error) => Err(failed(call, &Text::of(&error))),
    }
}

pub(crate) fn never(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    watch(site, call, false)
}

pub(crate) fn always(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    watch(site, call, true)
}

fn watch(site: &CallContext, call: &mut NativeCall<'_>, always: bool) -> NativeResult {
    let watched = Invariant {
        text: text(call, 0, "condition")?,
        always,
        line: call.line(),
    };
    match site.bench.watch(watched) {
        InvariantCheck::Kept => Ok(Value::None),
        InvariantCheck::Broken(sentence) => Err(failed(call, &sentence)),
        InvariantCheck::NoCondition(sentence) => Err(argument_error(call, &sentence)),
    }
}

pub(crate) fn clearance(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let Some(observer) = &site.bench.clearance else {
        return Err(failed(
            call,
            &text!(
                "distances are measured in tests whose file names test.clearance()",
                "只有文件中出现 test.clearance() 的测试才测量间隙"
            ),
        ));
    };
    let Some((least, line)) = observer.least() else {
        return Err(failed(
            call,
            &text!(
                "nothing has moved yet, or there is nothing that could be touched",
                "还没有运动，或没有可能碰到的物体"
            ),
        ));
    };
    Ok(call.object(
        "clearance",
        Vec::new(),
        vec![
            ("distance", Value::Float(least.distance)),
            ("a", Value::str(least.a.english())),
            ("b", Value::str(least.b.english())),
            ("line", Value::Int(line.into())),
            ("time", Value::Float(least.time)),
        ],
    ))
}

pub(crate) fn peak(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let name = text(call, 0, "name")?;
    let value = site.bench.trace.peaks().by_name(&name);
    value
        .map(Value::Float)
        .map_err(|sentence| argument_error(call, &sentence))
}
