//! How often each line of a program was executed, for coverage reports. Costs nothing where nobody counts: the marks
//! are statements of their own, made only for a program that is counted.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;

use super::{BoxExpr, Evaluator, ExprNode, Flow, Frame, StmtNode};
use crate::value::R;

/// Executions by line, from 1; lines with code that was never executed have 0.
pub type LineCounts = BTreeMap<u32, u64>;

/// The counted lines of the programs of one interpreter, by the name of their text.
#[derive(Default)]
pub struct CoverageCounters {
    texts: RefCell<BTreeMap<String, LineCounters>>,
}

/// The counters of one text by line. A line with several statements has several of them.
type LineCounters = BTreeMap<u32, Vec<Rc<Cell<u64>>>>;

impl CoverageCounters {
    /// A mark for a statement.
    pub fn mark(&self, text: &str, line: u32) -> CoverageMark {
        let executed = Rc::<Cell<u64>>::default();
        let mut texts = self.texts.borrow_mut();
        if !texts.contains_key(text) {
            texts.insert(text.to_owned(), LineCounters::default());
        }
        let marks = texts
            .get_mut(text)
            .map(|lines| lines.entry(line).or_default());
        marks
            .into_iter()
            .for_each(|marks| marks.push(executed.clone()));
        CoverageMark { executed }
    }

    /// What was counted so far: of a line the statement that was executed most.
    pub fn totals(&self) -> BTreeMap<String, LineCounts> {
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
pub struct CoverageMark {
    executed: Rc<Cell<u64>>,
}

impl CoverageMark {
    fn pass(&self) {
        self.executed.set(self.executed.get().saturating_add(1));
    }
}

impl StmtNode for CoverageMark {
    #[inline(always)]
    fn exec(&self, _: &Evaluator<'_>, _: &mut Frame<'_>) -> Flow {
        self.pass();
        Flow::Next
    }
}

/// The condition of an `elif`, which is a line of its own.
pub struct CoverageCondition {
    /// The mark.
    pub mark: CoverageMark,
    /// The condition.
    pub then: BoxExpr,
}

impl ExprNode for CoverageCondition {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        self.mark.pass();
        self.then.eval(ev, f)
    }
}
