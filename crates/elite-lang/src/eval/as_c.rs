//! Wrong arguments for what CPython has in C and the library here in the language itself (`datetime`): the words of C.

use super::Evaluator;
use crate::value::function::Function;
use crate::value::{Symbol, Unwind, Value};

/// A module whose methods say it in these words.
const MODULE: &str = "datetime";

/// What is wrong with the arguments of a call.
pub(super) enum ArgumentMismatch<'a> {
    /// More than there are parameters, this many with the receiver.
    TooMany(usize),
    /// One is missing, of the parameter at this place; those before it are there.
    Missing(usize, &'a [Value]),
    /// A name that no parameter has, after so many arguments by position.
    Keyword(Symbol, usize, &'a [(Symbol, Value)]),
}

/// The message for a method that takes one argument or none, and nothing by name; None for other methods.
fn one_or_none(
    class: &str,
    method: &str,
    wanted: usize,
    misfit: &ArgumentMismatch<'_>,
) -> Option<String> {
    let zones = matches!(class, "tzinfo" | "timezone")
        && matches!(method, "utcoffset" | "dst" | "tzname" | "fromutc");
    let wants = match wanted {
        0 => "no arguments",
        1 if zones => "exactly one argument",
        _ => return None,
    };
    let given = match *misfit {
        ArgumentMismatch::TooMany(given) => given.saturating_sub(1),
        ArgumentMismatch::Missing(..) => 0,
        ArgumentMismatch::Keyword(..) => {
            return Some(format!("{class}.{method}() takes no keyword arguments"));
        }
    };
    Some(format!("{class}.{method}() takes {wants} ({given} given)"))
}

impl Evaluator<'_> {
    /// The error for wrong arguments of a method that fills a slot of C; None for other methods.
    fn misfit_of_slot(
        &self,
        function: &Function,
        method: &str,
        misfit: &ArgumentMismatch<'_>,
    ) -> Option<Unwind> {
        let given = match *misfit {
            ArgumentMismatch::TooMany(given) | ArgumentMismatch::Missing(given, _) => {
                given.checked_sub(1)?
            }
            ArgumentMismatch::Keyword(..) => {
                let text = format!("wrapper {method}() takes no keyword arguments");
                return Some(self.type_error(text));
            }
        };
        let wanted = function.code.params.names.len().checked_sub(1)?;
        let plural = if wanted == 1 { "" } else { "s" };
        let text = format!("expected {wanted} argument{plural}, got {given}");
        Some(self.type_error(text))
    }

    /// The error for a call of such a method; None for any other function.
    #[cold]
    pub(super) fn misfit_as_c(
        &self,
        function: &Function,
        misfit: &ArgumentMismatch<'_>,
    ) -> Option<Unwind> {
        let qualname = function.qualname();
        let (class, method) = qualname.split_once('.')?;
        if !matches!(self.module_of(&function.code), Value::Str(name) if name.as_str() == MODULE) {
            return None;
        }
        let is_slot = crate::builtins::is_slot(Some(class), method) && method != "__init__";
        if let ArgumentMismatch::Missing(0, _) = misfit {
            return Some(self.type_error(match is_slot {
                true => {
                    format!("descriptor '{method}' of '{MODULE}.{class}' object needs an argument")
                }
                false => format!("unbound method {class}.{method}() needs an argument"),
            }));
        }
        if is_slot {
            return self.misfit_of_slot(function, method, misfit);
        }
        let by_name = format!("{method}()");
        // How the name of the function stands before a count and after a keyword.
        let (called, invalid) = match (class, method) {
            ("timedelta", "__init__") => ("__new__()", "__new__()"),
            ("timezone", "__init__") => ("timezone()", "timezone()"),
            (_, "__init__") => ("function", "this function"),
            _ => (&*by_name, &*by_name),
        };
        let params = &function.code.params;
        let names = params.names.get(1..)?;
        if let Some(text) = one_or_none(class, method, names.len(), misfit) {
            return Some(self.type_error(text));
        }
        let plural = |count: usize| if count == 1 { "" } else { "s" };
        let too_many = |given: usize| match names.len() {
            all if given > all => {
                let s = plural(all);
                format!("{called} takes at most {all} argument{s} ({given} given)")
            }
            _ => {
                let most = params.positional.saturating_sub(1);
                let s = plural(most);
                format!("{called} takes at most {most} positional argument{s} ({given} given)")
            }
        };
        let missing = |place: usize| {
            let name = self.core.symbols.name(*names.get(place)?);
            let place = place + 1;
            Some(format!(
                "{called} missing required argument '{name}' (pos {place})"
            ))
        };
        Some(self.type_error(match *misfit {
            ArgumentMismatch::TooMany(given) => too_many(given.checked_sub(1)?),
            ArgumentMismatch::Missing(place, slots) => {
                // Dates look at each argument before they miss the next.
                let dates = called == "function";
                let wrong = slots
                    .get(1..place)?
                    .iter()
                    .find(|value| !self.has_index(value));
                if let (true, Some(wrong)) = (dates, wrong) {
                    return self.to_int(wrong).err();
                }
                missing(place.checked_sub(1)?)?
            }
            ArgumentMismatch::Keyword(name, given, keywords) => {
                let given = given.checked_sub(1)?;
                let defaults = function.defaults.borrow().len();
                let required = names
                    .iter()
                    .take(params.positional.saturating_sub(1 + defaults));
                let is_given = |name: &Symbol| keywords.iter().any(|(given, _)| given == name);
                let mut left = required
                    .enumerate()
                    .skip(given)
                    .filter(|(_, name)| !is_given(name));
                match left.next() {
                    _ if given + keywords.len() > names.len() => too_many(given + keywords.len()),
                    Some((place, _)) => missing(place)?,
                    None => {
                        let name = self.core.symbols.name(name);
                        format!("'{name}' is an invalid keyword argument for {invalid}")
                    }
                }
            }
        }))
    }
}
