//! Lists, tuples, sets and dictionaries written out.

use std::rc::Rc;

use elite_syntax::Span;

use super::operand::Operand;
use crate::errors::ExceptionKind;
use crate::eval::{BoxExpr, Evaluator, ExprNode, Frame, TraceExt};
use crate::limits::deferred_drop::NodeList;
use crate::ops::hash::quick_hash;
use crate::value::{Dict, R, Set, Unwind, Value};

/// An item of a display.
pub enum Element {
    /// A value.
    One(Operand),
    /// `*iterable`
    Star(BoxExpr, Span),
}

/// Evaluates the items of a display.
fn gather(elements: &[Element], ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<Vec<Value>> {
    let mut items = Vec::with_capacity(elements.len());
    for element in elements {
        match element {
            Element::One(expr) => items.push(expr.eval(ev, f)?),
            Element::Star(expr, span) => {
                let iterable = expr.eval(ev, f)?;
                let more = ev
                    .collect(&iterable)
                    .map_err(|raised| ev.not_unpackable(raised, &iterable));
                items.extend(more.trace_at(ev, f, *span)?);
            }
        }
    }
    Ok(items)
}

/// `[a, b, *c]`
pub struct ListDisplay(pub NodeList<Element>);

impl ExprNode for ListDisplay {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        gather(&self.0, ev, f).map(Value::list)
    }
}

/// `(a, b, *c)`
pub struct TupleDisplay(pub NodeList<Element>);

/// `(a, b)`
pub struct PairDisplay(pub [Operand; 2]);

impl ExprNode for PairDisplay {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let first = self.0[0].eval(ev, f)?;
        let second = self.0[1].eval(ev, f)?;
        Ok(Value::pair(first, second))
    }
}

/// `(a, b, c)`
pub struct TripleDisplay(pub [Operand; 3]);

impl ExprNode for TripleDisplay {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let first = self.0[0].eval(ev, f)?;
        let second = self.0[1].eval(ev, f)?;
        let third = self.0[2].eval(ev, f)?;
        Ok(Value::triple([first, second, third]))
    }
}

impl ExprNode for TupleDisplay {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        gather(&self.0, ev, f).map(Value::tuple)
    }
}

/// `{a, b, *c}`
pub struct SetDisplay {
    /// The elements.
    pub elements: NodeList<Element>,
    /// All elements are constants, and so many that CPython keeps a constant set and copies it, which shows in
    /// their order.
    pub copied: bool,
    /// The place in the text.
    pub span: Span,
}

impl ExprNode for SetDisplay {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let set = Set::new();
        // Elements before the first `*` are evaluated before the first of them is asked for its hash.
        let is_star = |element: &Element| matches!(element, Element::Star(..));
        let stars = self.elements.iter().position(is_star);
        let (first, rest) = self.elements.split_at(stars.unwrap_or(self.elements.len()));
        for item in gather(first, ev, f)? {
            ev.set_add(&set, item).trace_at(ev, f, self.span)?;
        }
        for element in rest {
            match element {
                Element::One(expr) => {
                    let item = expr.eval(ev, f)?;
                    ev.set_add(&set, item).trace_at(ev, f, self.span)?;
                }
                Element::Star(expr, span) => {
                    let iterable = expr.eval(ev, f)?;
                    let added = ev.set_extend(&set, &iterable);
                    added.trace_at(ev, f, *span)?;
                }
            }
        }
        if !self.copied {
            return Ok(Value::Set(Rc::new(set)));
        }
        let constant = Set::new();
        for (hash, key) in set.elements() {
            constant.append(hash, key);
        }
        let copy = ev.copy_set(&constant).trace_at(ev, f, self.span)?;
        Ok(Value::Set(Rc::new(copy)))
    }
}

/// An item of a dict display.
pub enum DictElement {
    /// `key: value`
    Pair(BoxExpr, BoxExpr),
    /// `**mapping`
    Unpack(BoxExpr),
}

/// `{a: b, **c}`
pub struct DictDisplay(pub NodeList<DictElement>, pub Span);

impl ExprNode for DictDisplay {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let dict = Dict::with_room(self.0.len());
        for element in self.0.iter() {
            match element {
                DictElement::Pair(key, value) => {
                    let key = key.eval(ev, f)?;
                    let mut value = value.eval(ev, f)?;
                    if let Some(hash) = quick_hash(&key) {
                        match dict.set_fast(hash, &key, value) {
                            Ok(old) => {
                                old.drop_inline();
                                continue;
                            }
                            Err(back) => value = back,
                        }
                    }
                    ev.dict_set(&dict, key, value).trace_at(ev, f, self.1)?;
                }
                DictElement::Unpack(mapping) => {
                    let mapping = mapping.eval(ev, f)?;
                    ev.update_from_mapping(&dict, &mapping)
                        .trace_at(ev, f, self.1)?;
                }
            }
        }
        Ok(Value::Dict(Rc::new(dict)))
    }
}

impl Evaluator<'_> {
    /// The error for `*value` of something that is no iterable.
    pub fn not_unpackable(&self, raised: Unwind, value: &Value) -> Unwind {
        // An iterator has failed on its way; what it says counts.
        if !self.is_kind(&raised, ExceptionKind::TypeError) || self.has_iteration(value) {
            return raised;
        }
        let name = self.core.types.name_of(value);
        self.type_error(format!("Value after * must be an iterable, not {name}"))
    }

    /// `**mapping`: like `dict.update`, but only mappings are accepted. An attribute that is missing on the way says
    /// that there is no mapping, as in CPython.
    pub fn update_from_mapping(&self, dict: &Dict, mapping: &Value) -> R<()> {
        self.merge_mapping(dict, mapping).map_err(|raised| {
            let is_dict = matches!(self.unwrap_builtin(mapping), Value::Dict(_));
            match !is_dict && self.is_kind(&raised, ExceptionKind::AttributeError) {
                true => self.not_a_mapping(mapping),
                false => raised,
            }
        })
    }

    /// `dict.update(mapping)` for a mapping; what looking for its keys raises is raised unchanged.
    pub fn merge_mapping(&self, dict: &Dict, mapping: &Value) -> R<()> {
        let is_dict = matches!(self.unwrap_builtin(mapping), Value::Dict(_));
        if !is_dict
            && self
                .attribute_or_none(mapping, crate::value::symbol::known::KEYS)?
                .is_none()
        {
            return Err(self.not_a_mapping(mapping));
        }
        self.dict_update_from(dict, mapping)
    }

    #[cold]
    fn not_a_mapping(&self, value: &Value) -> Unwind {
        let name = self.core.types.name_of(value);
        self.type_error(format!("'{name}' object is not a mapping"))
    }
}
