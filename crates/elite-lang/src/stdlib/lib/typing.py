"""Names for annotations, which mean nothing when a program runs."""
import sys as _sys

from _collections import namedtuple as _namedtuple


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
AbstractSet = _Name("AbstractSet")
Annotated = _Name("Annotated")
AsyncContextManager = _Name("AsyncContextManager")
AsyncGenerator = _Name("AsyncGenerator")
AsyncIterable = _Name("AsyncIterable")
AsyncIterator = _Name("AsyncIterator")
Awaitable = _Name("Awaitable")
BinaryIO = _Name("BinaryIO")
ByteString = _Name("ByteString")
ChainMap = _Name("ChainMap")
Collection = _Name("Collection")
Concatenate = _Name("Concatenate")
Container = _Name("Container")
ContextManager = _Name("ContextManager")
Coroutine = _Name("Coroutine")
Counter = _Name("Counter")
DefaultDict = _Name("DefaultDict")
Deque = _Name("Deque")
IO = _Name("IO")
ItemsView = _Name("ItemsView")
KeysView = _Name("KeysView")
LiteralString = _Name("LiteralString")
MappingView = _Name("MappingView")
Match = _Name("Match")
MutableSet = _Name("MutableSet")
Never = _Name("Never")
NotRequired = _Name("NotRequired")
OrderedDict = _Name("OrderedDict")
Pattern = _Name("Pattern")
Required = _Name("Required")
Reversible = _Name("Reversible")
Sized = _Name("Sized")
SupportsAbs = _Name("SupportsAbs")
SupportsBytes = _Name("SupportsBytes")
SupportsComplex = _Name("SupportsComplex")
SupportsFloat = _Name("SupportsFloat")
SupportsIndex = _Name("SupportsIndex")
SupportsInt = _Name("SupportsInt")
SupportsRound = _Name("SupportsRound")
TextIO = _Name("TextIO")
TypeAlias = _Name("TypeAlias")
TypeGuard = _Name("TypeGuard")
Unpack = _Name("Unpack")
ValuesView = _Name("ValuesView")
Text = str
TYPE_CHECKING = False


class Generic:
    __slots__ = ()

    def __class_getitem__(cls, parameters):
        return cls


class Protocol(Generic):
    __slots__ = ()


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


def get_type_hints(obj, globalns=None, localns=None, include_extras=False):
    """The annotations of a class (those it inherits included), a module or a function; texts are evaluated."""
    if isinstance(obj, type):
        hints = {}
        for cls in reversed(obj.__mro__):
            scope = _sys.modules.get(getattr(cls, "__module__", None))
            own = vars(scope) if globalns is None and scope is not None else globalns
            for name, hint in cls.__dict__.get("__annotations__", {}).items():
                hints[name] = _evaluated(hint, own, dict(vars(cls)) if localns is None else localns)
        return hints
    hints = getattr(obj, "__annotations__", None)
    if hints is None:
        if callable(obj) or isinstance(obj, type(_sys)):
            return {}
        raise TypeError(f"{obj!r} is not a module, class, method, or function.")
    if globalns is None:
        globalns = vars(obj) if isinstance(obj, type(_sys)) else getattr(obj, "__globals__", {})
    return {name: _evaluated(hint, globalns, localns) for name, hint in hints.items()}


def _evaluated(hint, globalns, localns):
    if isinstance(hint, str):
        hint = eval(hint, {} if globalns is None else globalns, localns)
    return type(None) if hint is None else hint


class _NamedTupleMeta(type):
    def __new__(mcls, name, bases, namespace):
        annotations = namespace.get("__annotations__", {})
        defaults = []
        for field in annotations:
            if field in namespace:
                defaults.append(namespace[field])
            elif defaults:
                raise TypeError(f"Non-default namedtuple field {field} cannot follow default field"
                                f"{'s' if len(defaults) > 1 else ''} "
                                f"{', '.join(other for other in annotations if other in namespace)}")
        made = _namedtuple(name, list(annotations), defaults=defaults)
        for key, value in namespace.items():
            if key in ("__new__", "__init__", "__slots__", "__getnewargs__", "_fields", "_field_defaults", "_make",
                       "_replace", "_asdict"):
                if key != "__slots__":
                    raise AttributeError("Cannot overwrite NamedTuple attribute " + key)
            elif key not in annotations and key != "__prepare__":
                setattr(made, key, value)
        made.__annotations__ = annotations
        return made


    def __call__(cls, typename, fields=(), /, **kwargs):
        fields = list(fields) or list(kwargs.items())
        made = _namedtuple(typename, [name for name, _ in fields])
        made.__annotations__ = dict(fields)
        return made


NamedTuple = type.__new__(_NamedTupleMeta, "NamedTuple", (), {})


class TypedDict(dict):
    """Dictionaries with known keys; the keys are not checked."""

    def __init_subclass__(cls, total=True):
        super().__init_subclass__()


def ParamSpec(name, *, bound=None, covariant=False, contravariant=False):
    return _Name(name)


def TypeVarTuple(name):
    return _Name(name)


class ForwardRef:
    def __init__(self, arg):
        self.__forward_arg__ = arg

    def __repr__(self):
        return f"ForwardRef({self.__forward_arg__!r})"


def assert_type(val, typ, /):
    return val


def assert_never(arg, /):
    raise AssertionError(f"Expected code to be unreachable, but got: {arg!r}")


def reveal_type(obj, /):
    return obj


def runtime_checkable(cls):
    return cls


def no_type_check(arg):
    return arg


no_type_check_decorator = no_type_check


def dataclass_transform(**kwargs):
    return lambda cls: cls


def get_origin(tp):
    return None


def get_args(tp):
    return ()


def get_overloads(func):
    return []


def clear_overloads():
    pass


def is_typeddict(tp):
    return isinstance(tp, type) and issubclass(tp, TypedDict) and tp is not TypedDict


ParamSpecArgs = _Name("ParamSpecArgs")
ParamSpecKwargs = _Name("ParamSpecKwargs")
