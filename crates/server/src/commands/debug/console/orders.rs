//! What is typed at the debugger's prompt.

use messages::{Text, text};

/// The orders: how each is written, and what it does.
pub(super) const ORDERS: &[(&str, Text)] = &[
    (
        "break [LINE | FUNCTION] [if EXPRESSION]",
        Text::fixed(
            "stop there, as long as the expression is true; alone: list what the program stops for",
            "在该处停下（表达式为真时）；单独使用：列出停止条件",
        ),
    ),
    (
        "break when CONDITION",
        Text::fixed(
            "stop when this becomes true of the arm: break when norm(tcp_force[0:3]) > 20",
            "机械臂满足条件时停下：break when norm(tcp_force[0:3]) > 20",
        ),
    ),
    (
        "delete [NUMBER]",
        Text::fixed("forget one of these, or all", "删除一个停止条件，或全部"),
    ),
    ("continue", Text::fixed("go on", "继续运行")),
    (
        "step, next, out",
        Text::fixed(
            "to the next statement: into calls, over them, to the end of this one",
            "到下一条语句：进入调用、越过调用、到本调用结束",
        ),
    ),
    (
        "until LINE | CONDITION",
        Text::fixed(
            "go on to a line, or until this is true of the arm",
            "运行到某一行，或直到机械臂满足条件",
        ),
    ),
    (
        "back [until LINE | CONDITION]",
        Text::fixed(
            "undo the last step; or go back to the last moment at which it was there",
            "撤销上一步；或回到最近一次满足的时刻",
        ),
    ),
    (
        "reverse",
        Text::fixed(
            "go back to the last stop of a breakpoint",
            "回到上一个断点处",
        ),
    ),
    (
        "goto CYCLE | TIME s",
        Text::fixed(
            "to this cycle or time, forwards or backwards: goto 541, goto 2.1 s",
            "到该周期或时间，可前可后：goto 541，goto 2.1 s",
        ),
    ),
    (
        "print EXPRESSION",
        Text::fixed(
            "a value: print get_actual_tcp_pose()[2]",
            "显示值：print get_actual_tcp_pose()[2]",
        ),
    ),
    (
        "! STATEMENT",
        Text::fixed(
            "carry a statement out, which may move the arm: ! speed = 0.1",
            "执行语句，可以移动机械臂：! speed = 0.1",
        ),
    ),
    (
        "where, list [LINE]",
        Text::fixed(
            "the calls that the program is in; its text around here",
            "程序所在的调用；附近的程序文本",
        ),
    ),
    (
        "vars, globals, arm",
        Text::fixed(
            "variables of this call, of the program; the state of the arm",
            "本调用的变量、程序的变量；机械臂的状态",
        ),
    ),
    (
        "restart, quit",
        Text::fixed("run the program anew; leave", "重新运行程序；退出"),
    ),
];

/// Words that begin orders, for completion.
pub(super) const WORDS: &[&str] = &[
    "arm", "back", "break", "continue", "delete", "globals", "goto", "help", "list", "next", "out",
    "print", "quit", "restart", "reverse", "step", "until", "vars", "where",
];

/// A place or a condition that the program is to come to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Stop {
    /// A line, as long as an expression is true.
    Line(u32, Option<String>),
    /// The beginning of a function.
    Function(String, Option<String>),
    /// A condition of the arm.
    Arm(String),
}

/// An order.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Order {
    Break(Stop),
    Breaks,
    Delete(Option<usize>),
    /// A request of the protocol that lets the program go on.
    Go(&'static str),
    Until(Stop),
    BackUntil(Stop),
    GotoCycle(u64),
    GotoTime(f64),
    Print(String),
    Statement(String),
    Where,
    List(Option<u32>),
    /// Variables of a scope, by its name in the protocol.
    Scope(&'static str),
    Restart,
    Help,
    Quit,
    /// Nothing was typed.
    Nothing,
}

/// Reads a line.
///
/// # Errors
/// A sentence about what is wrong with it.
pub(super) fn parse(line: &str) -> Result<Order, Text> {
    let line = line.trim();
    if let Some(statement) = line.strip_prefix('!') {
        return Ok(Order::Statement(statement.trim().to_owned()));
    }
    let (word, rest) = line
        .split_once(char::is_whitespace)
        .map_or((line, ""), |(word, rest)| (word, rest.trim()));
    let alone = |order: Order| match rest {
        "" => Ok(order),
        _ => Err(text!(
            "{word} takes nothing behind it",
            "{word} 后面不能有内容"
        )),
    };
    match word {
        "" => Ok(Order::Nothing),
        "b" | "break" if rest.is_empty() => Ok(Order::Breaks),
        "b" | "break" => stop(rest).map(Order::Break),
        "d" | "delete" if rest.is_empty() => Ok(Order::Delete(None)),
        "d" | "delete" => match rest.parse() {
            Ok(number) => Ok(Order::Delete(Some(number))),
            Err(_) => Err(text!(
                "delete takes the number that break shows",
                "delete 后面是 break 显示的编号"
            )),
        },
        "c" | "continue" | "r" | "run" => alone(Order::Go("continue")),
        "s" | "step" => alone(Order::Go("stepIn")),
        "n" | "next" => alone(Order::Go("next")),
        "o" | "out" | "finish" => alone(Order::Go("stepOut")),
        "reverse" | "rc" => alone(Order::Go("reverseContinue")),
        "u" | "until" => until(rest).map(Order::Until),
        "back" | "bs" => match rest.strip_prefix("until") {
            Some(goal) => until(goal.trim()).map(Order::BackUntil),
            None => alone(Order::Go("stepBack")),
        },
        "g" | "goto" => goto(rest),
        "p" | "print" if rest.is_empty() => {
            Err(text!("print takes an expression", "print 后面是表达式"))
        }
        "p" | "print" => Ok(Order::Print(rest.to_owned())),
        "w" | "where" | "bt" => alone(Order::Where),
        "l" | "list" if rest.is_empty() => Ok(Order::List(None)),
        "l" | "list" => match rest.parse() {
            Ok(line) => Ok(Order::List(Some(line))),
            Err(_) => Err(text!("list takes the number of a line", "list 后面是行号")),
        },
        "v" | "vars" => alone(Order::Scope("Locals")),
        "globals" => alone(Order::Scope("Globals")),
        "a" | "arm" => alone(Order::Scope("Arm")),
        "restart" => alone(Order::Restart),
        "h" | "help" | "?" => Ok(Order::Help),
        "q" | "quit" | "exit" => alone(Order::Quit),
        other => {
            let hint = match elite_syntax::nearest(other, WORDS.iter()) {
                Some(near) => text!("did you mean {near}?", "是否想写 {near}？"),
                None => text!("help lists the orders", "help 列出所有命令"),
            };
            let shown: String = other.chars().take(40).collect();
            Err(text!(
                "there is no order {shown:?}; {hint}",
                "没有命令 {shown:?}；{hint}"
            ))
        }
    }
}

fn until(goal: &str) -> Result<Stop, Text> {
    match goal.parse() {
        _ if goal.is_empty() => Err(text!(
            "until takes a line or a condition of the arm",
            "until 后面是行号或机械臂的条件"
        )),
        Ok(line) => Ok(Stop::Line(line, None)),
        Err(_) => Ok(Stop::Arm(goal.to_owned())),
    }
}

fn stop(rest: &str) -> Result<Stop, Text> {
    if let Some(condition) = rest.strip_prefix("when ") {
        return Ok(Stop::Arm(condition.trim().to_owned()));
    }
    let (place, condition) = match rest.split_once(" if ") {
        Some((place, condition)) => (place.trim(), Some(condition.trim().to_owned())),
        None => (rest, None),
    };
    if let Ok(line) = place.parse() {
        return Ok(Stop::Line(line, condition));
    }
    let is_name = place
        .chars()
        .all(|c| c.is_alphanumeric() || matches!(c, '_' | '.'));
    match is_name {
        true => Ok(Stop::Function(place.to_owned(), condition)),
        false => Err(text!(
            "break takes a line, the name of a function, or 'when' and a condition of the arm",
            "break 后面是行号、函数名，或 'when' 和机械臂的条件"
        )),
    }
}

fn goto(rest: &str) -> Result<Order, Text> {
    if let Some(time) = rest.strip_suffix('s') {
        let time: Option<f64> = time.trim().parse().ok();
        if let Some(time) = time.filter(|time| time.is_finite() && *time >= 0.0) {
            return Ok(Order::GotoTime(time));
        }
    }
    match rest.parse() {
        Ok(cycle) => Ok(Order::GotoCycle(cycle)),
        Err(_) => Err(text!(
            "goto takes a cycle or a time: goto 541, goto 2.1 s",
            "goto 后面是周期或时间：goto 541，goto 2.1 s"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_read_in_full_and_in_short() {
        let line = |line| Stop::Line(line, None);
        for (text, order) in [
            ("b 19", Order::Break(line(19))),
            (
                "break 19 if i > 3",
                Order::Break(Stop::Line(19, Some("i > 3".to_owned()))),
            ),
            (
                "break Gripper.close",
                Order::Break(Stop::Function("Gripper.close".to_owned(), None)),
            ),
            (
                "break when norm(tcp_force[0:3]) > 20",
                Order::Break(Stop::Arm("norm(tcp_force[0:3]) > 20".to_owned())),
            ),
            ("b", Order::Breaks),
            ("delete 2", Order::Delete(Some(2))),
            ("c", Order::Go("continue")),
            ("back", Order::Go("stepBack")),
            ("back until 7", Order::BackUntil(line(7))),
            ("until 7", Order::Until(line(7))),
            ("goto 541", Order::GotoCycle(541)),
            ("goto 2.164 s", Order::GotoTime(2.164)),
            ("p x + 1", Order::Print("x + 1".to_owned())),
            ("! x = 3", Order::Statement("x = 3".to_owned())),
            ("", Order::Nothing),
        ] {
            assert_eq!(parse(text), Ok(order), "{text}");
        }
        for (text, part) in [
            ("brek 3", "did you mean break?"),
            ("p", "print takes"),
            ("next 3", "takes nothing"),
            ("goto soon", "goto takes"),
            ("break x + 1", "break takes"),
            ("until", "until takes"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.english().contains(part), "{text}: {error}");
        }
    }
}
