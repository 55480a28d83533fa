//! Values are counted without asking of what kind they are (`value/count.rs`): every kind has to count at the same
//! place.

use std::mem::discriminant;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::{TestHost, drive};
use crate::value::CellVar;
use elite_syntax::{KnownNames, SourceFile, compile};

use crate::{Interpreter, Limits, NativeBody, NativeFunction, Param, Value};

/// A value of every kind that a program can have.
const PROGRAM: &str = "
import math
class A:
    @property
    def p(self): return 1
    @staticmethod
    def s(): return 1
    @classmethod
    def c(cls): return 1
    def up(self): return super()
def g(): yield 1
for value in [1 << 80, 1j, 'abc' * 3, b'ab', bytearray(2), [1], (1, 2), {1: 2}, {1: 2}.keys(), {1}, frozenset([1]), \
range(3),
              range(1 << 70), slice(1), g, A().up, len, A, A(), math, iter([1]), g(), A.__dict__['p'], A.__dict__['s'],
              A.__dict__['c'], A().up(), None, 1, 1.5, True, ..., NotImplemented]:
    look(value)
";

/// References to the object of a value, asked of its own type; there is no wildcard on purpose.
fn references(value: &Value) -> Option<usize> {
    Some(match value {
        Value::Unbound
        | Value::None
        | Value::Ellipsis
        | Value::NotImplemented
        | Value::Bool(_)
        | Value::Int(_)
        | Value::Float(_) => return None,
        Value::BigInt(rc) => Rc::strong_count(rc),
        Value::Complex(rc) => Rc::strong_count(rc),
        Value::Str(rc) => Rc::strong_count(rc),
        Value::Bytes(rc) => Rc::strong_count(rc),
        Value::ByteArray(rc) => Rc::strong_count(rc),
        Value::List(rc) => Rc::strong_count(rc),
        Value::Tuple(rc) => Rc::strong_count(rc),
        Value::Dict(rc) => Rc::strong_count(rc),
        Value::DictView(rc) => Rc::strong_count(rc),
        Value::Set(rc) | Value::FrozenSet(rc) => Rc::strong_count(rc),
        Value::Range(rc) => Rc::strong_count(rc),
        Value::LongRange(rc) => Rc::strong_count(rc),
        Value::Slice(rc) => Rc::strong_count(rc),
        Value::Function(rc) => Rc::strong_count(rc),
        Value::BoundMethod(rc) => Rc::strong_count(rc),
        Value::Builtin(rc) => Rc::strong_count(rc),
        Value::Class(rc) => Rc::strong_count(rc),
        Value::Instance(rc) => Rc::strong_count(rc),
        Value::Module(rc) => Rc::strong_count(rc),
        Value::Iter(rc) => Rc::strong_count(rc),
        Value::Generator(rc) => Rc::strong_count(rc),
        Value::Property(rc) => Rc::strong_count(rc),
        Value::StaticMethod(rc) | Value::ClassMethod(rc) => Rc::strong_count(rc),
        Value::Super(rc) => Rc::strong_count(rc),
        Value::Cell(rc) => Rc::strong_count(rc),
        Value::Code(rc) => Rc::strong_count(rc),
    })
}

fn counts_as_its_type_does(value: &Value) {
    let counted = || value.ref_counts().map(Rc::strong_count);
    let before = references(value);
    assert_eq!(counted(), before);
    let copy = value.clone();
    assert_eq!(discriminant(&copy), discriminant(value));
    assert_eq!(copy.address(), value.address());
    assert_eq!(references(value), before.map(|count| count + 1));
    assert_eq!(counted(), references(value));
    copy.drop_inline();
    assert_eq!(references(value), before);
}

#[test]
fn all_kinds_of_values_count_at_the_same_place() {
    let stage = Rc::new(TestHost::default());
    let looked = Arc::new(AtomicUsize::new(0));
    let count = looked.clone();
    let native = NativeFunction {
        name: "look",
        params: vec![Param::required("value")],
        call: NativeBody::new(move |call| {
            counts_as_its_type_does(&call.args()[0]);
            count.fetch_add(1, Ordering::Relaxed);
            if let Value::Function(function) = &call.args()[0] {
                counts_as_its_type_does(&Value::Code(function.code.clone()));
            }
            Ok(Value::None)
        }),
    };
    let known = KnownNames::new(["look"]);
    let interpreter = Interpreter::new(stage.clone(), vec![native], Limits::default());
    let program = compile(SourceFile::new("trial", PROGRAM), &known);
    let program = program.unwrap_or_else(|_| panic!("it compiles"));
    assert_eq!(drive(&stage, interpreter.spawn_program(&program)), "");
    assert_eq!(looked.load(Ordering::Relaxed), 32);
    counts_as_its_type_does(&Value::Cell(CellVar::new(Value::Int(1))));
}
