"""What containers can do, as classes to ask for (`isinstance(x, Sequence)`) and to derive from.

A class says with `_needs` which methods make another class one of its kind, whether that derives from it or not. Those
with more to give than they need are derived from with the needed methods only.
"""
from abc import ABCMeta, _has_method as _has, abstractmethod
from itertools import count as _count


def _missing(name):
    """The abstract method of this name."""
    def method(self, *args):
        raise NotImplementedError(name)
    method.__name__ = name
    return abstractmethod(method)


class _Kind(ABCMeta):
    """Makes abstract methods of the needed ones; abilities know other classes by theirs (`_known_by`)."""

    def __new__(mcls, name, bases, namespace):
        for need in namespace.get("_needs", ()):
            if not any(_has(base, need) for base in bases if base is not object):
                namespace.setdefault(need, _missing(need))
        return super().__new__(mcls, name, bases, namespace)


def _ability(name, *needs, bases=(), **methods):
    """A class for what has these methods, and those of the bases."""
    known_by = needs + tuple(need for base in bases for need in base._known_by)

    @classmethod
    def recognise(cls, other):
        return True if cls is made and all(_has(other, need) for need in known_by) else NotImplemented

    made = _Kind(name, bases, {"_needs": needs, "_known_by": known_by, "__module__": "collections.abc", "__slots__": (),
                               "__class_getitem__": lambda cls, parameters: cls, "__subclasshook__": recognise,
                               **methods})
    return made


def _itself(self):
    return self


def _throw_exit(self):
    """Ends a generator: it is expected to end with the exception that it gets."""
    try:
        self.throw(GeneratorExit)
    except (GeneratorExit, StopIteration):
        return
    raise RuntimeError("generator ignored GeneratorExit")


def _send_none(self):
    return self.send(None)


Hashable = _ability("Hashable", "__hash__")
Awaitable = _ability("Awaitable", "__await__")
Coroutine = _ability("Coroutine", "send", "throw", bases=(Awaitable,), close=_throw_exit)
AsyncIterable = _ability("AsyncIterable", "__aiter__")
AsyncIterator = _ability("AsyncIterator", "__anext__", bases=(AsyncIterable,), __aiter__=_itself)
AsyncGenerator = _ability("AsyncGenerator", "asend", "athrow", bases=(AsyncIterator,))
Iterable = _ability("Iterable", "__iter__")
Iterator = _ability("Iterator", "__next__", bases=(Iterable,), __iter__=_itself)
Generator = _ability("Generator", "send", "throw", bases=(Iterator,), __next__=_send_none, close=_throw_exit)
Reversible = _ability("Reversible", "__reversed__", bases=(Iterable,))
Sized = _ability("Sized", "__len__")
Container = _ability("Container", "__contains__")
Collection = _ability("Collection", bases=(Sized, Iterable, Container))
Callable = _ability("Callable", "__call__")


def _kind(name, bases, needs, methods, *members):
    """A class for containers of one kind: the builtin ones are entered, others have to derive from it or to be."""
    cls = _Kind(name, bases, {"_needs": needs, "__module__": "collections.abc", "__slots__": (), **methods})
    for member in members:
        cls.register(member)
    return cls


def _methods(make):
    """What `make` defines and returns with `locals()`."""
    return make()


@_methods
def _of_sequences():
    def __iter__(self):
        for place in _count():
            try:
                item = self[place]
            except IndexError:
                return
            yield item

    def __reversed__(self):
        for place in range(len(self) - 1, -1, -1):
            yield self[place]

    def _places(self, wanted, start=0, stop=None):
        """Where an item is, by identity or equality."""
        for place in _count(start):
            if stop is not None and place >= stop:
                return
            try:
                item = self[place]
            except IndexError:
                return
            if item is wanted or item == wanted:
                yield place

    def __contains__(self, value):
        return any(item is value or item == value for item in self)

    def index(self, value, start=0, stop=None):
        bounds = [len(self) + bound if bound is not None and bound < 0 else bound for bound in (start, stop)]
        for place in self._places(value, max(bounds[0] or 0, 0), bounds[1]):
            return place
        raise ValueError

    def count(self, value):
        return sum(1 for item in self if item is value or item == value)

    return locals()


Sequence = _kind("Sequence", (Reversible, Collection), ("__getitem__", "__len__"), _of_sequences,
                 tuple, str, range, bytes)
ByteString = _kind("ByteString", (Sequence,), (), {}, bytes, bytearray)


@_methods
def _of_mutable_sequences():
    def append(self, value):
        self.insert(len(self), value)

    def extend(self, values):
        for value in list(values) if values is self else values:
            self.append(value)

    def __iadd__(self, values):
        self.extend(values)
        return self

    def pop(self, index=-1):
        taken = self[index]
        del self[index]
        return taken

    def remove(self, value):
        del self[self.index(value)]

    def clear(self):
        while len(self):
            self.pop()

    def reverse(self):
        for low, high in zip(range(len(self) // 2), range(len(self) - 1, 0, -1)):
            self[low], self[high] = self[high], self[low]

    return locals()


MutableSequence = _kind("MutableSequence", (Sequence,), ("__setitem__", "__delitem__", "insert"), _of_mutable_sequences,
                        list, bytearray)


@_methods
def _of_sets():
    def _from_iterable(cls, it):
        return cls(it)

    _from_iterable = classmethod(_from_iterable)

    def compared(test):
        """A comparison with another set; `test` gets both."""
        def compare(self, other):
            return test(self, other) if isinstance(other, Set) else NotImplemented
        return compare

    def within(one, other):
        return len(one) <= len(other) and all(item in other for item in one)

    __le__ = compared(within)
    __ge__ = compared(lambda self, other: within(other, self))
    __lt__ = compared(lambda self, other: len(self) < len(other) and within(self, other))
    __gt__ = compared(lambda self, other: len(self) > len(other) and within(other, self))
    __eq__ = compared(lambda self, other: len(self) == len(other) and within(self, other))

    def joined(choose, turned=False):
        """An operation with anything that has items; `choose` gives those of the result."""
        def operate(self, other):
            if not isinstance(other, Iterable):
                return NotImplemented
            sides = (other, self) if turned else (self, other)
            one, two = [side if isinstance(side, Set) else self._from_iterable(side) for side in sides]
            return self._from_iterable(choose(one, two))
        return operate

    def both(one, two):
        return [item for item in two if item in one]

    def either(one, two):
        return [item for side in (one, two) for item in side]

    def first_only(one, two):
        return [item for item in one if item not in two]

    def one_only(one, two):
        return first_only(one, two) + first_only(two, one)

    __and__ = __rand__ = joined(both)
    __or__ = __ror__ = joined(either)
    __sub__, __rsub__ = joined(first_only), joined(first_only, turned=True)
    __xor__ = __rxor__ = joined(one_only)

    def isdisjoint(self, other):
        return not any(item in self for item in other)

    def _hash(self):
        """A hash for subclasses that are hashable, the same for equal sets of any kind."""
        return hash(frozenset(self))

    found = locals()
    for inner in ("compared", "within", "joined", "both", "either", "first_only", "one_only"):
        del found[inner]
    found["__hash__"] = None
    return found


Set = _kind("Set", (Collection,), (), _of_sets, set, frozenset)


@_methods
def _of_mutable_sets():
    def remove(self, value):
        if value not in self:
            raise KeyError(value)
        self.discard(value)

    def pop(self):
        for value in self:
            self.discard(value)
            return value
        raise KeyError

    def clear(self):
        for value in list(self):
            self.discard(value)

    def __ior__(self, other):
        for value in other:
            self.add(value)
        return self

    def __iand__(self, other):
        for value in self - other:
            self.discard(value)
        return self

    def __isub__(self, other):
        for value in list(other):
            self.discard(value)
        return self

    def __ixor__(self, other):
        for value in list(self) if other is self else self._from_iterable(other):
            (self.discard if value in self else self.add)(value)
        return self

    return locals()


MutableSet = _kind("MutableSet", (Set,), ("add", "discard"), _of_mutable_sets, set)


@_methods
def _of_mappings():
    def __contains__(self, key):
        try:
            self[key]
        except KeyError:
            return False
        return True

    def get(self, key, default=None):
        try:
            return self[key]
        except KeyError:
            return default

    def keys(self):
        return KeysView(self)

    def values(self):
        return ValuesView(self)

    def items(self):
        return ItemsView(self)

    def __eq__(self, other):
        return dict(self.items()) == dict(other.items()) if isinstance(other, Mapping) else NotImplemented

    return {**locals(), "__reversed__": None, "__hash__": None}


_nothing = object()
Mapping = _kind("Mapping", (Collection,), ("__getitem__",), _of_mappings, dict)


@_methods
def _of_mutable_mappings():
    def pop(self, key, default=_nothing):
        found = self.get(key, _nothing) if default is not _nothing else self[key]
        if found is _nothing:
            return default
        del self[key]
        return found

    def popitem(self):
        for key in self:
            return key, self.pop(key)
        raise KeyError

    def clear(self):
        while len(self):
            self.popitem()

    def update(self, other=(), /, **named):
        pairs = other
        if isinstance(other, Mapping) or hasattr(other, "keys"):
            pairs = ((key, other[key]) for key in other.keys())
        for source in (pairs, named.items()):
            for key, value in source:
                self[key] = value

    def setdefault(self, key, default=None):
        found = self.get(key, _nothing)
        if found is _nothing:
            self[key] = found = default
        return found

    return locals()


MutableMapping = _kind("MutableMapping", (Mapping,), ("__setitem__", "__delitem__"), _of_mutable_mappings, dict)


def _view(name, bases, show, holds, *members):
    """A view of a mapping: what it shows of each key, and whether it has an item."""
    def __iter__(self):
        for key in self._mapping:
            yield show(self._mapping, key)

    return _kind(name, bases, (), {"__iter__": __iter__, "__contains__": lambda self, item: holds(self._mapping, item)},
                 *members)


def _keep(self, mapping):
    self._mapping = mapping


MappingView = _kind("MappingView", (Sized,), (), {
    "__slots__": ("_mapping",),
    "__init__": _keep,
    "__len__": lambda self: len(self._mapping),
    "__repr__": lambda self: f"{type(self).__name__}({self._mapping!r})",
})
KeysView = _view("KeysView", (MappingView, Set), lambda mapping, key: key, lambda mapping, key: key in mapping,
                 type({}.keys()))
ItemsView = _view("ItemsView", (MappingView, Set), lambda mapping, key: (key, mapping[key]),
                  lambda mapping, item: item[0] in mapping and mapping[item[0]] == item[1], type({}.items()))
ValuesView = _view("ValuesView", (MappingView, Collection), lambda mapping, key: mapping[key],
                   lambda mapping, value: any(mapping[key] == value for key in mapping), type({}.values()))
# What is taken from views together is no view of anything.
KeysView._from_iterable = ItemsView._from_iterable = classmethod(lambda cls, items: set(items))

__all__ = ["Awaitable", "Coroutine", "AsyncIterable", "AsyncIterator", "AsyncGenerator", "Hashable", "Iterable",
           "Iterator", "Generator", "Reversible", "Sized", "Container", "Callable", "Collection", "Set", "MutableSet",
           "Mapping", "MutableMapping", "MappingView", "KeysView", "ItemsView", "ValuesView", "Sequence",
           "MutableSequence", "ByteString"]
