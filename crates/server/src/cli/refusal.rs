//! What clap says of a wrong command line, in Chinese.
//!
//! Sentences of clap, and those of the standard library about numbers, are English and have no identifiers, so they are
//! known by their forms. What our options allow is a text of both languages.

use std::error::Error;
use std::net::AddrParseError;
use std::num::{IntErrorKind, ParseFloatError, ParseIntError};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use messages::{Language, LibrarySentences, Text};

/// Sentences of clap.
const FORMS: LibrarySentences = LibrarySentences(&[
    ("invalid value '{}' for '{}'", "{1} 的值 '{0}' 无效"),
    (
        "a value is required for '{}' but none was supplied",
        "{0} 需要一个值，却没有给出",
    ),
    (
        "'{}' requires a subcommand but one was not provided",
        "'{0}' 需要子命令，却没有给出",
    ),
    ("unrecognized subcommand '{}'", "没有子命令 '{0}'"),
    ("unexpected argument '{}' found", "没有参数 '{0}'"),
    (
        "unexpected value '{}' for '{}' found; no more were expected",
        "多余的值 '{0}'：{1} 不再接受更多的值",
    ),
    (
        "equal sign is needed when assigning values to '{}'",
        "给 {0} 赋值时需要等号",
    ),
    (
        "the following required arguments were not provided:",
        "缺少以下必需的参数：",
    ),
    (
        "the argument '{}' cannot be used multiple times",
        "参数 {0} 不能重复给出",
    ),
    (
        "the argument '{}' cannot be used with:",
        "参数 {0} 不能与以下参数一起使用：",
    ),
    (
        "the argument '{}' cannot be used with one or more of the other specified arguments",
        "参数 {0} 不能与其他给出的参数一起使用",
    ),
    (
        "the argument '{}' cannot be used with '{}'",
        "参数 {0} 不能与 '{1}' 一起使用",
    ),
    (
        "the subcommand '{}' cannot be used with '{}'",
        "子命令 {0} 不能与 '{1}' 一起使用",
    ),
    (
        "invalid UTF-8 was detected in one or more arguments",
        "参数中有不是 UTF-8 的文本",
    ),
    ("[possible values: {}]", "[可选值：{0}]"),
    ("[subcommands: {}]", "[子命令：{0}]"),
    (
        "tip: a similar argument exists: '{}'",
        "提示：有相近的参数：'{0}'",
    ),
    (
        "tip: some similar arguments exist: {}",
        "提示：有相近的参数：{0}",
    ),
    (
        "tip: a similar subcommand exists: '{}'",
        "提示：有相近的子命令：'{0}'",
    ),
    (
        "tip: some similar subcommands exist: {}",
        "提示：有相近的子命令：{0}",
    ),
    (
        "tip: a similar value exists: '{}'",
        "提示：有相近的值：'{0}'",
    ),
    (
        "tip: some similar values exist: {}",
        "提示：有相近的值：{0}",
    ),
    (
        "tip: subcommand '{}' exists; to use it, remove the '{}' before it",
        "提示：有子命令 '{0}'；要使用它，请去掉它前面的 '{1}'",
    ),
    ("tip: a subcommand '{}' exists", "提示：有子命令 '{0}'"),
    (
        "tip: to pass '{}' as a value, use '{}'",
        "提示：要把 '{0}' 作为值，请写 '{1}'",
    ),
    ("For more information, try '{}'.", "详细信息请用 '{0}'。"),
    ("{} is not in {}", "{0} 不在 {1} 之内"),
]);

/// What stands before a refusal.
const HEAD: [&str; 2] = ["error: ", "错误："];

/// The refusal, as lines for a terminal.
pub(super) fn refusal(error: &clap::Error) -> String {
    let mut text = error.render().to_string();
    if let Some([english, chinese]) = invalid_value(error) {
        text = text.replacen(&english, &chinese, 1);
    }
    text.split_inclusive('\n').map(line_in_chinese).collect()
}

/// A value that our options, or numbers, do not take: the sentence in both languages.
fn invalid_value(error: &clap::Error) -> Option<[String; 2]> {
    if error.kind() != ErrorKind::ValueValidation {
        return None;
    }
    let named = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text),
        _ => None,
    };
    let (option, value) = (
        named(ContextKind::InvalidArg)?,
        named(ContextKind::InvalidValue)?,
    );
    let source = error.source()?;
    Some([
        format!("invalid value '{value}' for '{option}': {source}"),
        format!("{option} 的值 '{value}' 无效：{}", reason(source)),
    ])
}

/// The reason for which a value is refused.
fn reason(source: &(dyn Error + 'static)) -> String {
    if let Some(text) = source.downcast_ref::<Text>() {
        return text.in_language(Language::Chinese).to_owned();
    }
    if let Some(number) = source.downcast_ref::<ParseIntError>() {
        let words = match number.kind() {
            IntErrorKind::Empty => "空文本不是整数",
            IntErrorKind::PosOverflow => "数过大",
            IntErrorKind::NegOverflow => "数过小",
            IntErrorKind::Zero => "不能为 0",
            _ => "其中有不是数字的字符",
        };
        return words.to_owned();
    }
    if source.is::<ParseFloatError>() {
        return "不是数".to_owned();
    }
    if source.is::<AddrParseError>() {
        return "不是 IP 地址".to_owned();
    }
    let english = source.to_string();
    FORMS.chinese(&english).unwrap_or(english)
}

fn line_in_chinese(line: &str) -> String {
    let text = line.trim();
    let (before, after) = line.split_once(text).unwrap_or((line, ""));
    let (head, said) = match text.strip_prefix(HEAD[0]) {
        Some(said) => (HEAD[1], said),
        None => ("", text),
    };
    let chinese = FORMS.chinese(said);
    format!(
        "{before}{head}{}{after}",
        chinese.as_deref().unwrap_or(said)
    )
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;
    use crate::cli::Cli;

    #[test]
    fn wrong_command_lines_are_told_in_chinese() {
        for (line, wanted) in [
            (
                "run a --step-ms 9",
                "错误：--step-ms <MS> 的值 '9' 无效：允许 1 到 8 的整毫秒数\n",
            ),
            (
                "run a --model cs6",
                "错误：--model <MODEL> 的值 'cs6' 无效：允许 cs63, ",
            ),
            (
                "chek a",
                "错误：没有子命令 'chek'\n\n  提示：有相近的子命令：'check'\n",
            ),
            ("run", "错误：缺少以下必需的参数：\n  <FILE>\n"),
            (
                "run a --seed x",
                "错误：--seed <N> 的值 'x' 无效：其中有不是数字的字符\n",
            ),
            ("run a --seed", "错误：--seed <N> 需要一个值，却没有给出\n"),
            (
                "run a --sed 1",
                "错误：没有参数 '--sed'\n\n  提示：有相近的参数：'--seed'\n",
            ),
            (
                "run a --seed 1 --seed 2",
                "错误：参数 --seed <N> 不能重复给出\n",
            ),
        ] {
            let words = std::iter::once("eliteserver").chain(line.split(' '));
            let error = Cli::command().try_get_matches_from(words).unwrap_err();
            let told = refusal(&error);
            assert!(told.starts_with(wanted), "{line}:\n{told}");
            assert!(told.ends_with("\n\n详细信息请用 '--help'。\n"), "{told}");
        }
    }
}
