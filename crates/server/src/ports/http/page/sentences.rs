//! What the page is refused, in Chinese: sentences of this crate and of `pendant`; those about the robot are in the table
//! of `elite-runtime`.

use elite_runtime::chinese as robot;
use elite_syntax::chinese::{self as texts, PhraseTable, Translations};

/// Refusals, each in the form that the source has.
const SENTENCES: PhraseTable = &[
    (
        "no program is held; pause it first",
        "没有停住的程序；请先暂停",
    ),
    ("popup {} is not open", "弹窗 {0} 没有打开"),
    ("what is held is held by a page", "按住的动作由页面保持"),
    ("{} was not begun: {}", "没有开始 {0}：{1~}"),
    ("a pose has six finite numbers", "位姿需要六个有限的数"),
    ("the pose is out of reach", "位姿够不到"),
    (
        "joint {} would stand at {} rad, allowed is {} to {} rad",
        "关节 {0} 将位于 {1} rad，允许 {2} 到 {3} rad",
    ),
    (
        "{} and {} of the arm would touch",
        "机械臂的{0~}和{1~}会相碰",
    ),
    (
        "this server records nothing, so there is nothing to look through",
        "此服务器没有记录，没有内容可查",
    ),
    (
        "a program runs; stop it before the arm is moved by hand",
        "程序正在运行；手动移动机械臂前请先停止程序",
    ),
    (
        "the page gave no sign of life, so the arm was stopped",
        "页面没有发出心跳，机械臂已停止",
    ),
    ("protective stop: {}", "保护停止：{0~}"),
    (
        "{} orders of this page are being carried out already",
        "此页面已有 {0} 个命令正在执行",
    ),
    ("a recording has no task folder", "记录没有任务文件夹"),
    ("the server is ending", "服务器正在结束"),
    ("there is no function of this name", "没有这个名称的函数"),
    (
        "the scene has no mesh of this number",
        "场景中没有此编号的网格",
    ),
    ("there is no order", "没有命令"),
    (
        "what is held needs signs of life: give this order over /api/v1/live",
        "按住的动作需要心跳：请通过 /api/v1/live 发出此命令",
    ),
    (
        "the token is missing or wrong; the server prints it when it starts with --bind",
        "令牌缺失或错误；服务器以 --bind 启动时会打印令牌",
    ),
    (
        "page {} has control; take control first",
        "页面 {0} 拥有控制权；请先取得控制权",
    ),
    (
        "this page has no control; take control first",
        "此页面没有控制权；请先取得控制权",
    ),
    (
        "{} is no name of a program: it ends with .script or .task and stays inside the task folder",
        "{0} 不是程序名：应以 .script 或 .task 结尾，并位于任务文件夹内",
    ),
    (
        "the program has {} bytes, at most {} are saved",
        "程序有 {0} 字节，最多保存 {1} 字节",
    ),
    (
        "{} is not what it was when it was opened; somebody else has saved it",
        "{0} 在打开后已被他人保存",
    ),
    (
        "{} is a task of the pendant in XML, which is not edited here",
        "{0} 是示教器的 XML 任务，不能在这里编辑",
    ),
    ("{} cannot be saved: {}", "无法保存 {0}：{1}"),
    ("this is no request: {}", "这不是请求：{0}"),
    ("{} is {}; it must be {}", "{0} 为 {1}；应为 {2~}"),
    ("from 0 to 1", "0 到 1"),
    ("from -1 to 1 and not 0", "-1 到 1 且不为 0"),
    ("finite angles in rad", "有限的角度（rad）"),
    ("above 0 and at most 1", "大于 0 且不超过 1"),
    ("at most 500 N and Nm", "不超过 500 N 和 Nm"),
    ("above 0 and at most 10 s", "大于 0 且不超过 10 s"),
    ("at most 1048576 bytes long", "不超过 1048576 字节"),
    (
        "a name of at most 200 bytes without control characters",
        "不超过 200 字节、不含控制字符的名称",
    ),
];

const ALL: Translations = Translations {
    sentences: &[SENTENCES, robot::SENTENCES, texts::SENTENCES],
    words: &[robot::WORDS, texts::WORDS],
};

/// The Chinese form of a refusal, if there is one.
pub(in crate::ports::http) fn chinese(reason: &str) -> Option<String> {
    ALL.sentence(reason)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where refusals are made.
    const SOURCES: [&str; 6] = [
        include_str!("../../../backend/page.rs"),
        include_str!("live.rs"),
        include_str!("routes.rs"),
        include_str!("../../../../../pendant/src/control.rs"),
        include_str!("../../../../../pendant/src/orders.rs"),
        include_str!("../../../../../pendant/src/programs.rs"),
    ];

    /// A source text with what stands in braces left out.
    fn form(source: &str) -> String {
        let mut form = String::new();
        let mut rest = source;
        while let Some((before, after)) = rest.split_once('{') {
            form.push_str(before);
            form.push('{');
            rest = after.split_once('}').map_or(after, |(_, after)| after);
            form.push('}');
        }
        form + rest
    }

    #[test]
    fn every_refusal_of_the_table_is_made_somewhere() {
        let forms: Vec<String> = SOURCES
            .iter()
            .flat_map(|source| source.split('"'))
            .map(form)
            .collect();
        for (english, _) in SENTENCES {
            assert!(forms.iter().any(|form| form == english), "{english}");
        }
    }

    #[test]
    fn refusals_are_chinese_without_a_word_of_english() {
        for (english, expected) in [
            ("popup 3 is not open", "弹窗 3 没有打开"),
            (
                "fraction is 2; it must be from 0 to 1",
                "fraction 为 2；应为 0 到 1",
            ),
            (
                "page 2 has control; take control first",
                "页面 2 拥有控制权；请先取得控制权",
            ),
        ] {
            assert_eq!(chinese(english).as_deref(), Some(expected));
        }
    }
}
