"""Containers beyond the builtin ones. Those that hold values are native (`_collections`); here are the ones that stand
before other containers: each says in a table which operations it hands on, to what, and what becomes of the result."""
from _collections import Counter, OrderedDict, defaultdict, deque, namedtuple
import collections.abc as abc

__all__ = ["ChainMap", "Counter", "OrderedDict", "UserDict", "UserList", "UserString", "defaultdict", "deque",
           "namedtuple"]

abc.MutableSequence.register(deque)


class ChainMap(abc.MutableMapping):
    """Several mappings one behind the other: the first that has a key answers, the first of all takes the changes."""

    def __init__(self, *maps):
        self.maps = [*maps] if maps else [{}]

    def __missing__(self, key):
        raise KeyError(key)

    def _holder(self, key):
        """The mapping that answers for a key."""
        for candidate in self.maps:
            if key in candidate:
                return candidate

    def _front(self, act, *args):
        """What the first mapping does; what it does not find is not looked for behind it."""
        try:
            return act(self.maps[0], *args)
        except KeyError:
            text = f"Key not found in the first mapping: {args[0]!r}" if args else "No keys found in the first mapping."
            raise KeyError(text) from None

    def _order(self):
        """All keys, those of the last mapping first."""
        return dict.fromkeys(key for layer in self.maps[::-1] for key in layer)

    def __getitem__(self, key):
        # Not asked twice: a mapping may make what it is asked for.
        for candidate in self.maps:
            try:
                return candidate[key]
            except KeyError:
                continue
        return self.__missing__(key)

    def __contains__(self, key):
        return self._holder(key) is not None

    def get(self, key, default=None):
        return self[key] if key in self else default

    def __iter__(self):
        return iter(self._order())

    def __len__(self):
        return len(self._order())

    def __bool__(self):
        return any(map(bool, self.maps))

    def __setitem__(self, key, value):
        self.maps[0][key] = value

    def __delitem__(self, key):
        self._front(type(self.maps[0]).__delitem__, key)

    def pop(self, key, *default):
        return self._front(lambda front, key: front.pop(key, *default), key)

    def popitem(self):
        return self._front(lambda front: front.popitem())

    def clear(self):
        self.maps[0].clear()

    def __repr__(self):
        return type(self).__name__ + "(" + ", ".join(repr(layer) for layer in self.maps) + ")"

    # Chains made of this one.

    def new_child(self, m=None, **named):
        front = {} if m is None else m
        front.update(named)
        return type(self)(front, *self.maps)

    @property
    def parents(self):
        return type(self)(*self.maps[1:])

    def copy(self):
        front, *others = self.maps
        return type(self)(front.copy(), *others)

    __copy__ = copy

    @classmethod
    def fromkeys(cls, keys, value=None):
        return cls(dict.fromkeys(keys, value))

    def __or__(self, other):
        if not isinstance(other, abc.Mapping):
            return NotImplemented
        joined = self.copy()
        joined.maps[0].update(other)
        return joined

    def __ror__(self, other):
        if not isinstance(other, abc.Mapping):
            return NotImplemented
        return type(self)({**dict(other), **dict(self.items())})

    def __ior__(self, other):
        self.maps[0].update(other)
        return self


def _inside(value):
    """What a wrapper has in it; anything else as it is."""
    return value.data if isinstance(value, (UserDict, UserList, UserString)) else value


# As operators, which also ask the other side.
_ORDER = {
    "__eq__": lambda one, other: one == other,
    "__lt__": lambda one, other: one < other,
    "__le__": lambda one, other: one <= other,
    "__gt__": lambda one, other: one > other,
    "__ge__": lambda one, other: one >= other,
}


def _handing_on(builtin, kept, wrapped=(), into=()):
    """A decorator that gives a wrapper of `builtin` values methods of it, which it calls with `self.data`.

    Results of those in `wrapped` are put into a wrapper of the same class. Those in `into` change `self.data` and
    return the wrapper.
    """
    def method(name, finish):
        own = _ORDER.get(name) or getattr(builtin, name)

        def handed_on(self, *args, **named):
            return finish(self, own(self.data, *[_inside(arg) for arg in args], **named))

        handed_on.__name__ = name
        return handed_on

    finishes = [
        (kept, lambda self, result: result),
        (wrapped, lambda self, result: type(self)(result)),
        (into, lambda self, result: self),
    ]

    def give(cls):
        for names, finish in finishes:
            for name in names.split() if names else ():
                if name not in cls.__dict__:
                    setattr(cls, name, method(name, finish))
                    handed = cls.__dict__[name]
                    handed.__qualname__ = f"{cls.__name__}.{name}"
        cls.__abstractmethods__ = frozenset()
        return cls

    return give


@_handing_on(dict, "__len__ __iter__ __delitem__ __repr__")
class UserDict(abc.MutableMapping):
    """A dictionary to derive from: every way to it leads through the methods of the subclass,
    and `data` has the entries."""

    def __init__(self, dict=None, /, **named):
        self.data = {}
        for source in (dict, named):
            if source:
                self.update(source)

    def __setitem__(self, key, item):
        self.data[key] = item

    def __getitem__(self, key):
        if key not in self.data and hasattr(type(self), "__missing__"):
            return type(self).__missing__(self, key)
        return self.data[key]

    def __contains__(self, key):
        return key in self.data

    def _of(self, entries):
        made = type(self)()
        made.update(entries)
        return made

    def copy(self):
        made = self._of(self.data)
        made.__dict__.update((name, value) for name, value in vars(self).items() if name != "data")
        return made

    __copy__ = copy

    @classmethod
    def fromkeys(cls, iterable, value=None):
        made = cls()
        made.update((key, value) for key in iterable)
        return made

    def __or__(self, other):
        other = _inside(other)
        return type(self)(self.data | other) if isinstance(other, dict) else NotImplemented

    def __ror__(self, other):
        other = _inside(other)
        return type(self)(other | self.data) if isinstance(other, dict) else NotImplemented

    def __ior__(self, other):
        self.data.update(_inside(other))
        return self


def _list_of(other):
    other = _inside(other)
    return other if isinstance(other, list) else list(other)


@_handing_on(list, "__eq__ __lt__ __le__ __gt__ __ge__ __contains__ __len__ __setitem__ __delitem__ append clear count "
             "extend index insert pop remove reverse sort")
class UserList(abc.MutableSequence):
    """A list to derive from; `data` has the items."""

    def __init__(self, initlist=None):
        self.data = [] if initlist is None else list(initlist)

    __hash__ = None

    def __getitem__(self, place):
        found = self.data[place]
        return type(self)(found) if isinstance(place, slice) else found

    def __add__(self, other):
        return type(self)(self.data + _list_of(other))

    def __radd__(self, other):
        return type(self)(_list_of(other) + self.data)

    def __iadd__(self, other):
        self.data += _list_of(other)
        return self

    def __repr__(self):
        return repr(self.data)

    def __mul__(self, times):
        return type(self)(self.data * times)

    __rmul__ = __mul__

    def __imul__(self, times):
        self.data *= times
        return self

    def copy(self):
        return type(self)(self)

    __copy__ = copy


@_handing_on(str, "__eq__ __lt__ __le__ __gt__ __ge__ __contains__ __len__ count encode endswith find format "
             "format_map index isalnum isalpha isascii isdecimal isdigit isidentifier islower isnumeric isprintable "
             "isspace istitle isupper join partition rfind rindex rpartition rsplit split splitlines startswith",
             "__getitem__ __mod__ capitalize casefold center expandtabs ljust lower lstrip removeprefix "
             "removesuffix replace rjust rstrip strip swapcase title translate upper zfill")
class UserString(abc.Sequence):
    """A text to derive from; `data` has the characters."""

    def __init__(self, seq):
        self.data = str(_inside(seq))

    maketrans = str.maketrans

    def __str__(self):
        return self.data

    def __repr__(self):
        return repr(self.data)

    def __hash__(self):
        return hash(self.data)

    def __int__(self):
        return int(self.data)

    def __float__(self):
        return float(self.data)

    def __complex__(self):
        return complex(self.data)

    def __add__(self, other):
        return type(self)(self.data + str(other))

    def __radd__(self, other):
        return type(self)(str(other) + self.data)

    def __rmod__(self, template):
        return type(self)(str(template) % self)

    def __mul__(self, times):
        return type(self)(self.data * times)

    __rmul__ = __mul__
