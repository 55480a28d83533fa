//! Expressions: values of every kind, operators, slices, and calls of everything the language can name.

use super::{Writer, vocabulary};

const BINARY: &[&str] = &[
    "+", "-", "*", "/", "//", "%", "**", "@", "&", "|", "^", "<<", ">>", "==", "!=", "<", "<=",
    ">", ">=", "in", "not in", "and", "or", "is",
];

const SPECS: &[&str] = &[
    "", ">9", "x", "08.3f", "{i}", "*^{K()}", "1000d", "10000000", "n", "%", "c", ",", "{a}.{a}",
];

impl Writer<'_, '_> {
    /// The name of one of the variables.
    pub(super) fn variable(&mut self) -> &'static str {
        // Containers that can be changed come up more often.
        if self.material.below(3) == 0 {
            return self.container();
        }
        self.names[self.material.below(self.names.len())]
    }

    /// The name of a container that can be changed.
    pub(super) fn container(&mut self) -> &'static str {
        let name = self
            .material
            .pick(&["a", "d", "s", "y", "a", "d", "q", "k", "o", "w"]);
        if self.names.contains(&name) {
            name
        } else {
            "a"
        }
    }

    /// Something that can be called, as a rule.
    pub(super) fn function(&mut self) -> String {
        let names = vocabulary();
        match self.material.below(10) {
            0..=3 => names.builtins[self.material.below(names.builtins.len())].clone(),
            4..=6 => names.functions[self.material.below(names.functions.len())].clone(),
            7 => self
                .material
                .pick(&["act", "K", "J", "gen", "K()", "p", "x"])
                .to_owned(),
            8 => {
                let name = self.variable();
                self.method(name)
            }
            _ => format!(
                "(lambda *v: {})",
                self.material
                    .pick(&["act()", "v", "act() or v", "v[0]", "gen(v)"])
            ),
        }
    }

    /// `variable.method`.
    pub(super) fn method(&mut self, variable: &str) -> String {
        let names = &vocabulary().methods[variable];
        format!("{variable}.{}", names[self.material.below(names.len())])
    }

    /// Arguments of a call, at most three and a star or a name.
    pub(super) fn arguments(&mut self, depth: usize) -> String {
        let mut arguments = Vec::new();
        for _ in 0..self.material.below(4) {
            arguments.push(self.expression(depth));
        }
        match self.material.below(12) {
            9 => arguments.push(format!("*{}", self.expression(depth))),
            10 => arguments.push(format!("key={}", self.expression(depth))),
            11 => arguments.push(format!(
                "**{}",
                self.material
                    .pick(&["d", "{'key': act}", "{'default': K()}", "k", "K()"])
            )),
            _ => {}
        }
        arguments.join(", ")
    }

    /// An index or a slice.
    pub(super) fn index(&mut self, depth: usize) -> String {
        match self.material.below(8) {
            0 => "K()".to_owned(),
            1 => format!("{}:{}", self.part(depth), self.part(depth)),
            2 => format!(
                "{}:{}:{}",
                self.part(depth),
                self.part(depth),
                self.part(depth)
            ),
            3 => "0".to_owned(),
            4 => "-1".to_owned(),
            _ => self.expression(depth),
        }
    }

    fn part(&mut self, depth: usize) -> String {
        match self.material.below(6) {
            0 => String::new(),
            1 | 2 => "K()".to_owned(),
            3 => self
                .material
                .pick(&["1", "-1", "2", "2 ** 70", "-2 ** 70", "None"])
                .to_owned(),
            _ => self.expression(depth),
        }
    }

    /// Any expression.
    pub(super) fn expression(&mut self, depth: usize) -> String {
        if depth == 0 {
            return match self.material.below(12) {
                0..=2 => "K()".to_owned(),
                3 => "J()".to_owned(),
                4..=8 => self.variable().to_owned(),
                9 => "x".to_owned(),
                _ => {
                    let plain = [
                        "1",
                        "0",
                        "-1",
                        "None",
                        "'a'",
                        "b'a'",
                        "0.5",
                        "()",
                        "{}",
                        "act",
                        "True",
                        "10 ** 30",
                        "1 << 100000",
                        "'x' * 100000",
                        "...",
                    ];
                    self.material.pick(&plain).to_owned()
                }
            };
        }
        let below = depth - 1;
        match self.material.below(24) {
            0..=4 => self.expression(0),
            5..=7 => format!("{}({})", self.function(), self.arguments(below)),
            8..=10 => {
                let name = self.variable();
                format!("{}({})", self.method(name), self.arguments(below))
            }
            11 | 12 => format!(
                "({} {} {})",
                self.expression(below),
                self.material.pick(BINARY),
                self.expression(below)
            ),
            13 => format!("{}[{}]", self.expression(below), self.index(below)),
            14 => format!("[{}, {}]", self.expression(below), self.expression(below)),
            15 => format!(
                "{{{}: {}, **d}}",
                self.expression(below),
                self.expression(below)
            ),
            16 => format!(
                "{{{}, *{}}}",
                self.expression(below),
                self.expression(below)
            ),
            17 => format!("({}, *{})", self.expression(below), self.expression(below)),
            18 => format!(
                "[{} for x2 in {} if act()]",
                self.expression(below),
                self.expression(below)
            ),
            19 => format!(
                "({} for x2 in {})",
                self.expression(below),
                self.expression(below)
            ),
            20 => format!(
                "({} if {} else {})",
                self.expression(below),
                self.expression(below),
                self.expression(below)
            ),
            21 => format!("f'{{{}!r:{}}}'", self.variable(), self.material.pick(SPECS)),
            22 => format!(
                "(lambda v={}: {})",
                self.expression(below),
                self.expression(below)
            ),
            _ => format!(
                "({}{})",
                self.material.pick(&["-", "~", "not ", "x := "]),
                self.expression(below)
            ),
        }
    }
}
