//! What the report of an uncaught exception adds for the person who wrote the program: the name that was probably
//! meant, how a function is to be called. Computed only when a report is made.

use std::collections::BTreeSet;
use std::rc::Rc;

use elite_syntax::{habit_advice, nearest};
use messages::{Text, text};

use crate::builtins::Builtin;
use crate::eval::Evaluator;
use crate::value::symbol::known;
use crate::value::{Function, Instance, Unwind, Value};

/// Longest text of a default in a signature, in characters.
const DEFAULT_MAX: usize = 20;

impl Evaluator<'_> {
    /// Notes in an exception how the function is to be called.
    #[cold]
    pub fn with_signature(&self, raised: Unwind, function: &Function) -> Unwind {
        note(raised, || self.signature_of(function))
    }

    /// Notes in an exception how a function of the embedder is to be called.
    #[cold]
    pub fn with_native_signature(&self, raised: Unwind, builtin: &Builtin) -> Unwind {
        match &builtin.body {
            crate::builtins::BuiltinBody::Native(_) => note(raised, || {
                builtin
                    .signature
                    .to_call_text(builtin.name, &self.core.symbols)
            }),
            _ => raised,
        }
    }

    fn signature_of(&self, function: &Function) -> String {
        let (code, params) = (&function.code, &function.code.params);
        let name = |index: usize| self.core.symbols.name(params.names[index]);
        // A copy, because showing a default may run script code.
        let defaults = function.defaults.get();
        let first_default = params.positional - defaults.len().min(params.positional);
        let mut parts: Vec<String> = Vec::new();
        for index in 0..params.positional {
            let default = index
                .checked_sub(first_default)
                .and_then(|index| defaults.get(index));
            parts.push(self.parameter(&name(index), default));
            if index + 1 == params.positional_only {
                parts.push("/".to_owned());
            }
        }
        let keyword_only = params.positional..params.names.len();
        match params.star {
            Some(slot) => {
                let star = self.core.symbols.name(code.slot_names[slot]);
                parts.push(format!("*{star}"));
            }
            None if !keyword_only.is_empty() => parts.push("*".to_owned()),
            None => {}
        }
        for (index, default) in keyword_only.zip(&function.keyword_defaults) {
            parts.push(self.parameter(&name(index), default.if_given()));
        }
        if let Some(slot) = params.double_star {
            let star = self.core.symbols.name(code.slot_names[slot]);
            parts.push(format!("**{star}"));
        }
        format!("{}({})", code.qualname, parts.join(", "))
    }

    fn parameter(&self, name: &str, default: Option<&Value>) -> String {
        // Only values whose text runs no code of the script.
        let shown = match default {
            None => return name.to_owned(),
            Some(Value::Instance(_)) => None,
            Some(value) => self.repr(value).ok(),
        };
        match shown {
            Some(text) if text.chars().count() <= DEFAULT_MAX => format!("{name}={text}"),
            _ => format!("{name}=…"),
        }
    }

    /// What to add to the report of an exception.
    pub fn advice(&self, exception: &Rc<Instance>) -> Option<Text> {
        let state = exception.exception()?;
        if let Some(help) = &*state.help.borrow() {
            return Some((**help).clone());
        }
        if let Some(signature) = &*state.signature.borrow() {
            return Some(text!("call it as {signature}", "调用写作 {signature}"));
        }
        let own = |name: &str| {
            let symbol = self.core.symbols.find(name)?;
            exception.get(symbol, &self.core.symbols)
        };
        let Some(Value::Str(name)) = own("name") else {
            return self.advice_of_type_error(exception);
        };
        let candidates = match own("obj") {
            Some(object) => self.attribute_names(&object),
            None if &*exception.class.name() == "NameError" => self.global_names(),
            None => return None,
        };
        match nearest(name.as_str(), candidates.iter()) {
            Some(near) => Some(text!("did you mean '{near}'", "是否想写 '{near}'")),
            None => habit_advice(name.as_str()),
        }
    }

    /// What to do about the usual errors of types.
    fn advice_of_type_error(&self, exception: &Rc<Instance>) -> Option<Text> {
        if &*exception.class.name() != "TypeError" {
            return None;
        }
        let state = exception.exception()?;
        let args = state.args().as_items()?;
        let Some(Value::Str(said)) = args.first() else {
            return None;
        };
        let is_concatenation = said.as_str().starts_with("can only concatenate str (not ");
        is_concatenation.then(|| text!("str(…) makes a text of a value", "str(…) 把值变成文本"))
    }

    fn global_names(&self) -> BTreeSet<Rc<str>> {
        let core = &self.core;
        let all = [core.globals.entries(), core.builtins.entries()];
        all.iter()
            .flatten()
            .map(|(name, _)| core.symbols.name(*name))
            .collect()
    }

    fn attribute_names(&self, object: &Value) -> BTreeSet<Rc<str>> {
        let symbols = &self.core.symbols;
        let mut names = BTreeSet::new();
        if let Value::Instance(instance) = object {
            for (key, _) in instance.entries(symbols) {
                if let Value::Str(name) = key {
                    names.insert(Rc::from(name.as_str()));
                }
            }
        }
        if let Value::Module(module) = object {
            let entries = module.namespace.entries();
            names.extend(entries.iter().map(|(name, _)| symbols.name(*name)));
        }
        let class = match object {
            Value::Class(class) => class,
            other => self.core.types.of(other),
        };
        for class in class.mro() {
            let attrs = class.own_attrs();
            names.extend(attrs.iter().map(|(name, _)| symbols.name(name)));
        }
        names.retain(|name| {
            !name.starts_with("__") || &**name == symbols.name(known::INIT).as_ref()
        });
        names
    }
}

fn note(raised: Unwind, signature: impl FnOnce() -> String) -> Unwind {
    if let Unwind::Exception(exception) = &raised
        && let Some(state) = exception.exception()
    {
        *state.signature.borrow_mut() = Some(signature().into());
    }
    raised
}
