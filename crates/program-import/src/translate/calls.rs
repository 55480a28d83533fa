//! Calls: of the program's own functions, of those of Universal Robots by the table, of methods.

use messages::{Text, text};

use super::Translator;
use super::analysis::{LIST_METHODS, is_motion};
use super::expressions::{Form, without_parens};
use super::functions::{Parameter, UrFunction, function, split_list};
use super::helpers::HELPERS;
use super::kinds::Kinds;
use super::messages::MessageKind;
use super::scopes::ScopeId;
use crate::urscript::ast::{Argument, Expr, ExprKind};

impl Translator<'_> {
    pub(super) fn call(
        &mut self,
        callee: &Expr,
        args: &[Argument],
        line: u32,
        scope: ScopeId,
        form: Form,
    ) -> String {
        match &callee.kind {
            ExprKind::Name(name) => self.named_call(name, args, line, scope, form),
            ExprKind::Field(base, method) => self.method_call(base, method, args, line, scope),
            _ => {
                let callee = self.emit(callee, scope, Form::Value).0;
                let args = self.plain_arguments(args, line, scope);
                format!("{callee}({args})")
            }
        }
    }

    fn named_call(
        &mut self,
        name: &str,
        args: &[Argument],
        line: u32,
        scope: ScopeId,
        form: Form,
    ) -> String {
        if let Some(callee) = self.analysis.scopes.named(name) {
            let args: Vec<String> = args
                .iter()
                .enumerate()
                .map(|(index, arg)| {
                    let is_changed =
                        self.analysis
                            .is_mutated_param(callee, index, arg.name.as_deref());
                    let value = self.stored(&arg.value, scope, is_changed);
                    self.keyed(arg.name.as_deref(), value, line)
                })
                .collect();
            let name = self.name(name, line);
            return format!("{name}({})", args.join(", "));
        }
        if self.analysis.scopes.symbol(scope, name).is_some() {
            let args = self.plain_arguments(args, line, scope);
            let name = self.name(name, line);
            return format!("{name}({args})");
        }
        match name {
            "struct" => {
                let args = self.plain_arguments(args, line, scope);
                return format!("Struct({args})");
            }
            "inv" if args.len() == 1 => {
                let kind = self.analysis.infer(&args[0].value, scope);
                let value = self.value(&args[0].value, scope);
                let (helper, is_pose) = match (kind.is_pose(), kind.is_list()) {
                    (true, _) => ("pose_inv", true),
                    (_, true) => ("inverse_matrix", false),
                    _ => ("inverse_of", false),
                };
                let message = match is_pose {
                    true => MessageKind::Renamed,
                    false => MessageKind::Helper,
                };
                self.say(
                    line,
                    message,
                    name,
                    text!("is {helper} here", "这里是 {helper}"),
                );
                let call = format!("{helper}({value})");
                return match is_pose && self.analysis.has_pose_objects && form == Form::Value {
                    true => format!("pose_object({call})"),
                    false => call,
                };
            }
            _ => {}
        }
        let Some(row) = function(name) else {
            return self.missing(
                line,
                name,
                text!(
                    "neither this text nor the manual of Universal Robots defines it",
                    "此文本和 Universal Robots 的手册都没有定义它"
                ),
            );
        };
        let call = self.table_call(row, args, line, scope);
        match row.result().is_pose() && self.analysis.has_pose_objects && form == Form::Value {
            true => format!("pose_object({call})"),
            false => call,
        }
    }

    fn plain_arguments(&mut self, args: &[Argument], line: u32, scope: ScopeId) -> String {
        let args: Vec<String> = args
            .iter()
            .map(|arg| {
                let value = self.item(&arg.value, scope);
                self.keyed(arg.name.as_deref(), value, line)
            })
            .collect();
        args.join(", ")
    }

    fn keyed(&mut self, name: Option<&str>, value: String, line: u32) -> String {
        match name {
            Some(name) => format!("{}={value}", self.name(name, line)),
            None => value,
        }
    }

    fn method_call(
        &mut self,
        base: &Expr,
        method: &str,
        args: &[Argument],
        line: u32,
        scope: ScopeId,
    ) -> String {
        let kind = self.analysis.infer(base, scope);
        let is_list = LIST_METHODS.contains(&method) && !kind.own.has(Kinds::HANDLE);
        let object = self.operand(base, scope, Form::Value, 9);
        if !is_list {
            let args: Vec<String> = args
                .iter()
                .map(|arg| {
                    let value = self.value(&arg.value, scope);
                    match self.analysis.infer(&arg.value, scope).is_pose() {
                        true => format!("rpc_pose({value})"),
                        false => value,
                    }
                })
                .collect();
            let call = format!("{object}.{method}({})", args.join(", "));
            return match self.analysis.has_pose_objects {
                true => format!("rpc_object({call})"),
                false => format!("rpc_result({call})"),
            };
        }
        let values: Vec<String> = args
            .iter()
            .map(|arg| self.item(&arg.value, scope))
            .collect();
        let values_text = values.join(", ");
        match (method, &values[..]) {
            ("length", []) => format!("len({object})"),
            ("to_string", []) => format!("to_str({object})"),
            ("remove", [_]) => {
                self.say(
                    line,
                    MessageKind::Renamed,
                    method,
                    text!(
                        "takes an index there and is pop here",
                        "在那里用下标，这里是 pop"
                    ),
                );
                format!("{object}.pop({values_text})")
            }
            ("slice", [from, to]) => format!("{object}[{from}:{to}]"),
            ("capacity", _) => self.missing(
                line,
                method,
                text!("lists grow without a capacity", "列表自动增长，没有容量"),
            ),
            _ => format!("{object}.{method}({values_text})"),
        }
    }

    /// A call of a function of Universal Robots.
    fn table_call(
        &mut self,
        row: &'static UrFunction,
        args: &[Argument],
        line: u32,
        scope: ScopeId,
    ) -> String {
        let (name, params) = (row.name(), row.parameters());
        if row.call == "!" {
            return self.missing(line, name, row.note.clone());
        }
        let mut given: Vec<Option<String>> = vec![None; params.len()];
        let mut written = Vec::new();
        for (index, arg) in args.iter().enumerate() {
            let place = match &arg.name {
                Some(key) => params
                    .iter()
                    .position(|param| param.name.eq_ignore_ascii_case(key)),
                None => (index < params.len()).then_some(index),
            };
            let Some(place) = place else {
                let shown = arg.name.clone().unwrap_or_else(|| format!("{}", index + 1));
                let signature = row.signature.replace([':', '!'], "");
                let text = text!(
                    "the argument {shown} is left out: {signature} has none of that name or number",
                    "略去参数 {shown}：{signature} 没有此名称或序号的参数"
                );
                self.say(line, MessageKind::Changed, name, text);
                continue;
            };
            let value = self.argument(name, &params[place], &arg.value, scope);
            written.push(match &arg.name {
                Some(_) => format!("{}={value}", params[place].name),
                None => value.clone(),
            });
            given[place] = Some(value);
        }
        if row.call == "-" || (name == "set_tool_digital_output_mode" && !self.switches_tool_pins())
        {
            let note = if row.note.is_empty() {
                text!("no output of the tool is used", "没有使用工具的输出")
            } else {
                row.note.clone()
            };
            self.say(
                line,
                MessageKind::Changed,
                name,
                text!("is left out: {note}", "已略去：{note}"),
            );
            return String::new();
        }
        if let Some(new) = row.call.strip_prefix('=') {
            let defaults: Vec<String> = params
                .iter()
                .zip(&given)
                .filter(|(param, given)| param.is_written && given.is_none())
                .filter_map(|(param, _)| Some(format!("{}={}", param.name, param.default?)))
                .collect();
            if !defaults.is_empty() {
                let text = text!(
                    "its default {} is written out",
                    "写出了它的默认值 {}",
                    defaults.join(", ")
                );
                self.say(line, MessageKind::Changed, name, text);
            }
            written.extend(defaults);
            if !new.is_empty() {
                self.say(
                    line,
                    MessageKind::Renamed,
                    name,
                    text!("is called {new} here", "这里称为 {new}"),
                );
            }
            let callee = if new.is_empty() { name } else { new };
            return format!("{callee}({})", written.join(", "));
        }
        self.template(row, &params, &given, args, line)
    }

    fn switches_tool_pins(&self) -> bool {
        let called = &self.analysis.called;
        called.contains("set_tool_digital_out") || called.contains("set_digital_out")
    }

    /// An argument as the parameter wants it.
    fn argument(
        &mut self,
        callee: &str,
        param: &Parameter,
        value: &Expr,
        scope: ScopeId,
    ) -> String {
        let kind = self.analysis.infer(value, scope);
        let text = self.emit(value, scope, Form::Argument).0;
        let line = value.line;
        match param.kind {
            "p" if is_motion(callee) && kind.is_list() => {
                self.say(
                    line,
                    MessageKind::Helper,
                    callee,
                    text!("joint positions become a pose", "关节位置换算为位姿"),
                );
                format!("get_forward_kin({text})")
            }
            "p" if is_motion(callee) && kind.is_mixed() => {
                self.say(
                    line,
                    MessageKind::Helper,
                    callee,
                    text!("joint positions become a pose", "关节位置换算为位姿"),
                );
                format!("tcp_pose({text})")
            }
            "j" if kind.is_pose() => {
                self.say(
                    line,
                    MessageKind::Helper,
                    callee,
                    text!("a pose becomes joint positions", "位姿换算为关节位置"),
                );
                format!("get_inverse_kin({text})")
            }
            "j" if kind.is_mixed() => {
                self.say(
                    line,
                    MessageKind::Helper,
                    callee,
                    text!("a pose becomes joint positions", "位姿换算为关节位置"),
                );
                format!("joint_positions({text})")
            }
            "j" if kind.own.is_unknown() && is_motion(callee) => {
                let text_of_remark = text!(
                    "taken as joint positions: the text does not tell whether it is a pose",
                    "按关节位置处理：文本看不出是否为位姿"
                );
                self.say(line, MessageKind::Changed, callee, text_of_remark);
                text
            }
            "t" if kind.is_pose() => {
                self.say(
                    line,
                    MessageKind::Helper,
                    callee,
                    text!(
                        "a pose is written with its rotation vector",
                        "位姿以旋转向量写出"
                    ),
                );
                format!("pose_text({text})")
            }
            "t" if kind.is_mixed() => format!("text_of({text})"),
            _ => text,
        }
    }

    fn template(
        &mut self,
        row: &'static UrFunction,
        params: &[Parameter],
        given: &[Option<String>],
        args: &[Argument],
        line: u32,
    ) -> String {
        let name = row.name();
        let mut used = vec![false; params.len()];
        let (head, list) = match row
            .call
            .strip_suffix(')')
            .and_then(|call| call.split_once('('))
        {
            Some((head, list)) => (head, list),
            None => ("", row.call),
        };
        let pieces = if head.is_empty() {
            vec![list]
        } else {
            split_list(list)
        };
        let mut texts = Vec::new();
        for piece in pieces {
            let (key, piece) = match piece.split_once("={") {
                Some((key, _)) if key.chars().all(|c| c == '_' || c.is_alphanumeric()) => {
                    (Some(key), &piece[key.len() + 1..])
                }
                _ => (None, piece),
            };
            let is_given = |param: &Parameter| given_value(params, given, param.name).is_some();
            let placeholder = params.iter().position(|param| {
                let name = param.name;
                piece.contains(&format!("{{{name}}}")) || piece.contains(&format!("{{{name}|"))
            });
            if let Some(place) = placeholder {
                used[place] = true;
                if key.is_some() && !is_given(&params[place]) {
                    continue;
                }
            }
            let text = self.filled(piece, params, given, args);
            texts.push(match key {
                Some(key) => format!("{key}={text}"),
                None => text,
            });
        }
        let dropped: Vec<&str> = params
            .iter()
            .zip(given)
            .zip(&used)
            .filter(|((_, given), used)| given.is_some() && !**used)
            .map(|((param, _), _)| param.name)
            .collect();
        let (call, head) = match head.is_empty() {
            true => (
                texts.concat(),
                row.call.split('(').next().unwrap_or_default().to_owned(),
            ),
            false => folded(head, &texts),
        };
        self.say_template(row, &head, &dropped, line);
        if call.is_empty() {
            self.say(
                line,
                MessageKind::Changed,
                name,
                text!("is left out: {}", "已略去：{}", row.note),
            );
        }
        call
    }

    fn say_template(&mut self, row: &UrFunction, head: &str, dropped: &[&str], line: u32) {
        let name = row.name();
        let note = if row.note.is_empty() {
            Text::verbatim("")
        } else {
            text!("; {}", "；{}", row.note)
        };
        if HELPERS.iter().any(|helper| helper.name == head) {
            let text = text!(
                "is {head} of the program's head{note}",
                "是程序头部的 {head}{note}"
            );
            self.say(line, MessageKind::Helper, name, text);
        } else if head != name && !head.is_empty() {
            self.say(
                line,
                MessageKind::Renamed,
                name,
                text!("is {head} here{note}", "这里是 {head}{note}"),
            );
        } else if !row.note.is_empty() && dropped.is_empty() {
            self.say(line, MessageKind::Changed, name, row.note.clone());
        }
        if !dropped.is_empty() {
            let text = text!("{} is left out{note}", "略去 {}{note}", dropped.join(", "));
            self.say(line, MessageKind::Changed, name, text);
        }
    }

    /// A piece of a template with its arguments in place.
    fn filled(
        &mut self,
        piece: &str,
        params: &[Parameter],
        given: &[Option<String>],
        args: &[Argument],
    ) -> String {
        let mut text = String::new();
        let mut rest = piece;
        while let Some((before, after)) = rest.split_once('{') {
            let (slot, after) = after.split_once('}').unwrap_or((after, ""));
            let (param, fallback) = match slot.split_once('|') {
                Some((param, fallback)) => (param, Some(fallback)),
                None => (slot, None),
            };
            let default = params
                .iter()
                .find(|p| p.name == param)
                .and_then(|p| p.default);
            text.push_str(before);
            match given_value(params, given, param) {
                // What a controller there would make of backslashes is done here.
                Some(value) if has_escapes(args) && matches!(param, "prefix" | "suffix") => {
                    text.push_str(&value.replace("\\\\", "\\"));
                }
                Some(value) => text.push_str(value),
                None => text.push_str(fallback.or(default).unwrap_or_default()),
            }
            rest = after;
        }
        text.push_str(rest);
        text
    }
}

fn given_value<'v>(
    params: &[Parameter],
    given: &'v [Option<String>],
    name: &str,
) -> Option<&'v str> {
    let place = params.iter().position(|param| param.name == name)?;
    given.get(place)?.as_deref()
}

/// Whether `interpret_escape` of `socket_read_string` is set.
fn has_escapes(args: &[Argument]) -> bool {
    args.iter().enumerate().any(|(index, arg)| {
        let is_meant = match &arg.name {
            Some(name) => name == "interpret_escape",
            None => index == 3,
        };
        is_meant && without_parens(&arg.value).kind == ExprKind::Bool(true)
    })
}

/// A call of a helper with a number that is known is what the helper would do. Gives the call and the function it
/// calls.
fn folded(head: &str, args: &[String]) -> (String, String) {
    let number = args.first().and_then(|arg| arg.parse::<u32>().ok());
    let rest = args.get(1).map(String::as_str).unwrap_or_default();
    let call = match (head, number) {
        ("digital_in", Some(n)) if n < 8 => format!("get_standard_digital_in({n})"),
        ("digital_in", Some(n @ 8..=9)) => format!("tool_digital_in({})", n - 8),
        ("digital_out", Some(n)) if n < 8 => format!("get_standard_digital_out({n})"),
        ("digital_out", Some(n @ 8..=9)) => format!("get_tool_digital({})", n - 8),
        ("switch_digital_out", Some(n)) if n < 8 => {
            format!("set_standard_digital_out({n}, {rest})")
        }
        ("switch_digital_out", Some(n @ 8..=9)) => {
            format!("switch_tool_digital_out({}, {rest})", n - 8)
        }
        ("analog_in", Some(n)) if n < 2 => format!("get_standard_analog_in({n})"),
        ("analog_in" | "tool_analog_in", Some(0 | 2)) => "get_tool_analog_in()".to_owned(),
        ("tool_input_domain", Some(0)) => format!("set_tool_analog_input_domain({rest})"),
        ("tool_input_domain", Some(_)) => String::new(),
        _ => {
            let args: Vec<String> = args.iter().map(|arg| folded_argument(arg)).collect();
            format!("{head}({})", args.join(", "))
        }
    };
    let head = call.split('(').next().unwrap_or_default().to_owned();
    (call, head)
}

fn folded_argument(arg: &str) -> String {
    let known = [
        ("mode=arc_mode(0)", "mode=1"),
        ("mode=arc_mode(1)", "mode=0"),
        ("force_type(1)", "1"),
        ("force_type(2)", "0"),
        ("force_type(3)", "2"),
        ("conveyor_input(1)", "17"),
        ("conveyor_input(2)", "0"),
        ("conveyor_input(3)", "0"),
        ("conveyor_input(4)", "0"),
    ];
    let found = known.iter().find(|(call, _)| *call == arg);
    found.map_or_else(|| arg.to_owned(), |(_, value)| (*value).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::translate::expressions::quoted;

    #[test]
    fn calls_with_known_numbers_need_no_helper() {
        let args = ["3".to_owned(), "True".to_owned()];
        let (call, head) = folded("switch_digital_out", &args);
        assert_eq!(call, "set_standard_digital_out(3, True)");
        assert_eq!(head, "set_standard_digital_out");
        assert_eq!(folded_argument("force_type(2)"), "0");
        assert_eq!(quoted("a\\n"), "\"a\\\\n\"");
    }
}
