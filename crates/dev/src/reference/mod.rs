//! `cargo dev reference`: the pages of all functions of the robot, made from their declarations and from examples that
//! are tests.
//!
//! A page for each group of the manual, in English (`docs/reference`) and Chinese (`docs/zh/reference`). What a
//! function takes and gives comes from `elite_runtime::builtins`, its Chinese words from `editor::analysis::words`;
//! examples and the errors beyond the declared ranges are the tests in `examples/reference`, so what a page shows has
//! been run (`tests/reference.rs`).

mod examples;
mod pages;

use std::path::Path;

pub use editor::analysis::words::Language;
use elite_runtime::builtins::all;
use elite_runtime::builtins::declare::Category;

pub use examples::{Example, Examples};

/// The groups in the order of the manual, each with its titles in English and Chinese.
const GROUPS: &[(Category, &str, &str)] = &[
    (Category::Interpreter, "Interpreter mode", "解释器模式"),
    (Category::Motion, "Motion", "运动"),
    (
        Category::Math,
        "Mathematics, poses, kinematics",
        "数学、位姿与运动学",
    ),
    (Category::Force, "Force control", "力控"),
    (Category::Io, "Inputs and outputs", "输入输出"),
    (Category::Register, "Registers", "寄存器"),
    (Category::Modbus, "Modbus TCP", "Modbus TCP"),
    (Category::Socket, "Sockets", "套接字"),
    (Category::Rpc, "Remote procedure calls", "远程过程调用"),
    (Category::Serial, "Serial lines", "串口"),
    (Category::ModbusRtu, "Modbus RTU", "Modbus RTU"),
    (Category::Thread, "Threads", "线程"),
    (Category::System, "System", "系统"),
    (Category::Text, "Texts", "字符串"),
    (Category::Other, "Other functions", "其他函数"),
];

/// A page that is made: its path below the top of the repository, and its text.
pub struct GeneratedPage {
    /// Path of the page, for instance `docs/reference/motion.md`.
    pub path: String,
    /// Markdown.
    pub text: String,
}

/// All pages.
///
/// # Errors
/// An example file that cannot be read, or a function without an example.
pub fn make(root: &Path) -> Result<Vec<GeneratedPage>, ReferenceError> {
    let examples = Examples::read(&root.join("examples/reference"))?;
    if let Some(builtin) = all().find(|builtin| examples.of(builtin.name).is_none()) {
        return Err(ReferenceError::NoExample(builtin.name));
    }
    let mut made = Vec::new();
    for (language, folder) in [
        (Language::English, "docs/reference"),
        (Language::Chinese, "docs/zh/reference"),
    ] {
        made.push(GeneratedPage {
            path: format!("{folder}/index.md"),
            text: pages::index(language),
        });
        for (category, ..) in GROUPS {
            made.push(GeneratedPage {
                path: format!("{folder}/{}.md", category.name()),
                text: pages::group(*category, language, &examples),
            });
        }
    }
    Ok(made)
}

/// A reason why the pages cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// A file of examples.
    #[error("cannot read {path}: {source}")]
    Examples {
        /// The file.
        path: std::path::PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A function that no example calls.
    #[error("no test in examples/reference calls {0}()")]
    NoExample(&'static str),
}
