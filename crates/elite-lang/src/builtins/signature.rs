//! What a builtin takes, and binding arguments to it.

use std::rc::Rc;

use super::{Builtin, BuiltinBody};
use crate::eval::Evaluator;
use crate::native::{NativeFunction, ParamKind};
use crate::value::symbol::Symbols;
use crate::value::{R, Symbol, Unwind, Value};

/// The parameters of a builtin.
#[derive(Clone, Debug, Default)]
pub struct Signature {
    params: Vec<SignatureParam>,
    /// How many must be given.
    required: usize,
    /// How many can be given by position.
    positional: usize,
    /// How many of them cannot be given by name.
    positional_only: usize,
    /// The last one takes all further positional arguments.
    var_args: bool,
}

#[derive(Clone, Debug)]
struct SignatureParam {
    name: Symbol,
    aliases: Vec<Symbol>,
    optional: bool,
}

impl Signature {
    /// Parses `"self sep? maxsplit?"`: names in order, `?` after those that may be omitted, `/` after positional-only
    /// ones, `*` before keyword-only ones, `*name` takes the rest.
    pub fn parse(text: &str, symbols: &Symbols) -> Self {
        let mut signature = Signature::default();
        let mut keyword_only = false;
        for word in text.split_whitespace() {
            match word {
                "/" => signature.positional_only = signature.params.len(),
                "*" => keyword_only = true,
                _ => {
                    let var_args = word.starts_with('*');
                    signature.var_args |= var_args;
                    let optional = word.ends_with('?') || var_args;
                    let name = symbols.intern(word.trim_start_matches('*').trim_end_matches('?'));
                    signature.params.push(SignatureParam {
                        name,
                        aliases: Vec::new(),
                        optional,
                    });
                    signature.required += usize::from(!optional);
                    signature.positional += usize::from(!keyword_only && !var_args);
                }
            }
        }
        signature
    }

    /// The parameters of a native of the embedder.
    pub fn of_native(native: &NativeFunction, symbols: &Symbols) -> Self {
        let params = native.params.iter().map(|param| SignatureParam {
            name: symbols.intern(param.name),
            aliases: param
                .aliases
                .iter()
                .map(|alias| symbols.intern(alias))
                .collect(),
            optional: param.kind != ParamKind::Required,
        });
        let params: Vec<SignatureParam> = params.collect();
        let var_args = native
            .params
            .last()
            .is_some_and(|param| param.kind == ParamKind::VarArgs);
        Signature {
            required: params.iter().filter(|param| !param.optional).count(),
            positional: params.len() - usize::from(var_args),
            positional_only: 0,
            var_args,
            params,
        }
    }

    /// How a function with this signature is called, for people.
    pub fn to_call_text(&self, name: &str, symbols: &Symbols) -> String {
        let last = self.params.len().saturating_sub(1);
        let parts = self.params.iter().enumerate().map(|(index, param)| {
            let text = symbols.name(param.name);
            match param.optional {
                true if self.var_args && index == last => format!("*{text}"),
                true => format!("{text}=…"),
                false => text.to_string(),
            }
        });
        format!("{name}({})", parts.collect::<Vec<_>>().join(", "))
    }

    /// Number of parameters, so of bound arguments.
    pub fn len(&self) -> usize {
        self.params.len()
    }

    /// Whether there are no parameters.
    pub fn is_empty(&self) -> bool {
        self.params.is_empty()
    }

    /// Whether a call with `count` positional arguments and no others needs no more than moving them.
    #[inline]
    pub fn accepts(&self, count: usize) -> bool {
        count <= self.positional && count >= self.required && !self.var_args
    }
}

impl Evaluator<'_> {
    /// Binds arguments to the parameters of a builtin, in `bound`, which has a place for each.
    pub fn bind_builtin(
        &self,
        builtin: &Builtin,
        args: &mut [Value],
        keywords: &[(Symbol, Value)],
        bound: &mut [Value],
    ) -> R<()> {
        self.bind_arguments(builtin, args, keywords, bound)
            .map_err(|raised| self.with_native_signature(raised, builtin))
    }

    fn bind_arguments(
        &self,
        builtin: &Builtin,
        args: &mut [Value],
        keywords: &[(Symbol, Value)],
        bound: &mut [Value],
    ) -> R<()> {
        let signature = &builtin.signature;
        let given = args.len().min(signature.positional);
        let all = args.len() + keywords.len();
        let is_native = matches!(builtin.body, BuiltinBody::Native(_));
        if let Some((name, _)) = keywords.first()
            && takes_no_names(builtin)
        {
            return Err(self.builtin_keyword_error(builtin, *name));
        }
        if !signature.var_args && (args.len() > given || all > signature.len() && !is_native) {
            if is_sorted(builtin) && args.len() == 1 {
                let count = keywords.len();
                let text = format!("sort() takes at most 2 keyword arguments ({count} given)");
                return Err(self.type_error(text));
            }
            return Err(self.builtin_count_error(builtin, all));
        }
        for (place, arg) in bound.iter_mut().zip(&mut args[..given]) {
            *place = std::mem::take(arg);
        }
        if signature.var_args {
            bound[signature.len() - 1] = Value::tuple(self.take_all(&mut args[given..])?);
        }
        // An argument that is missing is named first, then what is given twice, then what is unknown.
        let (mut twice, mut unknown) = (None, None);
        for (name, value) in keywords {
            let by_name = signature
                .params
                .iter()
                .enumerate()
                .skip(signature.positional_only);
            let named = by_name.take(signature.len() - usize::from(signature.var_args));
            let found =
                { named }.find(|(_, param)| param.name == *name || param.aliases.contains(name));
            let Some((index, _)) = found else {
                if is_native {
                    return Err(self.builtin_keyword_error(builtin, *name));
                }
                unknown.get_or_insert(*name);
                continue;
            };
            if !bound[index].is_unbound() {
                let (name, label) = (self.core.symbols.name(*name), builtin.label());
                if is_native || index >= given {
                    return Err(self.type_error(format!(
                        "{label}() got multiple values for argument '{name}'"
                    )));
                }
                twice.get_or_insert((name, index));
                continue;
            }
            bound[index] = value.clone();
        }
        let missing = signature
            .params
            .iter()
            .zip(&*bound)
            .position(|(param, value)| !param.optional && value.is_unbound());
        match (missing, twice, unknown) {
            (None, None, None) => Ok(()),
            (None, None, Some(name)) => Err(self.builtin_keyword_error(builtin, name)),
            (None, Some((name, index)), _) => {
                let label = spoken_name(builtin);
                let place = index + usize::from(builtin.owner.is_none());
                Err(self.type_error(format!(
                    "argument for {label}() given by name ('{name}') and position ({place})"
                )))
            }
            (Some(index), _, _) => {
                // Where parameters are by position only, just their arguments are counted.
                let counted = match signature.positional_only > index {
                    true => args.len(),
                    false => all,
                };
                Err(self.builtin_missing_error(builtin, index, counted))
            }
        }
    }

    #[cold]
    fn builtin_keyword_error(&self, builtin: &Builtin, name: Symbol) -> Unwind {
        let (name, label) = (self.core.symbols.name(name), builtin.full_label());
        if takes_no_names(builtin) {
            if builtin.is_slot && !matches!(builtin.name, "__init__" | "__new__" | "__call__") {
                let text = format!("wrapper {}() takes no keyword arguments", builtin.name);
                return self.type_error(text);
            }
            return self.type_error(format!("{label}() takes no keyword arguments"));
        }
        if let BuiltinBody::Native(_) = &builtin.body {
            return self.type_error(format!(
                "{label}() got an unexpected keyword argument '{name}'"
            ));
        }
        // `sorted` hands its keywords on to `list.sort`.
        let function = if is_sorted(builtin) {
            "sort"
        } else {
            spoken_name(builtin)
        };
        self.type_error(format!(
            "'{name}' is an invalid keyword argument for {function}()"
        ))
    }

    /// A wrong number of positional arguments, in the words CPython has for the different kinds of builtins.
    #[cold]
    pub fn builtin_count_error(&self, builtin: &Builtin, given: usize) -> Unwind {
        let signature = &builtin.signature;
        // A method's receiver is not counted.
        let receiver = usize::from(builtin.owner.is_some());
        let (given, required) = (
            given.saturating_sub(receiver),
            signature.required.saturating_sub(receiver),
        );
        let most = if signature.var_args {
            usize::MAX
        } else {
            signature.positional.saturating_sub(receiver)
        };
        let label = builtin.full_label();
        let plural = |count: usize| if count == 1 { "" } else { "s" };
        if builtin.name == "str" && builtin.owner.is_none() {
            return self.type_error(format!("str() takes at most 3 arguments ({given} given)"));
        }
        if most == 0 && builtin.name == "object" {
            return self.type_error("object() takes no arguments");
        }
        if builtin.name == "sort" && builtin.owner == Some("list") {
            return self.type_error(match given > 2 {
                true => format!("sort() takes at most 2 arguments ({given} given)"),
                false => "sort() takes no positional arguments".to_owned(),
            });
        }
        if parses_by_format(builtin) {
            let (word, bound) = match given < required {
                _ if required == most => ("exactly", most),
                true => ("at least", required),
                false => ("at most", most),
            };
            return self.type_error(format!(
                "{}() takes {word} {bound} argument{} ({given} given)",
                builtin.name,
                plural(bound)
            ));
        }
        if builtin.is_slot && required == most && builtin.name != "__init__" {
            // CPython unpacks these arguments under a name that is empty.
            let repeats = matches!(builtin.name, "__mul__" | "__rmul__" | "__imul__")
                && matches!(
                    builtin.owner,
                    Some("str" | "list" | "tuple" | "bytes" | "bytearray" | "deque")
                );
            let blank = if most == 2 || repeats { " " } else { "" };
            let text = format!(
                "{blank}expected {most} argument{}, got {given}",
                plural(most)
            );
            return self.type_error(text);
        }
        if most == 0 {
            return self.type_error(format!("{label}() takes no arguments ({given} given)"));
        }
        let by_tuple =
            ["sorted", "classmethod", "staticmethod", "cycle", "pairwise"].contains(&builtin.name);
        if required == most && most == 1 && !by_tuple {
            return self.type_error(format!(
                "{label}() takes exactly one argument ({given} given)"
            ));
        }
        let name = spoken_name(builtin);
        let keywords = signature.positional_only.max(receiver) < signature.positional
            && !matches!(builtin.body, BuiltinBody::Native(_));
        if keywords && given > most {
            // Arguments by name only count as long as there are not more arguments than parameters in all.
            let all = signature.len() - receiver;
            let (most, kind) = match given > all {
                true => (all, ""),
                false => (most, "positional "),
            };
            let word = if required == most {
                "exactly"
            } else {
                "at most"
            };
            return self.type_error(format!(
                "{name}() takes {word} {most} {kind}argument{} ({given} given)",
                plural(most)
            ));
        }
        if keywords && given < required && !by_tuple {
            let word = if required == most {
                "exactly"
            } else {
                "at least"
            };
            return self.type_error(format!(
                "{name}() takes {word} {required} positional argument{} ({given} given)",
                plural(required)
            ));
        }
        // CPython unpacks the arguments of these, too, under a name that is empty.
        let optional = matches!(builtin.name, "__pow__" | "__rpow__" | "__get__");
        let name = match optional && builtin.owner.is_some() {
            true => "",
            false => name,
        };
        let name = match builtin.owner {
            Some("deque") if builtin.name == "rotate" => &*label,
            _ => name,
        };
        if required == most {
            return self.type_error(format!(
                "{name} expected {most} argument{}, got {given}",
                plural(most)
            ));
        }
        if given < required {
            return self.type_error(format!(
                "{name} expected at least {required} argument{}, got {given}",
                plural(required)
            ));
        }
        self.type_error(format!(
            "{name} expected at most {most} argument{}, got {given}",
            plural(most)
        ))
    }

    /// What a method called as a function says of a receiver that is none, in CPython's words for methods and for what
    /// fills a slot of C.
    #[cold]
    pub fn receiver_error(&self, builtin: &Builtin, receiver: Option<&Value>) -> Unwind {
        let (name, own) = (builtin.name, builtin.owner.unwrap_or_default());
        let owner = self.owner_of(builtin);
        let given = receiver.map(|receiver| self.core.types.name_of(receiver));
        self.type_error(match (given, builtin.is_slot) {
            (None, true) => format!("descriptor '{name}' of '{owner}' object needs an argument"),
            (None, false) => format!("unbound method {own}.{name}() needs an argument"),
            (Some(given), true) => {
                format!("descriptor '{name}' requires a '{owner}' object but received a '{given}'")
            }
            (Some(given), false) => format!(
                "descriptor '{name}' for '{owner}' objects doesn't apply to a '{given}' object"
            ),
        })
    }

    #[cold]
    fn builtin_missing_error(&self, builtin: &Builtin, index: usize, given: usize) -> Unwind {
        let signature = &builtin.signature;
        if index == 0 && builtin.owner.is_some() {
            return self.receiver_error(builtin, None);
        }
        if signature.positional_only > index {
            return self.builtin_count_error(builtin, given);
        }
        let (label, name) = (
            spoken_name(builtin),
            self.core.symbols.name(signature.params[index].name),
        );
        if builtin.name == "enumerate" {
            return self.type_error("enumerate() missing required argument 'iterable'");
        }
        let place = index + usize::from(builtin.owner.is_none());
        self.type_error(format!(
            "{label}() missing required argument '{name}' (pos {place})"
        ))
    }
}

/// What messages about arguments call it: `__init__` is called as its class.
fn spoken_name(builtin: &Builtin) -> &'static str {
    match (builtin.name, builtin.owner) {
        ("__init__", Some(owner)) => owner,
        (name, _) => name,
    }
}

fn is_sorted(builtin: &Builtin) -> bool {
    builtin.name == "sorted" && builtin.owner.is_none()
}

/// Whether nothing can be given by name. The receiver of a method never can.
fn takes_no_names(builtin: &Builtin) -> bool {
    let signature = &builtin.signature;
    let receiver = usize::from(builtin.owner.is_some());
    let by_place = signature.positional_only.max(receiver);
    by_place + usize::from(signature.var_args) >= signature.len()
}

/// Whether CPython's method of this name is a slot of its type, not an entry in the table of methods.
pub fn is_slot(owner: Option<&str>, name: &str) -> bool {
    const IN_TABLE: &[&str] = &[
        "__bytes__",
        "__ceil__",
        "__class_getitem__",
        "__complex__",
        "__copy__",
        "__deepcopy__",
        "__dir__",
        "__enter__",
        "__exit__",
        "__floor__",
        "__format__",
        "__getnewargs__",
        "__getstate__",
        "__init_subclass__",
        "__instancecheck__",
        "__length_hint__",
        "__missing__",
        "__prepare__",
        "__reduce__",
        "__reduce_ex__",
        "__reversed__",
        "__round__",
        "__set_name__",
        "__setstate__",
        "__sizeof__",
        "__subclasscheck__",
        "__subclasses__",
        "__subclasshook__",
        "__trunc__",
    ];
    let Some(owner) = owner else {
        return false;
    };
    let is_method_too = match name {
        "__getitem__" => matches!(owner, "list" | "dict"),
        "__contains__" => matches!(owner, "dict" | "set" | "frozenset"),
        _ => IN_TABLE.contains(&name),
    };
    name.starts_with("__") && !is_method_too
}

/// Methods whose arguments CPython parses by a format string, which has words of its own for wrong counts.
fn parses_by_format(builtin: &Builtin) -> bool {
    if builtin.owner == Some("deque") {
        return matches!(builtin.name, "index" | "insert");
    }
    matches!(builtin.owner, Some("str" | "bytes" | "bytearray"))
        && matches!(
            builtin.name,
            "find"
                | "rfind"
                | "index"
                | "rindex"
                | "count"
                | "startswith"
                | "endswith"
                | "split"
                | "rsplit"
                | "splitlines"
                | "expandtabs"
                | "encode"
                | "decode"
                | "hex"
        )
}

impl Builtin {
    /// How messages name it: `type.name` for methods.
    pub fn label(&self) -> Rc<str> {
        match self.owner {
            Some(owner) => format!("{owner}.{}", self.name).into(),
            None => self.name.into(),
        }
    }

    /// How messages about the call itself name it: `type.name` for methods, `module.name` for functions of modules.
    pub fn full_label(&self) -> Rc<str> {
        match &self.module {
            Some(module) => format!("{module}.{}", self.name).into(),
            None => self.label(),
        }
    }
}
