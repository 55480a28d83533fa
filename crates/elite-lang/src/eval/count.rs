//! How often each line of a program was executed, for coverage reports. Costs nothing where nobody counts: the marks are
//! statements of their own, made only for a program that is counted.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;

use super::{Evaluator, Expr, Expression, Flow, Frame, Statement};
use crate::value::R;

/// Executions by line, from 1; lines with code that was never executed have 0.
pub type LineCounts = BTreeMap<u32, u64>;

/// The counted lines of the programs of one interpreter, by the name of their text.
#[derive(Default)]
pub struct Counters {
    texts: RefCell<BTreeMap<String, Lines>>,
}

/// Of one text. A line with several statements has several marks.
type Lines = BTreeMap<u32, Vec<Rc<Cell<u64>>>>;

impl Counters {
    /// A mark for a statement.
    pub fn mark(&self, text: &str, line: u32) -> Mark {
        let executed = Rc::<Cell<u64>>::default();
        let mut texts = self.texts.borrow_mut();
        if !texts.contains_key(text) {
            texts.insert(text.to_owned(), Lines::default());
        }
        let marks = texts
            .get_mut(text)
            .map(|lines| lines.entry(line).or_default());
        marks
            .into_iter()
            .for_each(|marks| marks.push(executed.clone()));
        Mark { executed }
    }

    /// What was counted so far: of a line the statement that was executed most.
    pub fn all(&self) -> BTreeMap<String, LineCounts> {
        let mut all = BTreeMap::new();
        for (text, lines) in &*self.texts.borrow() {
            let counts: &mut LineCounts = all.entry(text.clone()).or_default();
            for (line, marks) in lines {
                let executed = marks.iter().map(|mark| mark.get()).max();
                counts.insert(*line, executed.unwrap_or(0));
            }
        }
        all
    }
}

/// Stands before a statement.
pub struct Mark {
    executed: Rc<Cell<u64>>,
}

impl Mark {
    fn pass(&self) {
        self.executed.set(self.executed.get().saturating_add(1));
    }
}

impl Statement for Mark {
    #[inline(always)]
    fn exec(&self, _: &Evaluator<'_>, _: &mut Frame<'_>) -> Flow {
        self.pass();
        Flow::Next
    }
}

/// The condition of an `elif`, which is a line of its own.
pub struct MarkThen {
    /// The mark.
    pub mark: Mark,
    /// The condition.
    pub then: Expr,
}

impl Expression for MarkThen {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        self.mark.pass();
        self.then.eval(ev, f)
    }
}
