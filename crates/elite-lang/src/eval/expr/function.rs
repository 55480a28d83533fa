//! Making functions: `def` and `lambda`.

use std::rc::Rc;

use elite_syntax::resolve::Storage;

use crate::eval::code::Code;
use crate::eval::{BoxExpr, Evaluator, ExprNode, Frame};
use crate::limits::deferred_drop::NodeList;
use crate::value::{CellVar, Dict, Function, R, Unwind, Value};

/// Makes a function with the variables of this frame.
pub struct MakeFunction {
    /// The code of the function.
    pub code: Rc<Code>,
    /// Defaults of the last positional parameters.
    pub defaults: NodeList<BoxExpr>,
    /// Defaults of the keyword-only parameters.
    pub keyword_defaults: NodeList<Option<BoxExpr>>,
    /// Where the cells of its closure come from.
    pub closure: Box<[Storage]>,
    /// The function's annotations, if it has any.
    pub annotations: Option<Box<Annotations>>,
}

/// The annotations of a function: name, expression and how it is written, parameters first and the result last. What
/// cannot be evaluated is kept as its text, so that an annotation never stops a program.
pub struct Annotations(pub Vec<(Value, BoxExpr, Value)>);

impl Annotations {
    fn evaluate(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let dict = Dict::new();
        for (name, annotation, text) in &self.0 {
            let value = match annotation.eval(ev, f) {
                Ok(value) => value,
                Err(Unwind::Exception(_)) => text.clone(),
                Err(Unwind::Stop) => return Err(Unwind::Stop),
            };
            dict.set_interned(name.clone(), value);
        }
        Ok(Value::Dict(Rc::new(dict)))
    }
}

impl MakeFunction {
    /// The function object.
    pub fn make(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<Rc<Function>> {
        let defaults: R<Vec<Value>> = self
            .defaults
            .iter()
            .map(|default| default.eval(ev, f))
            .collect();
        let keyword_defaults: R<Vec<Value>> = self
            .keyword_defaults
            .iter()
            .map(|default| {
                default
                    .as_ref()
                    .map_or(Ok(Value::Unbound), |default| default.eval(ev, f))
            })
            .collect();
        let annotations = match &self.annotations {
            Some(annotations) => Some(annotations.evaluate(ev, f)?),
            None => None,
        };
        Ok(Rc::new(Function {
            code: self.code.clone(),
            defaults: crate::value::ScriptCell::new(defaults?.into()),
            keyword_defaults: keyword_defaults?.into(),
            closure: closure(&self.closure, f),
            keyword_defaults_dict: Default::default(),
            annotations: crate::value::ScriptCell::new(annotations),
            attrs: Default::default(),
            noted: Default::default(),
            old: Default::default(),
        }))
    }
}

/// The cells an inner frame shares with this one.
pub fn closure(places: &[Storage], f: &Frame<'_>) -> Box<[Rc<CellVar>]> {
    let cell = |place: &Storage| match place {
        Storage::Cell(slot) => match &f.slots[*slot as usize] {
            Value::Cell(cell) => cell.clone(),
            // Cells are made on entry, so this does not happen; a fresh cell reads as unbound.
            _ => Rc::default(),
        },
        Storage::Free(index) => f.function.closure[*index as usize].clone(),
        Storage::Local(_) | Storage::Global | Storage::Class(_) => Rc::default(),
    };
    places.iter().map(cell).collect()
}

impl ExprNode for MakeFunction {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        self.make(ev, f).map(Value::Function)
    }
}
