//! Options of a controller: which there are, what each may be, and what they make together.
//!
//! [`ControllerOptions`] is the one declaration. The command line, configuration files, the debugger's `launch`, tools
//! of assistants and Python fill it, each from texts of its own, so that a value is taken, or refused with the same
//! sentence, whoever gives it. [`ControllerOptions::resolve`] makes the settings of a robot of it.

mod declared;
mod slot;
mod values;

pub use declared::{ControllerOptions, OptionsError, keys_of};
pub use slot::{OptionSlot, OptionValue, RefusedValue};
pub use values::*;
