//! The special methods of builtin types as attributes: what subclasses inherit and what `super().__getitem__(key)`
//! finds. Values of the builtin types themselves never go through these.

use std::rc::Rc;

use elite_syntax::ast::{BinaryOp, CompareOp};

use super::methods;
use crate::builtins::BoundFn;
use crate::eval::{Evaluator, InterpreterState};
use crate::value::symbol::known;
use crate::value::{Class, R, Value};

/// A value, or `NotImplemented` where there is none.
fn or_not_implemented(value: Option<Value>) -> Value {
    value.unwrap_or(Value::NotImplemented)
}

/// `receiver.__op__(other)`: numbers know how to work with their own kind and simpler ones only.
fn number(ev: &Evaluator<'_>, op: BinaryOp, args: &[Value], reflected: bool) -> R {
    let (receiver, other) = (ev.unwrap_builtin(&args[0]), ev.unwrap_builtin(&args[1]));
    if rank(&other) > rank(&receiver) {
        return Ok(Value::NotImplemented);
    }
    let (a, b) = if reflected {
        (&other, &receiver)
    } else {
        (&receiver, &other)
    };
    Ok(or_not_implemented(ev.number_binary(op, a, b)?))
}

/// Where a number stands in int, float, complex; anything else is above all of them.
fn rank(value: &Value) -> u8 {
    match value {
        Value::Bool(_) | Value::Int(_) | Value::BigInt(_) => 0,
        Value::Float(_) => 1,
        Value::Complex(_) => 2,
        _ => 3,
    }
}

fn binary(ev: &Evaluator<'_>, op: BinaryOp, a: &Value, b: &Value) -> R {
    if op == BinaryOp::BitOr
        && let Some(union) = ev.dict_union(a, b)?
    {
        return Ok(union);
    }
    let (a, b) = (ev.unwrap_builtin(a), ev.unwrap_builtin(b));
    if let Some(value) = ev.number_binary(op, &a, &b)? {
        return Ok(value);
    }
    ev.builtin_binary(op, &a, &b).map(or_not_implemented)
}

fn compare(ev: &Evaluator<'_>, op: CompareOp, a: &Value, b: &Value) -> R {
    let (a, b) = (ev.unwrap_builtin(a), ev.unwrap_builtin(b));
    if rank(&a) == 0 && matches!(b, Value::Float(_) | Value::Complex(_))
        || rank(&a) == 1 && rank(&b) == 2
        || matches!((&a, &b), (Value::Bytes(_), Value::ByteArray(_)))
    {
        return Ok(Value::NotImplemented);
    }
    if let Some(flag) = crate::ops::compare::fast(op, &a, &b) {
        return Ok(Value::Bool(flag));
    }
    Ok(or_not_implemented(
        ev.builtin_compare(op, &a, &b)?.map(Value::Bool),
    ))
}

/// `receiver + other` or `receiver * other` of a sequence, which leaves nothing to `other`.
fn joined(ev: &Evaluator<'_>, op: BinaryOp, a: &Value, b: &Value) -> R {
    let own = ev.unwrap_builtin(a);
    let made = match op {
        BinaryOp::Mul => ev.builtin_binary(op, &own, b),
        _ => ev.builtin_binary(op, &own, &ev.unwrap_builtin(b)),
    };
    if let Some(made) = made? {
        return Ok(made);
    }
    if op == BinaryOp::Mul {
        ev.index(b)?;
    }
    Err(ev.unsupported_operand(op, a, b, "+"))
}

macro_rules! binary_methods {
    ($($name:literal = $op:ident, $reflected:literal;)*) => {
        &[$(
            ($name, "other /", |ev, args| binary(ev, BinaryOp::$op, &args[0], &args[1])),
            ($reflected, "other /", |ev, args| binary(ev, BinaryOp::$op, &args[1], &args[0])),
        )*]
    };
}

macro_rules! number_methods {
    ($($name:literal = $op:ident, $reflected:literal;)*) => {
        &[$(
            ($name, "other /", |ev, args| number(ev, BinaryOp::$op, args, false)),
            ($reflected, "other /", |ev, args| number(ev, BinaryOp::$op, args, true)),
        )*]
    };
}

macro_rules! in_place_methods {
    ($($name:literal = $op:ident;)*) => {
        &[$(($name, "other /", |ev, args| {
            let target = ev.unwrap_builtin(&args[0]);
            // What a sequence takes item by item is asked as what it is.
            let other = match target {
                Value::List(_) | Value::ByteArray(_) | Value::Dict(_) => args[1].clone(),
                _ => ev.unwrap_builtin(&args[1]),
            };
            let done = ev.builtin_in_place(BinaryOp::$op, &target, &other)?;
            if done.is_none() && matches!(target, Value::List(_) | Value::ByteArray(_)) {
                return joined(ev, BinaryOp::$op, &args[0], &args[1]);
            }
            Ok(if done.is_some() { args[0].clone() } else { Value::NotImplemented })
        }),)*]
    };
}

type MethodTable = &'static [(&'static str, &'static str, BoundFn)];

const COMPARISONS: MethodTable = &[
    ("__eq__", "other /", |ev, args| {
        compare(ev, CompareOp::Eq, &args[0], &args[1])
    }),
    ("__ne__", "other /", |ev, args| {
        compare(ev, CompareOp::Ne, &args[0], &args[1])
    }),
    ("__lt__", "other /", |ev, args| {
        compare(ev, CompareOp::Lt, &args[0], &args[1])
    }),
    ("__le__", "other /", |ev, args| {
        compare(ev, CompareOp::Le, &args[0], &args[1])
    }),
    ("__gt__", "other /", |ev, args| {
        compare(ev, CompareOp::Gt, &args[0], &args[1])
    }),
    ("__ge__", "other /", |ev, args| {
        compare(ev, CompareOp::Ge, &args[0], &args[1])
    }),
];

const HASH: MethodTable = &[("__hash__", "", |ev, args| {
    ev.hash(&ev.unwrap_builtin(&args[0]))
        .map(|hash| Value::Int(hash as i64))
})];

const REPR: MethodTable = &[("__repr__", "", |ev, args| {
    ev.new_str(ev.extended_repr(&args[0])?)
})];

/// For types whose text is that of their own `__repr__`, whatever a derived class has under that name.
const STR_BY_REPR: MethodTable = &[("__str__", "", |ev, args| {
    ev.new_str(ev.extended_repr(&args[0])?)
})];

const FORMAT: MethodTable = &[("__format__", "spec /", |ev, args| {
    let mut out = String::new();
    super::check_spec(ev, &args[1])?;
    let spec = ev.str(&args[1])?;
    if spec.is_empty() {
        return ev.str_value(&args[0]);
    }
    let plain = ev.unwrap_builtin(&args[0]);
    let name = ev.core.types.name_of(&args[0]);
    ev.format_by_spec(&plain, &spec, &name, &mut out)?;
    ev.new_str(out)
})];

const NUMBERS: MethodTable = number_methods! {
    "__add__" = Add, "__radd__"; "__sub__" = Sub, "__rsub__"; "__mul__" = Mul, "__rmul__";
    "__truediv__" = Div, "__rtruediv__";
};

/// Methods of numbers that have an order.
const REMAINDERS: MethodTable = number_methods! {
    "__floordiv__" = FloorDiv, "__rfloordiv__"; "__mod__" = Mod, "__rmod__";
};

const POWERS: MethodTable = &[
    ("__pow__", "other modulus? /", |ev, args| {
        power(ev, args, false)
    }),
    ("__rpow__", "other modulus? /", |ev, args| {
        power(ev, args, true)
    }),
];

/// `receiver.__pow__(other, modulus)`
fn power(ev: &Evaluator<'_>, args: &[Value], reflected: bool) -> R {
    let Some(modulus) = args[2].if_given().filter(|modulus| !modulus.is_none()) else {
        return number(ev, BinaryOp::Pow, args, reflected);
    };
    let (receiver, other) = (ev.unwrap_builtin(&args[0]), ev.unwrap_builtin(&args[1]));
    let modulus = ev.unwrap_builtin(modulus);
    match rank(&receiver) {
        0 if rank(&other) > 0 || rank(&modulus) > 0 => return Ok(Value::NotImplemented),
        2 if rank(&other) > 2 => return Ok(Value::NotImplemented),
        2 => return Err(ev.value_error("complex modulo")),
        _ => {}
    }
    let mut given = match reflected {
        true => [other, receiver, modulus],
        false => [receiver, other, modulus],
    };
    crate::builtins::numbers::pow(ev, &mut given)
}

const BITS: MethodTable = number_methods! {
    "__and__" = BitAnd, "__rand__"; "__or__" = BitOr, "__ror__"; "__xor__" = BitXor, "__rxor__";
};

const SHIFTS: MethodTable = number_methods! {
    "__lshift__" = Shl, "__rlshift__"; "__rshift__" = Shr, "__rrshift__";
};

macro_rules! integer_bits {
    ($($name:literal = $op:ident, $reflected:literal;)*) => {
        &[$(
            ($name, "other /", |ev, args| integer_bits(ev, BinaryOp::$op, args, false)),
            ($reflected, "other /", |ev, args| integer_bits(ev, BinaryOp::$op, args, true)),
        )*]
    };
}

const INTEGER_BITS: MethodTable = integer_bits! {
    "__and__" = BitAnd, "__rand__"; "__or__" = BitOr, "__ror__"; "__xor__" = BitXor, "__rxor__";
};

/// A bit operation of an integer's method, which gives a number for two truth values, too.
fn integer_bits(ev: &Evaluator<'_>, op: BinaryOp, args: &[Value], reflected: bool) -> R {
    Ok(match number(ev, op, args, reflected)? {
        Value::Bool(flag) => Value::Int(i64::from(flag)),
        other => other,
    })
}

/// For types whose text is neither that of any object nor made elsewhere.
const OWN_TEXT: MethodTable = &[("__repr__", "", |ev, args| {
    ev.new_str(match &args[0] {
        Value::Instance(_) => ev.natural_repr(&args[0])?,
        Value::Class(_) => ev.object_repr(&args[0])?,
        other => ev.repr(other)?,
    })
})];

const CONVERSIONS: MethodTable = &[
    ("__int__", "", |ev, args| {
        ev.int_of(&ev.unwrap_builtin(&args[0]))
    }),
    ("__trunc__", "", |ev, args| {
        ev.int_of(&ev.unwrap_builtin(&args[0]))
    }),
    ("__float__", "", |ev, args| {
        ev.to_f64(&ev.unwrap_builtin(&args[0])).map(Value::Float)
    }),
    ("__bool__", "", |ev, args| {
        ev.truth(&ev.unwrap_builtin(&args[0])).map(Value::Bool)
    }),
    ("__neg__", "", |ev, args| {
        ev.unary(
            elite_syntax::ast::UnaryOp::Neg,
            &ev.unwrap_builtin(&args[0]),
        )
    }),
    ("__pos__", "", |ev, args| {
        ev.unary(
            elite_syntax::ast::UnaryOp::Pos,
            &ev.unwrap_builtin(&args[0]),
        )
    }),
    ("__abs__", "", |ev, args| {
        let abs = ev
            .core
            .builtins
            .get(ev.core.symbols.intern("abs"))
            .unwrap_or_default();
        ev.call1(&abs, ev.unwrap_builtin(&args[0]))
    }),
    ("__round__", "ndigits? /", |ev, args| {
        let round = ev
            .core
            .builtins
            .get(ev.core.symbols.intern("round"))
            .unwrap_or_default();
        let mut given = vec![ev.unwrap_builtin(&args[0])];
        if !matches!(given[0], Value::Float(_)) && args[1].if_given().is_some() {
            // Only `round` itself takes None of an integer.
            ev.to_int(&args[1])?;
        }
        given.extend(args[1].if_given().cloned());
        ev.call(&round, &mut given, &[])
    }),
];

const DIVMOD: MethodTable = &[
    ("__divmod__", "other /", |ev, args| {
        let (a, b) = (ev.unwrap_builtin(&args[0]), ev.unwrap_builtin(&args[1]));
        if rank(&b) > rank(&a) {
            return Ok(Value::NotImplemented);
        }
        let pair = ev.number_divmod(&a, &b)?;
        Ok(or_not_implemented(
            pair.map(|(q, r)| Value::tuple(vec![q, r])),
        ))
    }),
    ("__rdivmod__", "other /", |ev, args| {
        let (a, b) = (ev.unwrap_builtin(&args[1]), ev.unwrap_builtin(&args[0]));
        if rank(&a) > rank(&b) {
            return Ok(Value::NotImplemented);
        }
        let pair = ev.number_divmod(&a, &b)?;
        Ok(or_not_implemented(
            pair.map(|(q, r)| Value::tuple(vec![q, r])),
        ))
    }),
];

const COMPLEX: MethodTable = &[(
    "__complex__",
    "",
    |ev, args| Ok(ev.unwrap_builtin(&args[0])),
)];

const INTEGER: MethodTable = &[
    ("__index__", "", |ev, args| {
        ev.to_int(&ev.unwrap_builtin(&args[0]))
            .map(crate::value::int::Int::into_value)
    }),
    ("__invert__", "", |ev, args| {
        ev.unary(
            elite_syntax::ast::UnaryOp::Invert,
            &ev.unwrap_builtin(&args[0]),
        )
    }),
];

const CONTAINER: MethodTable = &[
    ("__len__", "", |ev, args| {
        ev.len(&ev.unwrap_builtin(&args[0]))
            .map(|length| Value::Int(length as i64))
    }),
    ("__iter__", "", |ev, args| {
        ev.iter(&ev.unwrap_builtin(&args[0]))
    }),
    ("__contains__", "item /", |ev, args| {
        ev.contains(&ev.unwrap_builtin(&args[0]), &args[1])
            .map(Value::Bool)
    }),
];

const GETITEM: MethodTable = &[("__getitem__", "index /", |ev, args| {
    let container = ev.unwrap_builtin(&args[0]);
    if let (Value::Dict(dict), Value::Instance(instance)) = (&container, &args[0]) {
        if let Some(at) = ev.dict_find(dict, &args[1])? {
            return Ok(dict.value_at(at));
        }
        return match instance.class.lookup(known::MISSING) {
            Some(missing) => ev.call_method_value(&missing, &args[0], &mut [args[1].clone()]),
            None => Err(ev.key_error(&args[1])),
        };
    }
    ev.item(&container, &args[1])
})];

const SETITEM: MethodTable = &[
    ("__setitem__", "index value /", |ev, args| {
        ev.set_item(&ev.unwrap_builtin(&args[0]), &args[1], args[2].clone())
            .map(|()| Value::None)
    }),
    ("__delitem__", "index /", |ev, args| {
        ev.delete_item(&ev.unwrap_builtin(&args[0]), &args[1])
            .map(|()| Value::None)
    }),
];

const SEQUENCE: MethodTable = &[
    ("__add__", "other /", |ev, args| {
        joined(ev, BinaryOp::Add, &args[0], &args[1])
    }),
    ("__mul__", "other /", |ev, args| {
        joined(ev, BinaryOp::Mul, &args[0], &args[1])
    }),
    ("__rmul__", "other /", |ev, args| {
        joined(ev, BinaryOp::Mul, &args[0], &args[1])
    }),
];

const MODULO: MethodTable = &[
    ("__mod__", "other /", |ev, args| {
        // The argument keeps its class: its `__str__` counts.
        let format = ev.unwrap_builtin(&args[0]);
        let made = ev.builtin_binary(BinaryOp::Mod, &format, &args[1])?;
        Ok(match (&made, &format) {
            // Nothing to fill in: the format is its own result.
            (Some(Value::Str(text)), Value::Str(format))
                if !text.is_empty() && text.as_str() == format.as_str() =>
            {
                args[0].clone()
            }
            _ => or_not_implemented(made),
        })
    }),
    ("__rmod__", "other /", |ev, args| {
        let (format, own) = (ev.unwrap_builtin(&args[1]), ev.unwrap_builtin(&args[0]));
        match std::mem::discriminant(&format) == std::mem::discriminant(&own) {
            true => binary(ev, BinaryOp::Mod, &format, &own),
            false => Ok(Value::NotImplemented),
        }
    }),
];

const ALGEBRA: MethodTable = binary_methods! {
    "__and__" = BitAnd, "__rand__"; "__or__" = BitOr, "__ror__"; "__xor__" = BitXor, "__rxor__";
    "__sub__" = Sub, "__rsub__";
};

/// What views of keys and items have, with anything that can be gone through: always a new set.
fn of_view(ev: &Evaluator<'_>, op: BinaryOp, a: &Value, b: &Value) -> R {
    let set = |value: &Value| -> R {
        let set = crate::value::Set::new();
        ev.set_extend(&set, value)?;
        Ok(Value::Set(Rc::new(set)))
    };
    let (own, other) = (set(a)?, set(b)?);
    binary(ev, op, &own, &other)
}

macro_rules! view_methods {
    ($($name:literal = $op:ident, $reflected:literal;)*) => {
        &[$(
            ($name, "other /", |ev, args| of_view(ev, BinaryOp::$op, &args[0], &args[1])),
            ($reflected, "other /", |ev, args| of_view(ev, BinaryOp::$op, &args[1], &args[0])),
        )*]
    };
}

const VIEW_ALGEBRA: MethodTable = view_methods! {
    "__and__" = BitAnd, "__rand__"; "__or__" = BitOr, "__ror__"; "__xor__" = BitXor, "__rxor__";
    "__sub__" = Sub, "__rsub__";
};

const DICT_IN_PLACE: MethodTable = in_place_methods! { "__ior__" = BitOr; };
const SEQUENCE_IN_PLACE: MethodTable = in_place_methods! { "__iadd__" = Add; "__imul__" = Mul; };
const SET_IN_PLACE: MethodTable = in_place_methods! {
    "__iand__" = BitAnd; "__ior__" = BitOr; "__ixor__" = BitXor; "__isub__" = Sub;
};

const NEXT: MethodTable = &[
    ("__iter__", "", |_, args| Ok(args[0].clone())),
    ("__next__", "", |ev, args| {
        match ev.step_with(&ev.unwrap_builtin(&args[0]), Value::None)? {
            crate::eval::generator::StepResult::Yielded(value) => Ok(value),
            crate::eval::generator::StepResult::Returned(value) => ev.stop_iteration(value),
        }
    }),
];

/// Gives a class of iterators `__iter__` and `__next__`.
pub fn install_next(core: &Rc<InterpreterState>, class: &Rc<Class>) {
    methods(core, class, NEXT);
}

pub(super) fn install(core: &Rc<InterpreterState>) {
    let types = &core.types;
    let give = |class: &Rc<Class>, lists: &[MethodTable]| {
        lists.iter().for_each(|list| methods(core, class, list))
    };
    give(
        &types.int,
        &[
            COMPARISONS,
            HASH,
            REPR,
            FORMAT,
            NUMBERS,
            REMAINDERS,
            POWERS,
            DIVMOD,
            INTEGER_BITS,
            SHIFTS,
            CONVERSIONS,
            INTEGER,
        ],
    );
    give(&types.bool, &[BITS, OWN_TEXT]);
    give(
        &types.float,
        &[
            COMPARISONS,
            HASH,
            REPR,
            FORMAT,
            NUMBERS,
            REMAINDERS,
            POWERS,
            DIVMOD,
            CONVERSIONS,
        ],
    );
    let conversions = &CONVERSIONS[3..7];
    methods(core, &types.complex, conversions);
    give(
        &types.complex,
        &[COMPARISONS, HASH, REPR, FORMAT, NUMBERS, POWERS, COMPLEX],
    );
    give(
        &types.str,
        &[
            COMPARISONS,
            HASH,
            REPR,
            FORMAT,
            CONTAINER,
            GETITEM,
            SEQUENCE,
            MODULO,
        ],
    );
    give(
        &types.bytes,
        &[
            COMPARISONS,
            HASH,
            REPR,
            STR_BY_REPR,
            CONTAINER,
            GETITEM,
            SEQUENCE,
            MODULO,
        ],
    );
    give(
        &types.bytearray,
        &[
            COMPARISONS,
            REPR,
            STR_BY_REPR,
            CONTAINER,
            GETITEM,
            SETITEM,
            SEQUENCE,
            SEQUENCE_IN_PLACE,
            MODULO,
        ],
    );
    give(
        &types.list,
        &[
            COMPARISONS,
            REPR,
            CONTAINER,
            GETITEM,
            SETITEM,
            SEQUENCE,
            SEQUENCE_IN_PLACE,
        ],
    );
    give(
        &types.tuple,
        &[COMPARISONS, HASH, REPR, CONTAINER, GETITEM, SEQUENCE],
    );
    give(
        &types.dict,
        &[
            COMPARISONS,
            REPR,
            CONTAINER,
            GETITEM,
            SETITEM,
            DICT_IN_PLACE,
        ],
    );
    methods(
        core,
        &types.dict,
        &[
            ("__or__", "other /", |ev, args| {
                binary(ev, BinaryOp::BitOr, &args[0], &args[1])
            }),
            ("__ror__", "other /", |ev, args| {
                binary(ev, BinaryOp::BitOr, &args[1], &args[0])
            }),
        ],
    );
    give(
        &types.set,
        &[COMPARISONS, REPR, CONTAINER, ALGEBRA, SET_IN_PLACE],
    );
    give(
        &types.frozenset,
        &[COMPARISONS, HASH, REPR, CONTAINER, ALGEBRA],
    );
    give(
        &types.range,
        &[
            COMPARISONS,
            HASH,
            CONTAINER,
            GETITEM,
            &[("__reversed__", "", super::iterators::reversed)],
        ],
    );
    for class in [&types.range, &types.none, &types.not_implemented] {
        give(class, &[&CONVERSIONS[3..4]]);
    }
    methods(
        core,
        &types.str,
        &[("__str__", "", |ev, args| Ok(ev.unwrap_builtin(&args[0])))],
    );
    for view in [&types.dict_keys, &types.dict_values, &types.dict_items] {
        give(view, &[CONTAINER, OWN_TEXT]);
    }
    for view in [&types.dict_keys, &types.dict_items] {
        give(view, &[VIEW_ALGEBRA]);
    }
    for class in [
        &types.none,
        &types.ellipsis,
        &types.not_implemented,
        &types.range,
        &types.slice,
        &types.function,
        &types.method,
        &types.builtin,
        &types.method_descriptor,
        &types.wrapper_descriptor,
        &types.method_wrapper,
        &types.type_,
        &types.module,
        &types.generator,
        &types.staticmethod,
        &types.classmethod,
        &types.super_,
        &types.cell,
        &types.frame,
        &types.code,
    ] {
        give(class, &[OWN_TEXT]);
    }
    for iterator in types.iterators().into_iter().chain([&types.generator]) {
        give(iterator, &[NEXT]);
    }
    for class in [
        &types.list,
        &types.dict,
        &types.set,
        &types.bytearray,
        &types.dict_keys,
        &types.dict_items,
    ] {
        class.set(known::HASH, Value::None);
    }
}
