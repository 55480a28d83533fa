//! How a builtin is declared: once, as data. Binding, range errors, `eliteserver builtins`, the documentation and the
//! coverage test all read this declaration.

use std::fmt;

use elite_lang::{Unwind, Value};
use messages::{Language, Localized, Text, text};

use super::call::Call;

/// The section of what the vendor's controller understands and its manual does not describe.
pub const FROM_OUTPUT: &str = "from controller output, not from the manual";

/// Words of a declaration, in both languages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Phrase {
    english: &'static str,
    chinese: &'static str,
}

/// Words of a declaration.
pub const fn phrase(english: &'static str, chinese: &'static str) -> Phrase {
    Phrase { english, chinese }
}

impl Phrase {
    /// The English form, which the manual of the functions and programs read.
    pub const fn english(self) -> &'static str {
        self.english
    }

    /// The form in a language.
    pub fn in_language(self, language: Language) -> &'static str {
        language.pick(self.english, self.chinese)
    }
}

/// One builtin function.
pub struct Builtin {
    /// Name in scripts.
    pub name: &'static str,
    /// Section of the vendor's manual, or [`FROM_OUTPUT`].
    pub section: &'static str,
    /// Group of the manual.
    pub category: Category,
    /// One sentence.
    pub summary: Phrase,
    /// Parameters in order.
    pub params: &'static [Parameter],
    /// What the builtin returns, in words with units.
    pub returns: Phrase,
    /// True when the call may wait for time or motion; such calls are refused in secondary programs.
    pub waits: bool,
    /// The function; `None` where the language itself provides it and only the listing needs it.
    pub run: Option<Body>,
}

/// What a builtin does.
pub type Body = fn(&mut Call<'_, '_>) -> Result<Value, Unwind>;

/// Groups of the manual.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Category {
    /// Chapter 2.
    Interpreter,
    /// Chapter 3.1.
    Motion,
    /// Chapter 3.2.
    Math,
    /// Chapter 4.
    Force,
    /// Chapter 5.
    Io,
    /// Chapter 5.37 to 5.45.
    Register,
    /// Chapter 6.1.
    Modbus,
    /// Chapter 7.1.
    Socket,
    /// Chapter 7.2.
    Rpc,
    /// Chapter 5.31 to 5.34 and 8.1.
    Serial,
    /// Chapter 8.2.
    ModbusRtu,
    /// Chapter 9.1.
    Thread,
    /// Chapter 9.2, 9.3 and 9.5.
    System,
    /// Chapter 9.4.
    Text,
    /// Chapter 1.
    Other,
}

impl Category {
    /// The word in listings.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Interpreter => "interpreter",
            Self::Motion => "motion",
            Self::Math => "math",
            Self::Force => "force",
            Self::Io => "io",
            Self::Register => "register",
            Self::Modbus => "modbus",
            Self::Socket => "socket",
            Self::Rpc => "rpc",
            Self::Serial => "serial",
            Self::ModbusRtu => "modbus_rtu",
            Self::Thread => "thread",
            Self::System => "system",
            Self::Text => "string",
            Self::Other => "other",
        }
    }
}

/// One parameter.
pub struct Parameter {
    /// Name for keyword arguments.
    pub name: &'static str,
    /// Spellings of the name that the manual uses elsewhere.
    pub aliases: &'static [&'static str],
    /// The values that the parameter accepts.
    pub kind: ParameterType,
    /// What an omitted argument means.
    pub default: ParameterDefault,
    /// Unit, empty when there is none.
    pub unit: &'static str,
    /// A phrase that says what the parameter is.
    pub meaning: Phrase,
}

impl Parameter {
    /// A parameter that must be given and has one name.
    pub const fn new(
        name: &'static str,
        kind: ParameterType,
        unit: &'static str,
        meaning: Phrase,
    ) -> Self {
        Self {
            name,
            aliases: &[],
            kind,
            default: ParameterDefault::Required,
            unit,
            meaning,
        }
    }
}

/// What a parameter accepts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterType {
    /// Six joint positions, rad.
    Joints,
    /// A pose `[x, y, z, Rx, Ry, Rz]`, m and rad.
    Pose,
    /// A list of that many numbers.
    Numbers(usize),
    /// A list of any count of numbers.
    NumberList,
    /// One number, or a list of any count of them.
    NumberOrList,
    /// A list of truth values: of that many, or of any count.
    Booleans(Option<usize>),
    /// A list.
    List,
    /// A list or a string.
    ListOrText,
    /// A finite number in a range.
    Number(Range),
    /// A whole number in a closed range.
    Integer(i64, i64),
    /// A whole number out of a list.
    OneOf(&'static [i64]),
    /// True or False.
    Boolean,
    /// A text.
    Text,
    /// A text that is one of these words.
    Word(&'static [&'static str]),
    /// A value that the builtin checks itself; the text says what it takes.
    Custom(&'static str),
    /// A pose relative to the base, `"base"` or `"tool"`.
    Frame,
    /// Any value, shown with `str()`.
    Printable,
    /// A function.
    Function,
    /// A tuple or list of arguments.
    Arguments,
    /// Handle of a thread.
    ThreadHandle,
    /// Any number of values (`*values`).
    Variadic,
}

/// `0, 12 or 24`.
pub(super) fn alternatives<T: fmt::Debug>(items: &[T]) -> Text {
    let shown = |items: &[T]| {
        let words = items.iter().map(|item| Text::verbatim(format!("{item:?}")));
        Text::joined(words, ", ", "、")
    };
    match items.split_last() {
        Some((last, before @ [_, ..])) => {
            text!("{} or {last:?}", "{} 或 {last:?}", shown(before))
        }
        _ => shown(items),
    }
}

/// A range of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Any finite number.
    Any,
    /// Greater than 0.
    Positive,
    /// 0 or greater.
    NotNegative,
    /// From the first to the second, both included.
    Between(f64, f64),
}

impl Range {
    /// True when `x` lies inside.
    pub fn contains(self, x: f64) -> bool {
        match self {
            Self::Any => true,
            Self::Positive => x > 0.0,
            Self::NotNegative => x >= 0.0,
            Self::Between(min, max) => (min..=max).contains(&x),
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fmt_in(Language::English, f)
    }
}

impl Localized for Range {
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = match self {
            Self::Any => text!("any finite number", "有限的数"),
            Self::Positive => text!("a number > 0", "大于 0 的数"),
            Self::NotNegative => text!("a number >= 0", "不小于 0 的数"),
            Self::Between(min, max) => {
                text!("a number from {min} to {max}", "{min} 到 {max} 的数")
            }
        };
        f.write_str(words.in_language(language))
    }
}

/// What a builtin gets for an argument that the call omits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterDefault {
    /// No default: the call must give the argument.
    Required,
    /// The number that stands for an omitted argument.
    Number(f64),
    /// The whole number that stands for an omitted argument.
    Integer(i64),
    /// The truth value that stands for an omitted argument.
    Boolean(bool),
    /// The text that stands for an omitted argument.
    Text(&'static str),
    /// A list of ones: one for each entry of a list of booleans, otherwise six.
    Ones,
    /// A list of zeros: one for each entry of a list of numbers, otherwise six.
    Zeros,
    /// The empty text.
    EmptyText,
    /// `None`.
    None,
    /// The empty tuple.
    EmptyTuple,
    /// Something the controller knows; the word is shown in signatures.
    Symbolic(&'static str),
}

impl ParameterType {
    /// The type as listings show it.
    pub fn type_name(self) -> String {
        match self {
            Self::Joints | Self::Pose => "list[6] float".into(),
            Self::Numbers(n) => format!("list[{n}] float"),
            Self::NumberList => "list[float]".into(),
            Self::NumberOrList => "list[float] | float".into(),
            Self::Booleans(None) => "list[bool]".into(),
            Self::Booleans(Some(n)) => format!("list[{n}] bool"),
            Self::List => "list".into(),
            Self::ListOrText => "list | str".into(),
            Self::Number(_) => "float".into(),
            Self::Integer(..) | Self::OneOf(_) => "int".into(),
            Self::Word(_) => "str".into(),
            Self::Custom(what) => what.into(),
            Self::Boolean => "bool".into(),
            Self::Frame => "list[6] float | str".into(),
            Self::Text => "str".into(),
            Self::Printable | Self::Variadic => "any".into(),
            Self::Function => "callable".into(),
            Self::Arguments => "tuple".into(),
            Self::ThreadHandle => "thread id".into(),
        }
    }

    /// The range as listings show it, when there is one.
    pub fn range_text(self) -> Option<Text> {
        match self {
            Self::Number(Range::Positive) => Some(Text::verbatim("> 0")),
            Self::Number(Range::NotNegative) => Some(Text::verbatim(">= 0")),
            Self::Integer(i64::MIN, i64::MAX) => None,
            Self::Booleans(Some(_)) => Some(text!("each 0 or 1", "每项为 0 或 1")),
            Self::Integer(min, i64::MAX) => Some(Text::verbatim(format!(">= {min}"))),
            Self::Number(Range::Between(min, max)) => {
                Some(text!("{min} to {max}", "{min} 至 {max}"))
            }
            Self::Integer(min, max) => Some(text!("{min} to {max}", "{min} 至 {max}")),
            Self::OneOf(numbers) => Some(alternatives(numbers)),
            Self::Word(words) => Some(alternatives(words)),
            Self::Boolean => Some(text!("True or False", "True 或 False")),
            _ => None,
        }
    }
}

impl Parameter {
    /// A parameter that must be given.
    pub const fn required(name: &'static str, kind: ParameterType, meaning: Phrase) -> Self {
        Self {
            name,
            aliases: &[],
            kind,
            default: ParameterDefault::Required,
            unit: "",
            meaning,
        }
    }

    /// Makes a parameter optional: `default` stands for it when a call omits it.
    pub const fn or(mut self, default: ParameterDefault) -> Self {
        self.default = default;
        self
    }

    /// States the unit of a parameter, which listings and error messages show.
    pub const fn in_unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    /// Adds other spellings under which a call may name the parameter.
    pub const fn also(mut self, aliases: &'static [&'static str]) -> Self {
        self.aliases = aliases;
        self
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.kind == ParameterType::Variadic {
            return write!(f, "*{}", self.name);
        }
        f.write_str(self.name)?;
        match self.default {
            ParameterDefault::Required => Ok(()),
            ParameterDefault::Number(x) => write!(f, "={x}"),
            ParameterDefault::Integer(n) => write!(f, "={n}"),
            ParameterDefault::Text(text) => write!(f, "='{text}'"),
            ParameterDefault::Ones => {
                let n = if let ParameterType::Booleans(Some(n)) = self.kind {
                    n
                } else {
                    6
                };
                write!(f, "=[{}]", vec!["1"; n].join(","))
            }
            ParameterDefault::None => f.write_str("=None"),
            ParameterDefault::Boolean(b) => f.write_str(if b { "=True" } else { "=False" }),
            ParameterDefault::Zeros => {
                let n = if let ParameterType::Numbers(n) = self.kind {
                    n
                } else {
                    6
                };
                write!(f, "=[{}]", vec!["0"; n].join(","))
            }
            ParameterDefault::EmptyText => f.write_str("=''"),
            ParameterDefault::EmptyTuple => f.write_str("=()"),
            ParameterDefault::Symbolic(word) => write!(f, "='{word}'"),
        }
    }
}

impl Builtin {
    /// A builtin that returns at once.
    pub const fn new(
        category: Category,
        section: &'static str,
        name: &'static str,
        params: &'static [Parameter],
        returns: Phrase,
        summary: Phrase,
        run: Body,
    ) -> Self {
        Self {
            name,
            section,
            category,
            summary,
            params,
            returns,
            waits: false,
            run: Some(run),
        }
    }

    /// Marks a builtin whose call may suspend the calling thread before it returns.
    pub const fn waiting(mut self) -> Self {
        self.waits = true;
        self
    }

    /// The signature with defaults, as the manual writes it: `movej(q, a=1.396263, …)`.
    pub fn signature(&self) -> String {
        let params: Vec<String> = self.params.iter().map(ToString::to_string).collect();
        format!("{}({})", self.name, params.join(", "))
    }
}
