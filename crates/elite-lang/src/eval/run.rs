//! Entering functions: slots, binding of arguments, checks of depth, fuel and native stack.

use std::mem::ManuallyDrop;
use std::rc::Rc;

use super::as_c::ArgumentMismatch;
use super::code::{Code, CodeKind};
use super::generator::Generator;
use super::words::PairOf;
use super::{Evaluator, Frame};
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::held::assert_no_borrows;
use crate::value::{CellVar, Dict, Function, R, Symbol, Value};

/// Slots on the native stack.
pub struct StackSlots<const N: usize>(ManuallyDrop<[Value; N]>);

impl<const N: usize> StackSlots<N> {
    /// Empty ones.
    #[inline(always)]
    pub fn empty() -> Self {
        StackSlots(ManuallyDrop::new([const { Value::Unbound }; N]))
    }

    /// The first `count` of them, at most all.
    #[inline(always)]
    pub fn first(&mut self, count: usize) -> &mut [Value] {
        &mut self.0[..count.min(N)]
    }
}

impl<const N: usize> Drop for StackSlots<N> {
    #[inline(always)]
    fn drop(&mut self) {
        for slot in self.0.iter_mut() {
            std::mem::take(slot).drop_inline();
        }
    }
}

/// Runs `inner` with `count` empty slots: on the native stack if they are few.
#[inline(always)]
pub fn with_slots<T>(count: usize, inner: impl FnOnce(&mut [Value]) -> T) -> T {
    match count {
        0..=2 => inner(&mut StackSlots::<2>::empty().0[..count]),
        3..=4 => inner(&mut StackSlots::<4>::empty().0[..count]),
        5..=8 => inner(&mut StackSlots::<8>::empty().0[..count]),
        9..=16 => inner(&mut StackSlots::<16>::empty().0[..count]),
        _ => inner(&mut vec![Value::Unbound; count]),
    }
}

impl Evaluator<'_> {
    /// Runs a function whose parameters are bound in `slots`; a generator function makes its generator.
    #[inline(always)]
    pub fn run(&self, function: &Rc<Function>, slots: &mut [Value]) -> R {
        let code = &*function.code;
        if code.kind == CodeKind::Generator {
            return Ok(self.make_generator(function, slots));
        }
        assert_no_borrows();
        let core = &*self.core;
        let depth = core.depth.get();
        if depth >= core.limits.call_depth {
            return Err(self.recursion_error());
        }
        self.safepoint()?;
        if !code.cells.is_empty() {
            make_cells(code, slots);
        }
        core.depth.set(depth + 1);
        let line = core.line.get();
        let result = if self.stack_left() >= code.stack_bytes {
            code.body.run(self, &mut Frame { slots, function })
        } else {
            self.run_on_segment(function, slots)
        };
        // The outermost function of a thread leaves the line in which it ended.
        if depth > 0 {
            core.line.set(line);
        }
        core.depth.set(depth);
        result
    }

    /// Runs a body on a further segment of stack.
    #[cold]
    #[inline(never)]
    pub fn run_on_segment(&self, function: &Rc<Function>, slots: &mut [Value]) -> R {
        let code = &*function.code;
        self.with_stack(code.stack_bytes, || {
            code.body.run(self, &mut Frame { slots, function })
        })
    }

    #[inline(never)]
    fn make_generator(&self, function: &Rc<Function>, slots: &mut [Value]) -> Value {
        make_cells(&function.code, slots);
        let slots = slots.iter_mut().map(std::mem::take).collect();
        let generator = Generator::new(self.core.clone(), function.clone(), slots);
        let generator = Rc::new(generator);
        self.core.note_generator(&generator);
        Value::Generator(generator)
    }

    /// Calls a script function with arguments that are values already.
    #[inline]
    pub fn call_function(
        &self,
        function: &Rc<Function>,
        args: &mut [Value],
        keywords: &[(Symbol, Value)],
    ) -> R {
        match keywords {
            [] => (function.code.entries.given)(function, PairOf::pack(Value::Unbound), args, self)
                .whole(),
            _ => self.call_bound(function, args, keywords),
        }
    }

    /// Calls a script function with `first` before the other arguments, and no keywords.
    #[inline]
    pub fn call_method(&self, function: &Rc<Function>, first: Value, args: &mut [Value]) -> R {
        (function.code.entries.given)(function, PairOf::pack(first), args, self).whole()
    }

    /// Calls a script function of any kind, its arguments bound as Python does.
    #[inline(never)]
    pub fn call_bound(
        &self,
        function: &Rc<Function>,
        args: &mut [Value],
        keywords: &[(Symbol, Value)],
    ) -> R {
        with_slots(function.code.slots, |slots| {
            self.bind(function, args, keywords, slots)?;
            self.run(function, slots)
        })
    }

    /// Binds arguments to the parameters of a function, as Python does.
    #[inline(never)]
    pub fn bind(
        &self,
        function: &Function,
        args: &mut [Value],
        keywords: &[(Symbol, Value)],
        slots: &mut [Value],
    ) -> R<()> {
        let params = &function.code.params;
        let given = args.len().min(params.positional);
        for (slot, arg) in slots.iter_mut().zip(&mut args[..given]) {
            *slot = std::mem::take(arg);
        }
        if let Some(star) = params.star {
            slots[star] = Value::tuple(self.take_all(&mut args[given..])?);
        }
        let mut more = params.double_star.map(|_| Dict::new());
        for (name, value) in keywords {
            // Each is looked up, and most of many are entered in a dictionary.
            self.charge(4 * WORK_PER_VALUE)?;
            match params.by_name(*name) {
                Some(index) => {
                    let slot = &mut slots[index];
                    if !slot.is_unbound() {
                        let error = self.multiple_values(function, *name);
                        return Err(self.with_signature(error, function));
                    }
                    *slot = value.clone();
                }
                None => match &mut more {
                    Some(dict) => {
                        self.dict_set(dict, self.core.symbols.to_value(*name), value.clone())?;
                    }
                    None => {
                        let error = self.unexpected_keyword(function, *name, args.len(), keywords);
                        return Err(self.with_signature(error, function));
                    }
                },
            }
        }
        if let (Some(slot), Some(dict)) = (params.double_star, more) {
            slots[slot] = Value::Dict(Rc::new(dict));
        }
        if args.len() > given && params.star.is_none() {
            let error = self.too_many_arguments(function, args.len(), slots);
            return Err(self.with_signature(error, function));
        }
        self.fill_defaults(function, slots)
    }

    /// Fills parameters that were not given with their defaults; what is still missing is an error.
    #[inline]
    pub fn fill_defaults(&self, function: &Function, slots: &mut [Value]) -> R<()> {
        let params = &function.code.params;
        let mut is_complete = true;
        {
            let defaults = function.defaults.borrow();
            // There may be more than parameters, since scripts can set them: the last ones count.
            for (index, slot) in slots[..params.positional].iter_mut().enumerate() {
                if slot.is_unbound() {
                    match (index + defaults.len())
                        .checked_sub(params.positional)
                        .and_then(|index| defaults.get(index))
                    {
                        Some(default) => slot.put(default.clone()),
                        None => is_complete = false,
                    }
                }
            }
        }
        if !is_complete {
            let error = self.missing_arguments(function, slots);
            return Err(self.with_signature(error, function));
        }
        if params.names.len() == params.positional {
            return Ok(());
        }
        if let Some(Value::Dict(dict)) = &*function.keyword_defaults_dict.borrow() {
            let names = &params.names[params.positional..];
            for (slot, name) in slots[params.positional..].iter_mut().zip(names) {
                if slot.is_unbound() {
                    let default = dict.get_str(&self.core.symbols.name(*name));
                    *slot = default.unwrap_or_default();
                }
            }
        }
        let is_set = function.keyword_defaults_dict.borrow().is_some();
        let keyword_only = slots[params.positional..params.names.len()].iter_mut();
        let keyword_only = keyword_only.filter(|_| !is_set);
        for (slot, default) in keyword_only.zip(&function.keyword_defaults) {
            if slot.is_unbound() {
                *slot = default.clone();
            }
        }
        if slots[params.positional..params.names.len()]
            .iter()
            .any(Value::is_unbound)
        {
            let error = self.missing_keyword_arguments(function, slots);
            return Err(self.with_signature(error, function));
        }
        Ok(())
    }

    #[cold]
    fn multiple_values(&self, function: &Function, name: Symbol) -> crate::value::Unwind {
        let name = self.core.symbols.name(name);
        self.type_error(format!(
            "{}() got multiple values for argument '{name}'",
            function.qualname()
        ))
    }

    #[cold]
    fn unexpected_keyword(
        &self,
        function: &Function,
        name: Symbol,
        given: usize,
        keywords: &[(Symbol, Value)],
    ) -> crate::value::Unwind {
        let (code, symbols) = (&function.code, &self.core.symbols);
        let positional_only = &code.params.names[..code.params.positional_only];
        let misused: Vec<_> = keywords
            .iter()
            .filter(|(name, _)| positional_only.contains(name))
            .collect();
        if !misused.is_empty() {
            let names: Vec<String> = misused
                .iter()
                .map(|(name, _)| symbols.name(*name).to_string())
                .collect();
            let message = "got some positional-only arguments passed as keyword arguments";
            return self.type_error(format!(
                "{}() {message}: '{}'",
                function.qualname(),
                names.join(", ")
            ));
        }
        let misfit = ArgumentMismatch::Keyword(name, given, keywords);
        if let Some(error) = self.misfit_as_c(function, &misfit) {
            return error;
        }
        let name = symbols.name(name);
        self.type_error(format!(
            "{}() got an unexpected keyword argument '{name}'",
            function.qualname()
        ))
    }

    #[cold]
    fn too_many_arguments(
        &self,
        function: &Function,
        given: usize,
        slots: &[Value],
    ) -> crate::value::Unwind {
        if let Some(error) = self.misfit_as_c(function, &ArgumentMismatch::TooMany(given)) {
            return error;
        }
        let params = &function.code.params;
        let defaults = function.defaults.borrow().len().min(params.positional);
        let takes = match defaults {
            0 => params.positional.to_string(),
            _ => format!(
                "from {} to {}",
                params.positional - defaults,
                params.positional
            ),
        };
        let plural = if params.positional == 1 && defaults == 0 {
            ""
        } else {
            "s"
        };
        let keyword_only = slots[params.positional..params.names.len()]
            .iter()
            .filter(|v| !v.is_unbound())
            .count();
        let given = if keyword_only > 0 {
            let (s, t) = (
                if given == 1 { "" } else { "s" },
                if keyword_only == 1 { "" } else { "s" },
            );
            format!(
                "{given} positional argument{s} (and {keyword_only} keyword-only argument{t}) were"
            )
        } else {
            format!("{given} {}", if given == 1 { "was" } else { "were" })
        };
        self.type_error(format!(
            "{}() takes {takes} positional argument{plural} but {given} given",
            function.qualname()
        ))
    }

    #[cold]
    fn missing_arguments(&self, function: &Function, slots: &[Value]) -> crate::value::Unwind {
        let params = &function.code.params;
        let defaults = function.defaults.borrow().len();
        let without_default = params.positional.saturating_sub(defaults);
        let missing = (0..without_default).filter(|index| slots[*index].is_unbound());
        if let Some(place) = missing.clone().next()
            && let Some(error) =
                self.misfit_as_c(function, &ArgumentMismatch::Missing(place, slots))
        {
            return error;
        }
        let names = missing.map(|index| params.names[index]).collect();
        self.missing(function, "positional", names)
    }

    #[cold]
    fn missing_keyword_arguments(
        &self,
        function: &Function,
        slots: &[Value],
    ) -> crate::value::Unwind {
        let params = &function.code.params;
        let missing =
            (params.positional..params.names.len()).filter(|index| slots[*index].is_unbound());
        let names = missing.map(|index| params.names[index]).collect();
        self.missing(function, "keyword-only", names)
    }

    fn missing(&self, function: &Function, kind: &str, names: Vec<Symbol>) -> crate::value::Unwind {
        let names: Vec<String> = names
            .iter()
            .map(|name| format!("'{}'", self.core.symbols.name(*name)))
            .collect();
        let list = match &names[..] {
            [] | [_] => names.join(""),
            [first, second] => format!("{first} and {second}"),
            [rest @ .., last] => format!("{}, and {last}", rest.join(", ")),
        };
        let plural = if names.len() == 1 { "" } else { "s" };
        let count = names.len();
        self.type_error(format!(
            "{}() missing {count} required {kind} argument{plural}: {list}",
            function.qualname()
        ))
    }
}

/// Variables that inner functions share move into cells.
pub fn make_cells(code: &Code, slots: &mut [Value]) {
    for slot in &code.cells {
        let slot = &mut slots[*slot as usize];
        *slot = Value::Cell(CellVar::new(std::mem::take(slot)));
    }
}
