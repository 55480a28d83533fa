//! The modules scripts can import.

use std::rc::Rc;

use crate::eval::Evaluator;
use crate::value::{Module, R};

/// The module of this name, made anew; None if there is none.
pub fn load(_ev: &Evaluator<'_>, _name: &str) -> R<Option<Rc<Module>>> {
    Ok(None)
}
