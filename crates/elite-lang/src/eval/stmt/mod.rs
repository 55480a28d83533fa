//! The statement nodes.

pub mod assert;
pub mod assign;
pub mod class_body;
pub mod control;
pub mod define;
pub mod handle;
pub mod handle_star;
pub mod import;
pub mod layout;
pub mod loops;
pub mod metaclass;
pub mod simple;
pub mod target;
pub mod with;
