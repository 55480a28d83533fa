"""Functions on functions."""
from _functools import cmp_to_key, reduce
from _collections import namedtuple as _namedtuple

WRAPPER_ASSIGNMENTS = ("__module__", "__name__", "__qualname__", "__doc__", "__annotations__")
WRAPPER_UPDATES = ("__dict__",)
_missing = object()


def update_wrapper(wrapper, wrapped, assigned=WRAPPER_ASSIGNMENTS, updated=WRAPPER_UPDATES):
    for name in assigned:
        value = getattr(wrapped, name, _missing)
        if value is not _missing:
            setattr(wrapper, name, value)
    for name in updated:
        merged = getattr(wrapper, name)
        merged.update(getattr(wrapped, name, {}))
        if name == "__dict__" and isinstance(wrapper, type(update_wrapper)):
            # What a function gives is a copy.
            wrapper.__dict__ = merged
    wrapper.__wrapped__ = wrapped
    return wrapper


def wraps(wrapped, assigned=WRAPPER_ASSIGNMENTS, updated=WRAPPER_UPDATES):
    return lambda wrapper: update_wrapper(wrapper, wrapped, assigned, updated)


class partial:
    """A function with some of its arguments."""

    def __init__(self, func, /, *args, **keywords):
        if not callable(func):
            raise TypeError("the first argument must be callable")
        if isinstance(func, partial):
            args = func.args + args
            keywords = {**func.keywords, **keywords}
            func = func.func
        self.func = func
        self.args = args
        self.keywords = keywords

    def __call__(self, /, *args, **keywords):
        return self.func(*self.args, *args, **{**self.keywords, **keywords})

    def __repr__(self):
        parts = [repr(self.func)]
        parts.extend(repr(arg) for arg in self.args)
        parts.extend(f"{name}={value!r}" for name, value in self.keywords.items())
        return f"functools.partial({', '.join(parts)})"


class partialmethod:
    """`partial` for methods."""

    def __init__(self, func, /, *args, **keywords):
        self.func = func
        self.args = args
        self.keywords = keywords

    def __get__(self, obj, cls=None):
        function = self.func.__get__(obj, cls) if hasattr(self.func, "__get__") else partial(self.func, obj)
        return partial(function, *self.args, **self.keywords)


def total_ordering(cls):
    """Fills in the missing ones of `<`, `<=`, `>`, `>=`."""
    own = [name for name in ("__lt__", "__le__", "__gt__", "__ge__") if name in cls.__dict__]
    if not own:
        raise ValueError("must define at least one ordering operation: < > <= >=")
    root = own[0]

    def answer(result, then):
        return result if result is NotImplemented else then(result)

    less = {
        "__lt__": lambda a, b: type(a).__lt__(a, b),
        "__le__": lambda a, b: answer(type(a).__le__(a, b), lambda r: r and a != b),
        "__gt__": lambda a, b: answer(type(a).__gt__(a, b), lambda r: not r and a != b),
        "__ge__": lambda a, b: answer(type(a).__ge__(a, b), lambda r: not r),
    }[root]
    derived = {
        "__lt__": lambda self, other: less(self, other),
        "__le__": lambda self, other: answer(less(self, other), lambda r: r or self == other),
        "__gt__": lambda self, other: answer(less(self, other), lambda r: not r and self != other),
        "__ge__": lambda self, other: answer(less(self, other), lambda r: not r),
    }
    for name, function in derived.items():
        if name not in cls.__dict__:
            setattr(cls, name, function)
    return cls


CacheInfo = _namedtuple("CacheInfo", ["hits", "misses", "maxsize", "currsize"])


def lru_cache(maxsize=128, typed=False):
    """Remembers results by arguments; with a bound the ones not used longest are forgotten first."""
    if callable(maxsize):
        return _cached(maxsize, 128, typed)
    if maxsize is not None and not isinstance(maxsize, int):
        raise TypeError("Expected first argument to be an integer, a callable, or None")
    if maxsize is not None and maxsize < 0:
        maxsize = 0
    return lambda function: _cached(function, maxsize, typed)


def cache(user_function, /):
    return _cached(user_function, None, False)


_mark = object()


def _cached(function, maxsize, typed):
    results = {}
    hits = misses = 0

    def wrapper(*args, **kwargs):
        nonlocal hits, misses
        key = args
        if len(args) == 1 and not kwargs and type(args[0]) in (int, str):
            key = args[0]
        if kwargs:
            key += (_mark,) + tuple(kwargs.items())
        if typed:
            types = tuple(type(value) for value in args) + tuple(type(value) for value in kwargs.values())
            key = args + tuple(kwargs.items()) + types
        found = results.get(key, _missing)
        if found is not _missing:
            hits += 1
            if maxsize is not None:
                results[key] = results.pop(key)
            return found
        misses += 1
        value = function(*args, **kwargs)
        if maxsize != 0:
            if maxsize is not None and len(results) >= maxsize and key not in results:
                del results[next(iter(results))]
            results[key] = value
        return value

    def cache_info():
        return CacheInfo(hits, misses, maxsize, len(results))

    def cache_clear():
        nonlocal hits, misses
        hits = misses = 0
        results.clear()

    wrapper.cache_info = cache_info
    wrapper.cache_clear = cache_clear
    wrapper.cache_parameters = lambda: {"maxsize": maxsize, "typed": typed}
    return update_wrapper(wrapper, function)


class cached_property:
    """A property that is computed once for each object."""

    def __init__(self, func):
        self.func = func
        self.attrname = None
        self.__doc__ = func.__doc__

    def __set_name__(self, owner, name):
        self.attrname = name

    def __get__(self, instance, owner=None):
        if instance is None:
            return self
        if self.attrname is None:
            raise TypeError("Cannot use cached_property instance without calling __set_name__ on it.")
        value = self.func(instance)
        instance.__dict__[self.attrname] = value
        return value


def singledispatch(func):
    """Chooses a function by the type of the first argument."""
    registry = {object: func}

    def dispatch(cls):
        for base in cls.__mro__:
            if base in registry:
                return registry[base]
        return func

    def register(cls, function=None):
        if not isinstance(cls, type):
            raise TypeError(f"Invalid first argument to `register()`: {cls!r}. Use `@register(some_class)`: "
                            "annotations of functions have no effect here.")
        if function is None:
            return lambda function: register(cls, function)
        registry[cls] = function
        return function

    def wrapper(*args, **kwargs):
        if not args:
            raise TypeError(f"{func.__name__} requires at least 1 positional argument")
        return dispatch(type(args[0]))(*args, **kwargs)

    wrapper.register = register
    wrapper.dispatch = dispatch
    wrapper.registry = registry
    return update_wrapper(wrapper, func)


class singledispatchmethod:
    """Chooses a method by the type of the first argument after the object."""

    def __init__(self, func):
        if not callable(func) and not hasattr(func, "__get__"):
            raise TypeError(f"{func!r} is not callable or a descriptor")
        self.dispatcher = singledispatch(func)
        self.func = func

    def register(self, cls, method=None):
        return self.dispatcher.register(cls, method)

    def __get__(self, obj, cls=None):
        def method(*args, **kwargs):
            chosen = self.dispatcher.dispatch(args[0].__class__)
            if hasattr(chosen, "__get__"):
                chosen = chosen.__get__(obj, cls)
            return chosen(*args, **kwargs)
        method.register = self.register
        return update_wrapper(method, self.func)
