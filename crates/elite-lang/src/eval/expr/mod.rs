//! The expression nodes. Operands that are locals or constants are part of their node's type, so that the common
//! shapes (`i + 1`, `x * y`, `n < 2`) need no further dispatch.

pub mod arguments;
pub mod attribute;
pub mod binary;
pub mod boolean;
pub mod call;
pub mod compare;
pub mod comprehension;
pub mod display;
pub mod enter;
pub mod fstring;
pub mod function;
pub mod item;
pub mod keywords;
pub mod method;
pub mod names;
pub mod operand;
pub mod percent;
pub mod whole;
pub mod yields;
