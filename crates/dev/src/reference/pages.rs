//! The text of the pages.

use std::fmt::Write as _;

use editor::analysis::words::{Language, LanguageWords as _};
use elite_runtime::builtins::all;
use elite_runtime::builtins::declare::{
    Builtin, Category, FROM_OUTPUT, Parameter, ParameterDefault, ParameterType,
};

use super::GROUPS;
use super::examples::Examples;

/// Functions of a group, by section of the manual.
fn of(category: Category) -> Vec<&'static Builtin> {
    let mut found: Vec<&Builtin> = all().filter(|b| b.category == category).collect();
    found.sort_by_key(|b| {
        let section: Vec<u32> = b
            .section
            .split('.')
            .map(|part| part.parse().unwrap_or(u32::MAX))
            .collect();
        (section, b.name)
    });
    found
}

fn title(category: Category, language: Language) -> &'static str {
    let group = GROUPS.iter().find(|(known, ..)| *known == category);
    group.map_or("", |(_, english, chinese)| language.pick(english, chinese))
}

/// What a heading is called in links.
fn anchor(name: &str) -> String {
    name.replace('.', "").to_lowercase()
}

/// The page that leads to the others.
pub fn index(language: Language) -> String {
    let mut out = String::from(language.pick(INDEX, INDEX_ZH));
    for (category, ..) in GROUPS {
        let name = category.name();
        let _ = write!(out, "\n## [{}]({name}.md)\n\n", title(*category, language));
        for builtin in of(*category) {
            let _ = writeln!(
                out,
                "- [`{}`]({name}.md#{}): {}",
                builtin.name,
                anchor(builtin.name),
                builtin.summary.in_language(language)
            );
        }
    }
    out
}

const INDEX: &str = "# Functions of the robot

Made from the declarations in the code by `cargo dev reference`; a test holds these pages against them. Every example \
is a test in
`examples/reference`. `eliteserver builtins --format json` gives the same to programs, editors show it where you type.

What holds for all of them:

- Units are SI: m, rad, s, kg, N, Nm. A pose is `[x, y, z, Rx, Ry, Rz]`, R = Rz(Rz) Ry(Ry) Rx(Rx). Six joints are \
listed base first.
- An argument of another type raises `TypeError`, one outside its range `ValueError`; the message names the function, \
the argument, what was
  given and what is allowed. Lists need as many numbers as the table says, all finite.
- What the robot cannot do now (power off, a pose out of reach) raises `RuntimeError`. A protective stop ends the \
program and cannot be caught.
- Functions that *wait* let other script threads go on, and are refused in secondary programs (`sec`).
";

const INDEX_ZH: &str = "# 机器人函数参考

本页由代码中的声明生成（`cargo dev reference`），并有测试核对。每个示例都是 `examples/reference` 中的一个测试。
`eliteserver builtins --format json` 以 JSON 给出同样的内容，编辑器在输入时也会显示。

通用约定：

- 单位均为国际单位制：m、rad、s、kg、N、Nm。位姿为 `[x, y, z, Rx, Ry, Rz]`，R = Rz(Rz) Ry(Ry) Rx(Rx)。六个关节从基座开始排列。
- 参数类型不符时抛出 `TypeError`，超出范围时抛出 `ValueError`；错误信息给出函数、参数、实际值和允许值。列表长度须与表中一致，且各数均为有限数。
- 机器人当前无法执行的操作（未上电、位姿不可达）抛出 `RuntimeError`。保护性停止会结束程序，且不能被捕获。
- 标为“会等待”的函数在等待时让其他脚本线程继续运行，不能用于辅助程序（`sec`）。
";

/// The page of a group.
pub fn group(category: Category, language: Language, examples: &Examples) -> String {
    let mut out = format!("# {}\n\n", title(category, language));
    out.push_str(language.pick(
        "Made by `cargo dev reference`. What holds for all functions is on the [first page](index.md).\n",
        "由 `cargo dev reference` 生成。通用约定见[首页](index.md)。\n",
    ));
    for builtin in of(category) {
        function(&mut out, builtin, language, examples);
    }
    out
}

fn function(out: &mut String, builtin: &Builtin, language: Language, examples: &Examples) {
    let _ = write!(
        out,
        "\n## {}\n\n`{}`\n\n{}\n",
        builtin.name,
        builtin.signature(),
        builtin.summary.in_language(language)
    );
    if !builtin.params.is_empty() {
        out.push_str(language.pick(
            "\n| parameter | type | unit | allowed | default | |\n|---|---|---|---|---|---|\n",
            "\n| 参数 | 类型 | 单位 | 允许值 | 默认值 | 说明 |\n|---|---|---|---|---|---|\n",
        ));
        for parameter in builtin.params {
            row(out, parameter, language);
        }
    }
    let returns = language.pick("Returns", "返回值");
    let nothing = language.pick("nothing", "无");
    let given = match builtin.returns.english() {
        "nothing" => nothing,
        _ => builtin.returns.in_language(language),
    };
    let colon = language.pick(": ", "：");
    let _ = write!(out, "\n- {returns}{colon}{given}\n");
    if builtin.waits {
        out.push_str(language.pick("- It waits.\n", "- 会等待。\n"));
    }
    let fails: Vec<String> = examples
        .errors_of(builtin.name)
        .map(|(call, kind)| match language {
            Language::English => format!("`{call}` raises `{kind}`"),
            Language::Chinese => format!("`{call}` 抛出 `{kind}`"),
        })
        .collect();
    if !fails.is_empty() {
        let errors = language.pick("Errors", "错误");
        let between = language.pick("; ", "；");
        let _ = writeln!(out, "- {errors}{colon}{}", fails.join(between));
    }
    let _ = match builtin.section {
        FROM_OUTPUT => writeln!(
            out,
            "- {}",
            language.pick(
                "From controller output, not from the manual",
                "来自控制器的输出，手册中没有"
            )
        ),
        section => writeln!(out, "- {} {section}", language.pick("Manual", "手册章节")),
    };
    if let Some(example) = examples.of(builtin.name) {
        let _ = write!(out, "\n```python\n{}```\n", example.shown);
    }
}

fn row(out: &mut String, parameter: &Parameter, language: Language) {
    let mut name = format!("`{}`", parameter.name);
    for alias in parameter.aliases {
        let _ = write!(name, ", `{alias}`");
    }
    let default = match parameter.default {
        ParameterDefault::Required => String::new(),
        _ => {
            let written = parameter.to_string();
            let value = written.split_once('=').map_or("", |(_, value)| value);
            format!("`{value}`")
        }
    };
    let _ = writeln!(
        out,
        "| {name} | {} | {} | {} | {default} | {} |",
        cell(&parameter.kind.type_name()),
        language.unit(parameter.unit),
        cell(&allowed(parameter.kind, language)),
        cell(parameter.meaning.in_language(language))
    );
}

/// The range in words.
fn allowed(kind: ParameterType, language: Language) -> String {
    let range = kind.range_text();
    range.map_or_else(String::new, |range| range.in_language(language).to_owned())
}

/// Text in a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}
