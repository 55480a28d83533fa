//! Functions of URScript and what stands for each of them in EliteScript, as a table.
//!
//! A row has the signature there, the call here, what the call gives, and a note for the report. A signature writes
//! `name:kind=default!`: kinds are `p` (a pose, also given as joint positions), `j` (joint positions, also given as a
//! pose) and `t` (a value that becomes text); a default with `!` differs from the one here, so it is written out. A
//! call is one of
//!
//! - `=`: the same name and arguments,
//! - `=name`: another name, the same arguments,
//! - `name({a}, key={b}, 3)`: `{a}` is an argument or its default, `key={b}` stands only where it is given,
//! - `-`: nothing, a setting that this arm has no use for,
//! - `!`: no counterpart.

use std::sync::LazyLock;

use messages::Text;

use super::kinds::{Kinds, Type};

/// A function of URScript.
#[derive(Clone, Debug)]
pub struct UrFunction {
    /// Signature in URScript.
    pub signature: &'static str,
    /// The call in EliteScript that does the same.
    pub call: &'static str,
    /// What it gives: `n`umber, `b`ool, te`x`t, `l`ist, `m`atrix, `p`ose, rpc `h`andle, or nothing.
    gives: &'static str,
    /// For the report; may be empty.
    pub note: Text,
}

/// A parameter of a signature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Name in URScript.
    pub name: &'static str,
    /// `p`, `j`, `t`, or empty.
    pub kind: &'static str,
    /// Default in URScript.
    pub default: Option<&'static str>,
    /// Whether the default is written out, because EliteScript has another one.
    pub is_written: bool,
}

impl UrFunction {
    /// Name of the function in URScript.
    pub fn name(&self) -> &'static str {
        self.signature.split('(').next().unwrap_or_default()
    }

    /// Parameters of the function in URScript.
    pub fn parameters(&self) -> Vec<Parameter> {
        let list = self.signature.split_once('(').map_or("", |(_, list)| list);
        split_list(list.strip_suffix(')').unwrap_or(list))
            .into_iter()
            .map(|text| {
                let (head, default) = match text.split_once('=') {
                    Some((head, default)) => (head, Some(default)),
                    None => (text, None),
                };
                let (name, kind) = head.split_once(':').unwrap_or((head, ""));
                Parameter {
                    name,
                    kind,
                    default: default.map(|text| text.trim_end_matches('!')),
                    is_written: default.is_some_and(|text| text.ends_with('!')),
                }
            })
            .collect()
    }

    /// What its calls give.
    pub fn result(&self) -> Type {
        match self.gives {
            "n" => Type::of(Kinds::NUMBER),
            "b" => Type::of(Kinds::BOOL),
            "x" => Type::of(Kinds::TEXT),
            "p" => Type::of(Kinds::POSE),
            "h" => Type::of(Kinds::HANDLE),
            "l" => Type::list(Type::of(Kinds::NUMBER)),
            "m" => Type::list(Type::list(Type::of(Kinds::NUMBER))),
            _ => Type::default(),
        }
    }
}

/// The function of this name.
pub fn function(name: &str) -> Option<&'static UrFunction> {
    FUNCTIONS.iter().find(|row| row.name() == name)
}

/// Cuts at commas outside brackets.
pub(super) fn split_list(text: &str) -> Vec<&str> {
    let mut parts = Vec::new();
    let (mut depth, mut begin) = (0_usize, 0);
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            b',' if depth == 0 => {
                parts.push(text[begin..at].trim());
                begin = at + 1;
            }
            _ => {}
        }
    }
    parts.push(text[begin..].trim());
    parts.retain(|part| !part.is_empty());
    parts
}

/// The table, by chapter of the manual of URScript.
pub static FUNCTIONS: LazyLock<Vec<UrFunction>> = LazyLock::new(|| {
    let lines = include_str!("functions.txt").lines();
    lines
        .filter(|line| line.contains(" |") && !line.starts_with('#'))
        .map(row)
        .collect()
});

fn row(line: &'static str) -> UrFunction {
    let mut columns = line.split(" |").map(str::trim);
    let mut next = || columns.next().unwrap_or_default();
    UrFunction {
        signature: next(),
        call: next(),
        gives: next(),
        note: Text::fixed(next(), next()),
    }
}
