//! What conditions and tests ask of a world after a cycle: where a part is, who holds it, what has fallen, what a sink
//! has counted.
//!
//! Kept from the messages of `/world`, so that a recording and a running cell answer alike.

use std::collections::{BTreeMap, BTreeSet};

use elite_lang::{
    ExceptionKind, NativeBody, NativeCall, NativeContext, NativeFunction, Param, Unwind, Value,
};
use std::cell::RefCell;
use std::rc::Rc;
use world::WorldDescription;

use super::part_names::matches;
use super::topic::{PartRow, WorldMessage};
use crate::cell::Cell;

/// Names of the functions that [`functions`] makes.
pub const FUNCTION_NAMES: [&str; 4] = ["part", "held", "count", "fallen"];

/// The world of parts after a cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorldFacts {
    parts: BTreeMap<String, PartRow>,
    /// Parts that were there and are not any more.
    gone: BTreeSet<String>,
    /// Parts that were removed far below.
    lost: BTreeSet<String>,
    sinks: Vec<String>,
    counts: Vec<u64>,
    /// Names of the tables of parts: `name#n` are those of sources and of tests, from the beginning.
    templates: Vec<String>,
}

impl WorldFacts {
    /// Before the first message of the world of a description.
    pub fn new(description: &WorldDescription) -> Self {
        Self {
            sinks: description
                .sinks
                .iter()
                .map(|sink| sink.name.clone())
                .collect(),
            counts: vec![0; description.sinks.len()],
            templates: description
                .parts
                .iter()
                .map(|part| part.name.clone())
                .collect(),
            ..Self::default()
        }
    }

    /// Before the first message of the world of a cell.
    pub fn of_cell(cell: &Cell) -> Self {
        let sinks = cell.tables().sink.iter();
        let sinks: Vec<String> = sinks.map(|sink| sink.name.clone()).collect();
        Self {
            counts: vec![0; sinks.len()],
            templates: cell
                .tables()
                .part
                .iter()
                .map(|part| part.name.clone())
                .collect(),
            sinks,
            ..Self::default()
        }
    }

    /// The world goes on to the state of a message.
    pub fn apply(&mut self, message: &WorldMessage) {
        for name in &message.removed {
            self.parts.remove(name);
            self.gone.insert(name.clone());
        }
        self.lost.extend(message.lost.iter().cloned());
        for part in &message.parts {
            self.gone.remove(&part.name);
            self.parts.insert(part.name.clone(), part.clone());
        }
        if !message.counts.is_empty() {
            self.counts.clone_from(&message.counts);
        }
    }

    /// A part by name; `Some(None)` for one that is not there any more, or not yet, `None` for a name that no part can
    /// have.
    pub fn part(&self, name: &str) -> Option<Option<&PartRow>> {
        match self.parts.get(name) {
            Some(part) => Some(Some(part)),
            None => self.knows(name).then_some(None),
        }
    }

    /// Parts that are there, by name.
    pub fn parts(&self) -> impl Iterator<Item = &PartRow> {
        self.parts.values()
    }

    /// Number of parts that a sink has removed; `None` for a name that no sink has.
    pub fn count(&self, sink: &str) -> Option<u64> {
        let number = self.sinks.iter().position(|name| name == sink)?;
        self.counts.get(number).copied()
    }

    /// A part of the pattern that a gripper holds.
    pub fn held(&self, pattern: &str) -> Option<&str> {
        let held = self.parts.values().filter(|part| part.held_by.is_some());
        held.map(|part| part.name.as_str())
            .find(|name| matches(pattern, name))
    }

    /// The part that a function's answer is about.
    fn found_by(&self, function: &str, pattern: &str) -> Option<String> {
        let name = match function {
            "held" => self.held(pattern),
            "fallen" => self.fallen(pattern),
            "part" => Some(pattern),
            _ => None,
        };
        name.map(str::to_owned)
    }

    /// A part of the pattern that touches or is below the floor, or was removed far below.
    pub fn fallen(&self, pattern: &str) -> Option<&str> {
        let on_floor = self.parts.values().filter(|part| part.on_floor);
        let mut names = on_floor.map(|part| &part.name).chain(&self.lost);
        names
            .find(|name| matches(pattern, name))
            .map(String::as_str)
    }

    /// Whether a name or a pattern is that of a part that is, was or may come to be there.
    fn knows(&self, pattern: &str) -> bool {
        let template = pattern.split_once('#').map(|(template, _)| template);
        if template.is_some_and(|template| self.templates.iter().any(|name| name == template)) {
            return true;
        }
        let mut names = self.parts.keys().chain(&self.gone).chain(&self.lost);
        pattern.contains('*') || names.any(|name| name == pattern)
    }
}

/// What functions of a script look at.
#[derive(Debug, Default)]
pub struct WorldFactsCell {
    /// The facts; `None` where the cell has no world.
    pub facts: RefCell<Option<WorldFacts>>,
    /// The part that the last function found.
    pub deciding: RefCell<Option<String>>,
}

impl NativeContext for WorldFactsCell {}

/// `part(name)`, `held(name)`, `count(sink)`, `fallen(name)`; `*` in a name of the second and the fourth stands for any
/// text.
pub fn functions(facts: &Rc<WorldFactsCell>) -> Vec<NativeFunction> {
    let function =
        |name: &'static str,
         parameter: &'static str,
         answer: fn(&WorldFacts, &str, &NativeCall<'_>) -> Result<Value, Unwind>| {
            NativeFunction {
                name,
                params: vec![Param::required(parameter)],
                call: NativeBody::with(facts.clone(), move |facts, call| {
                    let Some(given) = call.arg(0).and_then(Value::as_str) else {
                        let shown = call.repr(&call.arg(0).cloned().unwrap_or_default())?;
                        return Err(call.raise(
                            ExceptionKind::TypeError,
                            format!("{parameter} is {shown}; a text is needed"),
                        ));
                    };
                    let cell = facts;
                    let facts = cell.facts.borrow();
                    let Some(facts) = facts.as_ref() else {
                        let text = format!("{name}({given:?}): the cell has no parts");
                        return Err(call.raise(ExceptionKind::ValueError, text));
                    };
                    let found = facts.found_by(name, given);
                    if found.is_some() {
                        cell.deciding.replace(found);
                    }
                    answer(facts, given, call)
                }),
            }
        };
    vec![
        function("part", "name", |facts, name, call| match facts.part(name) {
            Some(part) => Ok(part_object(call, part)),
            None => Err(unknown(call, "part", name)),
        }),
        function("held", "name", |facts, name, call| {
            match facts.knows(name) {
                true => Ok(Value::Bool(facts.held(name).is_some())),
                false => Err(unknown(call, "part", name)),
            }
        }),
        function("count", "sink", |facts, name, call| {
            match facts.count(name) {
                Some(count) => Ok(Value::from(i64::try_from(count).unwrap_or(i64::MAX))),
                None => Err(unknown(call, "sink", name)),
            }
        }),
        function("fallen", "name", |facts, name, call| {
            match facts.knows(name) {
                true => Ok(Value::Bool(facts.fallen(name).is_some())),
                false => Err(unknown(call, "part", name)),
            }
        }),
    ]
}

fn unknown(call: &NativeCall<'_>, what: &str, name: &str) -> Unwind {
    call.raise(
        ExceptionKind::ValueError,
        format!("there is no {what} {name:?}"),
    )
}

/// `x y z Rx Ry Rz speed present`; numbers of a part that is not there are NaN, which no comparison holds for.
fn part_object(call: &NativeCall<'_>, part: Option<&PartRow>) -> Value {
    let [x, y, z, rx, ry, rz] = part.map_or([f64::NAN; 6], |part| part.pose);
    let speed = part.map_or(f64::NAN, |part| part.speed);
    let numbers = [
        ("x", x),
        ("y", y),
        ("z", z),
        ("Rx", rx),
        ("Ry", ry),
        ("Rz", rz),
        ("speed", speed),
    ];
    let numbers = numbers.map(|(name, value)| (name, Value::from(value)));
    let present = ("present", Value::Bool(part.is_some()));
    call.object(
        "part",
        Vec::new(),
        numbers.into_iter().chain([present]).collect(),
    )
}
