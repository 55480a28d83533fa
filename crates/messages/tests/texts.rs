//! Errors and texts in both languages.

use std::io;

use messages::{Language, Localized, Text, text};

const LIMIT: u32 = 4;

fn chinese(value: &impl Localized) -> String {
    value.in_language(Language::Chinese).to_string()
}

#[derive(Debug, thiserror::Error, Localized)]
enum Inner {
    #[error("the file ends")]
    #[zh("文件结束")]
    End,
    #[error("cannot read {}: {source}", .path.display())]
    #[zh("无法读取 {}：{source}", .path.display())]
    File {
        path: std::path::PathBuf,
        source: io::Error,
    },
}

#[derive(Debug, thiserror::Error, Localized)]
enum Outer {
    #[error("part {0} of {1}, at most {LIMIT}: {2}")]
    #[zh("第 {0} 部分（共 {1} 部分，最多 {LIMIT}）：{2}")]
    Part(u32, u32, Inner),
    #[error(transparent)]
    Inner(Inner),
    #[error("{} is {value:.2}, joint {}", name.to_uppercase(), joint + 1)]
    #[zh("关节 {} 的 {} 为 {value:.2}", joint + 1, name.to_uppercase())]
    Value { name: String, value: f64, joint: u8 },
    #[error("{}: {{{text}}}", .0.len(), text = .1)]
    Length(String, Text),
}

#[test]
fn errors_within_errors_are_told_in_the_same_language() {
    let error = Outer::Part(1, 2, Inner::End);
    assert_eq!(error.to_string(), "part 1 of 2, at most 4: the file ends");
    assert_eq!(chinese(&error), "第 1 部分（共 2 部分，最多 4）：文件结束");
    let source = io::Error::from_raw_os_error(2);
    let error = Outer::Inner(Inner::File {
        path: "a.mcap".into(),
        source,
    });
    assert_eq!(
        chinese(&error),
        "无法读取 a.mcap：没有此文件或文件夹（系统错误 2）"
    );
}

#[test]
fn arguments_keep_their_format_in_another_order() {
    let error = Outer::Value {
        name: "speed".to_owned(),
        value: 1.0,
        joint: 0,
    };
    assert_eq!(error.to_string(), "SPEED is 1.00, joint 1");
    assert_eq!(chinese(&error), "关节 1 的 SPEED 为 1.00");
}

#[test]
fn a_text_without_words_takes_chinese_punctuation() {
    let error = Outer::Length("ab".to_owned(), text!("a number", "数"));
    assert_eq!(error.to_string(), "2: {a number}");
    assert_eq!(chinese(&error), "2：{数}");
}

#[test]
fn texts_hold_texts() {
    let items = [text!("one", "一"), text!("two", "二")];
    let list = Text::joined(items, ", ", "、");
    let (n, width) = (3, 0.25);
    let whole = text!(
        "{n} of {list} at {width:.1} m, {}",
        "{0}：{list}中的 {n} 个，{width:.1} m",
        "a"
    );
    assert_eq!(whole.english(), "3 of one, two at 0.2 m, a");
    assert_eq!(chinese(&whole), "a：一、二中的 3 个，0.2 m");
    assert_eq!(text!("a {{b}}", "甲 {{乙}}"), "a {b}");
    assert_eq!(chinese(&Text::verbatim("pick.script")), "pick.script");
}

#[test]
fn texts_are_compared_by_their_words() {
    let filled = Text::new("a number".into(), "数".into());
    assert_eq!(filled, text!("a number", "数"));
    assert!(filled < text!("a number", "整数"));
    // Errors have several texts each.
    assert!(size_of::<Text>() <= 32);
}

#[test]
fn the_operating_system_is_told_by_number() {
    let unknown = io::Error::from_raw_os_error(9999);
    assert_eq!(chinese(&unknown), "系统错误 9999");
    assert_eq!(
        chinese(&io::Error::from(io::ErrorKind::UnexpectedEof)),
        "数据意外结束"
    );
    let own = io::Error::other(text!("too large", "过大"));
    assert_eq!(
        (own.to_string(), chinese(&own)),
        ("too large".into(), "过大".into())
    );
}
