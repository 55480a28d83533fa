"""Names for annotations, which mean nothing when a program runs."""


class _Name:
    def __init__(self, name):
        self._name = name

    def __getitem__(self, parameters):
        return self

    def __or__(self, other):
        return self

    __ror__ = __or__

    def __call__(self, *args, **kwargs):
        raise TypeError(f"Cannot instantiate {self!r}")

    def __repr__(self):
        return f"typing.{self._name}"


Any = _Name("Any")
Union = _Name("Union")
Optional = _Name("Optional")
Callable = _Name("Callable")
List = _Name("List")
Dict = _Name("Dict")
Set = _Name("Set")
FrozenSet = _Name("FrozenSet")
Tuple = _Name("Tuple")
Type = _Name("Type")
Iterable = _Name("Iterable")
Iterator = _Name("Iterator")
Generator = _Name("Generator")
Sequence = _Name("Sequence")
Mapping = _Name("Mapping")
MutableMapping = _Name("MutableMapping")
MutableSequence = _Name("MutableSequence")
Hashable = _Name("Hashable")
Literal = _Name("Literal")
Final = _Name("Final")
ClassVar = _Name("ClassVar")
NoReturn = _Name("NoReturn")
Self = _Name("Self")
AnyStr = _Name("AnyStr")
TYPE_CHECKING = False


class Generic:
    def __class_getitem__(cls, parameters):
        return cls


class Protocol(Generic):
    pass


def TypeVar(name, *constraints, bound=None, covariant=False, contravariant=False):
    return _Name(name)


def NewType(name, tp):
    return lambda value: value


def cast(typ, val):
    return val


def overload(func):
    return func


def final(f):
    return f


def get_type_hints(obj):
    return {}


def NamedTuple(typename, fields=()):
    from collections import namedtuple
    return namedtuple(typename, [name for name, _ in fields])
