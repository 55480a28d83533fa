//! What there is to say about a function of the robot, as data: for a reference in either language.

use elite_runtime::builtins::declare::{Builtin, Default, FROM_OUTPUT, Kind, Range};

use super::words::Language;

/// A function of the robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its name.
    pub name: &'static str,
    /// The group of the manual.
    pub category: &'static str,
    /// With defaults, as the manual writes it.
    pub signature: String,
    /// One sentence.
    pub summary: &'static str,
    /// In order.
    pub parameters: Vec<EntryParameter>,
    /// What it returns, with units.
    pub returns: &'static str,
    /// It may wait for time or motion.
    pub waits: bool,
    /// What it raises because of its arguments or of where it is called, a sentence each.
    pub errors: Vec<String>,
    /// A call that `check` has nothing to say about.
    pub example: String,
    /// The section of the manual; none of what the manual does not describe.
    pub section: Option<&'static str>,
}

/// A parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntryParameter {
    /// Its name.
    pub name: &'static str,
    /// Other spellings of the manual.
    pub aliases: &'static [&'static str],
    /// Its type.
    pub kind: String,
    /// Its unit, empty if there is none.
    pub unit: String,
    /// What is allowed, where that is not everything of its type.
    pub range: Option<String>,
    /// What it is when omitted; none if it has to be given.
    pub default: Option<String>,
    /// A phrase that says what it is.
    pub meaning: &'static str,
}

/// All there is to say about a function, in a language.
pub fn entry(builtin: &'static Builtin, language: Language) -> Entry {
    let parameters = builtin.params.iter().map(|parameter| EntryParameter {
        name: parameter.name,
        aliases: parameter.aliases,
        kind: parameter.kind.type_name(),
        unit: language.unit(parameter.unit),
        range: parameter.kind.range_text(),
        default: parameter
            .to_string()
            .split_once('=')
            .map(|(_, default)| default.to_owned()),
        meaning: language.phrase(parameter.meaning),
    });
    Entry {
        name: builtin.name,
        category: builtin.category.name(),
        signature: builtin.signature(),
        summary: language.summary(builtin),
        parameters: parameters.collect(),
        returns: language.phrase(builtin.returns),
        waits: builtin.waits,
        errors: errors(builtin, language),
        example: example(builtin),
        section: Some(builtin.section).filter(|section| *section != FROM_OUTPUT),
    }
}

fn errors(builtin: &Builtin, language: Language) -> Vec<String> {
    let mut told = Vec::new();
    let params = builtin.params.iter();
    let typed = params.filter(|p| !matches!(p.kind, Kind::Printable | Kind::Rest));
    if typed.count() > 0 {
        told.push(
            language
                .pick(
                    "`TypeError`: an argument is of another type, or one is missing",
                    "`TypeError`：参数类型不符，或缺少参数",
                )
                .to_owned(),
        );
    }
    for parameter in builtin.params {
        if let Some(range) = parameter.kind.range_text()
            && parameter.kind != Kind::Boolean
        {
            let (name, outside) = (parameter.name, language.pick("is not", "不是"));
            told.push(match language {
                Language::English => format!("`ValueError`: `{name}` {outside} {range}"),
                Language::Chinese => format!("`ValueError`：`{name}` {outside} {range}"),
            });
        }
    }
    if builtin.waits {
        let refused = language.pick(
            "`RuntimeError`: it is called in a secondary program, which may not wait",
            "`RuntimeError`：在次要程序中调用，次要程序不能等待",
        );
        told.push(refused.to_owned());
    }
    told
}

/// A call with a value for each parameter that has to be given.
fn example(builtin: &Builtin) -> String {
    let required = builtin.params.iter();
    let required = required.filter(|p| p.default == Default::Required && p.kind != Kind::Rest);
    let arguments: Vec<String> = required.map(|p| value(p.kind, p.unit)).collect();
    let call = format!("{}({})", builtin.name, arguments.join(", "));
    match builtin.params.iter().any(|p| p.kind == Kind::Function) {
        true => format!("def work():\n    sync()\n\n{call}"),
        false => call,
    }
}

/// A value of a kind, in SI units.
fn value(kind: Kind, unit: &str) -> String {
    match kind {
        Kind::Joints => "[0, -1.57, 1.57, -1.57, -1.57, 0]".into(),
        Kind::Pose | Kind::Frame => "[0.3, -0.2, 0.4, 3.14, 0, 0]".into(),
        Kind::Numbers(count) => format!("[{}]", vec!["0.1"; count].join(", ")),
        Kind::NumberList | Kind::NumberOrList => "[1, 2, 3]".into(),
        Kind::Booleans(count) => format!("[{}]", vec!["True"; count.unwrap_or(3)].join(", ")),
        Kind::List | Kind::ListOrText => "[1, 2, 3]".into(),
        Kind::Number(Range::Between(min, max)) => ((min + max) / 2.0).to_string(),
        Kind::Number(_) if unit == "s" => "0.5".into(),
        Kind::Number(_) => "0.25".into(),
        Kind::Integer(min, max) => 1.clamp(min, max).to_string(),
        Kind::OneOf(numbers) => numbers.first().copied().unwrap_or_default().to_string(),
        Kind::Boolean => "True".into(),
        Kind::Text => "\"name\"".into(),
        Kind::Word(words) => format!("{:?}", words.first().copied().unwrap_or_default()),
        Kind::Function => "work".into(),
        Kind::Arguments => "()".into(),
        Kind::Checked(_) | Kind::Printable | Kind::ThreadHandle | Kind::Rest => "1".into(),
    }
}
