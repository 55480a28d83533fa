//! Programs whose blocks end in any mixture of ways run the same: with `end` at the column of the header, with `end` at
//! that of the lines, or without; with any indentation; with blank lines, comments and directives between; with
//! statements on one line. Trees are drawn from numbers that look random, printed plainly and in mixtures, and run.

use crate::support;

use std::fmt::Write as _;

use elite_syntax::{KnownNames, Severity, check};
use support::Task;

/// Numbers that look random and are the same every time (Knuth's generator with the constants of MMIX).
struct Draw(u64);

impl Draw {
    fn below(&mut self, most: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % most
    }

    fn one_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }
}

/// A statement: its lines for one that has no block, otherwise its clauses.
enum Tree {
    Plain(String),
    Block(Vec<(String, Vec<Tree>)>),
}

/// Names of builtins that the programs use as variables, as plug-ins do.
const NAMES: [&str; 6] = ["x", "y", "len", "type", "sum", "input"];

fn name(draw: &mut Draw) -> &'static str {
    NAMES[draw.below(NAMES.len() as u64) as usize]
}

fn body(draw: &mut Draw, depth: u32, in_loop: bool) -> Vec<Tree> {
    let count = 1 + draw.below(3);
    (0..count).map(|_| tree(draw, depth, in_loop)).collect()
}

fn tree(draw: &mut Draw, depth: u32, in_loop: bool) -> Tree {
    let (a, b) = (name(draw), name(draw));
    let kind = if depth == 0 {
        draw.below(5)
    } else {
        draw.below(12)
    };
    let number = draw.below(7);
    let block = |header: String, body: Vec<Tree>| Tree::Block(vec![(header, body)]);
    match kind {
        0 | 1 => Tree::Plain(format!("{a} = {b} + {number}")),
        2 => Tree::Plain(format!("print({a}, {number})")),
        3 => Tree::Plain(format!("{a} = [{b}, {number}][{}]", number % 2)),
        4 if in_loop && draw.one_in(3) => Tree::Plain("break".to_owned()),
        4 => Tree::Plain("pass".to_owned()),
        5 | 6 => {
            let mut clauses = vec![(format!("if {a} > {number}"), body(draw, depth - 1, in_loop))];
            for _ in 0..draw.below(3) {
                let test = format!("elif {b} == {}", draw.below(4));
                clauses.push((test, body(draw, depth - 1, in_loop)));
            }
            if draw.one_in(2) {
                clauses.push(("else".to_owned(), body(draw, depth - 1, in_loop)));
            }
            Tree::Block(clauses)
        }
        7 => {
            let mut inner = body(draw, depth - 1, true);
            inner.push(Tree::Plain("break".to_owned()));
            block("while (True)".to_owned(), inner)
        }
        8 => block(
            format!("for i in range({number})"),
            body(draw, depth - 1, true),
        ),
        9 => {
            let mut protected = body(draw, depth - 1, in_loop);
            protected.push(Tree::Plain(format!("{a} = 1 // ({b} % 2)")));
            let mut clauses = vec![
                ("try".to_owned(), protected),
                (
                    "except ZeroDivisionError".to_owned(),
                    body(draw, depth - 1, in_loop),
                ),
            ];
            if draw.one_in(2) {
                clauses.push(("finally".to_owned(), body(draw, depth - 1, false)));
            }
            Tree::Block(clauses)
        }
        10 => {
            // A function of its own name is called at once.
            let mut inner = vec![Tree::Plain("x = y = input = 1".to_owned())];
            inner.extend(body(draw, depth - 1, false));
            inner.push(Tree::Plain("return len".to_owned()));
            let function = block("def helper(len, type=2, sum=3)".to_owned(), inner);
            let call = Tree::Plain(format!("print(helper({number}))"));
            block("if True".to_owned(), vec![function, call])
        }
        _ => {
            let mut inner = vec![Tree::Plain("x = y = input = type = sum = 1".to_owned())];
            inner.extend(body(draw, depth - 1, false));
            inner.push(Tree::Plain("return len".to_owned()));
            let method = block("def run(self, len)".to_owned(), inner);
            let class = block(
                "class Part".to_owned(),
                vec![Tree::Plain("size = 1".to_owned()), method],
            );
            let call = Tree::Plain(format!("print(Part().run({number}))"));
            block("if True".to_owned(), vec![class, call])
        }
    }
}

/// How a program is printed.
struct Printer<'d> {
    /// None: plainly, four blanks and no `end`.
    draw: Option<&'d mut Draw>,
    out: String,
}

impl Printer<'_> {
    fn one_in(&mut self, n: u64) -> bool {
        self.draw.as_mut().is_some_and(|draw| draw.one_in(n))
    }

    fn below(&mut self, n: u64) -> u64 {
        self.draw.as_mut().map_or(0, |draw| draw.below(n))
    }

    /// Blank lines, lines of blanks, comments and directives.
    fn between(&mut self, column: usize) {
        for _ in 0..self.below(3) {
            let other = self.below(9) as usize;
            let text = match self.below(5) {
                0 => String::new(),
                1 => " ".repeat(other),
                2 => format!("{}# 注释 it's", " ".repeat(other)),
                3 => format!("{}$ LINE: ({}, \"节点\")", " ".repeat(column), other + 1),
                _ => format!(
                    "{}$ LINE: ({}, 'x', 'after')  # why",
                    " ".repeat(column),
                    other + 1
                ),
            };
            let _ = writeln!(self.out, "{text}");
        }
    }

    fn trees(&mut self, trees: &[Tree], column: usize, width: usize) {
        let blanks = " ".repeat(column);
        let mut rest = trees.iter().peekable();
        while let Some(tree) = rest.next() {
            self.between(column);
            match tree {
                Tree::Plain(text) => {
                    let _ = write!(self.out, "{blanks}{text}");
                    // The next ones on the same line.
                    while let Some(Tree::Plain(next)) = rest.peek()
                        && self.one_in(4)
                    {
                        let _ = write!(self.out, "; {next}");
                        rest.next();
                    }
                    let tail = if self.one_in(8) { ";" } else { "" };
                    let _ = writeln!(self.out, "{tail}");
                }
                Tree::Block(clauses) => self.block(clauses, column, width),
            }
        }
    }

    fn block(&mut self, clauses: &[(String, Vec<Tree>)], column: usize, width: usize) {
        let blanks = " ".repeat(column);
        let mut inner = column + width;
        for (index, (header, trees)) in clauses.iter().enumerate() {
            if index > 0 {
                self.between(column);
            }
            let _ = writeln!(self.out, "{blanks}{header}:");
            // Functions have an indentation of their own.
            let width = match header.starts_with("def") && self.draw.is_some() {
                true => 2 + self.below(5) as usize,
                false => width,
            };
            inner = column + width;
            self.trees(trees, inner, width);
        }
        self.between(inner);
        let ending = match self.draw.is_some() {
            true => self.below(4),
            false => 0,
        };
        let end = if self.one_in(5) { "end;" } else { "end" };
        let _ = match ending {
            1 | 2 => writeln!(self.out, "{blanks}{end}"),
            3 => writeln!(self.out, "{}{end}  # of it", " ".repeat(inner)),
            _ => Ok(()),
        };
    }
}

fn printed(program: &[Tree], draw: Option<&mut Draw>) -> String {
    let mut printer = Printer {
        draw,
        out: String::new(),
    };
    let width = match printer.draw {
        Some(_) => 2 + printer.below(5) as usize,
        None => 4,
    };
    printer.trees(program, 0, width);
    printer.out
}

/// What a program prints, without the places in a report.
fn outcome(text: &str) -> String {
    let shown = Task::new().run(text);
    let places = shown.lines().filter(|line| !line.starts_with("  "));
    places.collect::<Vec<_>>().join("\n")
}

#[test]
fn blocks_end_in_any_mixture_of_ways() {
    let known = KnownNames::new([""; 0]);
    let mut draw = Draw(7);
    let (mut ends, mut lines) = (0, 0);
    for seed in 0..150 {
        let mut inner = vec![Tree::Plain(
            "x = y = len = type = sum = input = 1".to_owned(),
        )];
        inner.extend(body(&mut draw, 4, false));
        inner.push(Tree::Plain("print(x, y)".to_owned()));
        let program = [Tree::Block(vec![("def job()".to_owned(), inner)])];
        let plain = printed(&program, None);
        let expected = outcome(&plain);
        assert!(!expected.is_empty(), "{plain}");
        for _ in 0..3 {
            let mixed = printed(&program, Some(&mut draw));
            ends += mixed.matches("end").count();
            lines += mixed.lines().count();
            let found = check(Task::file(&mixed), &known);
            let errors: Vec<_> = found
                .iter()
                .filter(|finding| finding.severity == Severity::Error)
                .collect();
            assert!(errors.is_empty(), "{seed}: {errors:?}\n{mixed}");
            assert_eq!(
                outcome(&mixed),
                expected,
                "{seed}\n{plain}\n--- as\n{mixed}"
            );
        }
    }
    assert!(
        ends > 2000 && lines > 10_000,
        "{ends} ends in {lines} lines"
    );
}
