//! What operators and builtin protocols do with values: arithmetic, comparison, items, attributes, iteration, text.
//!
//! Everything that can run script code is a method of `Evaluator`. Nothing here holds a borrow of a container while
//! script code may run.

pub mod arith;
pub mod attribute;
pub mod big;
pub mod binary;
pub mod compare;
pub mod computed;
pub mod construct;
pub mod convert;
pub mod dict;
pub mod hash;
pub mod inspect;
pub mod item;
pub mod iterate;
pub mod repr;
pub mod search;
pub mod sequence;
pub mod text;
pub mod truth;
pub mod unicode;
