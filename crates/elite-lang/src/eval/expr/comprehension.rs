//! List, set and dict comprehensions, run in the frame around them.

use std::rc::Rc;

use elite_syntax::Span;

use crate::eval::stmt::loops::LoopTarget;
use crate::eval::walk::LoopCursor;
use crate::eval::{BoxExpr, Evaluator, ExprNode, Frame, TraceExt};
use crate::limits::deferred_drop::NodeList;
use crate::value::{CellVar, Dict, R, Set, Value};

/// One `for target in iterable if …`.
pub struct Clause {
    /// What is bound.
    pub target: LoopTarget,
    /// What is walked through.
    pub iterable: BoxExpr,
    /// What must hold.
    pub conditions: NodeList<BoxExpr>,
    /// Where the iterable is written.
    pub span: Span,
}

/// What all comprehensions share.
pub struct Clauses {
    /// At least one.
    pub clauses: NodeList<Clause>,
    /// Slots of its variables, cleared at its end.
    pub slots: Box<[u32]>,
    /// Slots that get a new cell each time it runs.
    pub fresh_cells: Box<[u32]>,
}

impl Clauses {
    /// Runs `body` for each combination that the clauses let through.
    #[inline]
    fn run(
        &self,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
        body: &mut dyn FnMut(&Evaluator<'_>, &mut Frame<'_>) -> R<()>,
    ) -> R<()> {
        // The first iterable is evaluated before the variables are made anew.
        let Some(first) = self.clauses.first() else {
            return Ok(());
        };
        let iterable = first.iterable.eval(ev, f)?;
        for slot in &self.fresh_cells {
            f.slots[*slot as usize] = Value::Cell(CellVar::new(Value::Unbound));
        }
        let result = self.clause(0, iterable, ev, f, body);
        for slot in &self.slots {
            f.slots[*slot as usize] = Value::Unbound;
        }
        result
    }

    fn clause(
        &self,
        index: usize,
        iterable: Value,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
        body: &mut dyn FnMut(&Evaluator<'_>, &mut Frame<'_>) -> R<()>,
    ) -> R<()> {
        let clause = &self.clauses[index];
        let mut walk = LoopCursor::over(iterable, ev, f, clause.span)?;
        'items: while clause.target.bind_next(&mut walk, ev, f, clause.span)? {
            ev.safepoint()?;
            for condition in &clause.conditions {
                if !condition.truth(ev, f)? {
                    continue 'items;
                }
            }
            match self.clauses.get(index + 1) {
                None => body(ev, f)?,
                Some(next) => {
                    let iterable = next.iterable.eval(ev, f)?;
                    self.clause(index + 1, iterable, ev, f, body)?;
                }
            }
        }
        Ok(())
    }
}

/// `[element for …]`
pub struct ListComprehension {
    /// What is collected.
    pub element: BoxExpr,
    /// The `for` and `if` clauses.
    pub clauses: Clauses,
}

impl ExprNode for ListComprehension {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let mut items = Vec::new();
        self.clauses.run(ev, f, &mut |ev, f| {
            let value = self.element.eval(ev, f)?;
            ev.grow(&mut items, 1)?;
            items.push(value);
            Ok(())
        })?;
        Ok(Value::list(items))
    }
}

/// `{element for …}`
pub struct SetComprehension {
    /// What is collected.
    pub element: BoxExpr,
    /// The `for` and `if` clauses.
    pub clauses: Clauses,
    /// The place in the text.
    pub span: Span,
}

impl ExprNode for SetComprehension {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let set = Set::new();
        self.clauses.run(ev, f, &mut |ev, f| {
            let value = self.element.eval(ev, f)?;
            ev.set_add(&set, value).trace_at(ev, f, self.span)
        })?;
        Ok(Value::Set(Rc::new(set)))
    }
}

/// `{key: value for …}`
pub struct DictComprehension {
    /// The keys.
    pub key: BoxExpr,
    /// The values of the keys.
    pub value: BoxExpr,
    /// The `for` and `if` clauses.
    pub clauses: Clauses,
    /// The place in the text.
    pub span: Span,
}

impl ExprNode for DictComprehension {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let dict = Dict::new();
        self.clauses.run(ev, f, &mut |ev, f| {
            let key = self.key.eval(ev, f)?;
            let value = self.value.eval(ev, f)?;
            ev.dict_set(&dict, key, value).trace_at(ev, f, self.span)
        })?;
        Ok(Value::Dict(Rc::new(dict)))
    }
}

/// `(element for …)`: makes the generator; the first iterable is evaluated at once.
pub struct GeneratorExpression {
    /// The generator function, with the iterator as only parameter.
    pub function: super::function::MakeFunction,
    /// The first iterable.
    pub iterable: BoxExpr,
    /// The place in the text.
    pub span: Span,
}

impl ExprNode for GeneratorExpression {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let iterable = self.iterable.eval(ev, f)?;
        let iterator = ev.iter(&iterable).trace_at(ev, f, self.span)?;
        let function = self.function.make(ev, f)?;
        ev.call_function(&function, &mut [iterator], &[])
    }
}
