"""Copies of values, shallow and deep."""
from _copy import copied_iterator as _copied_iterator


class Error(Exception):
    pass


error = Error

_ATOMIC = (type(None), bool, int, float, complex, str, bytes, range, slice, type, type(Ellipsis), type(NotImplemented))


_missing = object()


def copy(x):
    cls = type(x)
    if isinstance(x, _ATOMIC) and cls in _ATOMIC or cls in (tuple, frozenset) or _is_code(x):
        return x
    if cls in (list, dict, set, bytearray):
        return x.copy()
    custom = getattr(cls, "__copy__", None)
    if custom is not None:
        return custom(x)
    reduced = _reduced(x)
    if reduced is not None:
        return x if isinstance(reduced, str) else _from_reduced(reduced, lambda value: value)
    return _rebuilt(x, lambda value: value)


_CODE = (type(len), type(lambda: None), type([].append), type(Error("").with_traceback), type(property()),
         type(str.upper), type(int.__add__), type((1).__add__))


def _is_code(x):
    return isinstance(x, type) or type(x) in _CODE


def deepcopy(x, memo=None):
    if memo is None:
        memo = {}
    known = memo.get(id(x))
    if known is not None:
        return known[1]
    cls = type(x)
    if cls in _ATOMIC and cls is not slice or _is_code(x):
        return x
    if cls is list:
        made = []
        memo[id(x)] = (x, made)
        for item in x:
            made.append(deepcopy(item, memo))
        return made
    if cls is tuple:
        items = [deepcopy(item, memo) for item in x]
        known = memo.get(id(x))
        if known is not None:
            return known[1]
        made = x if all(a is b for a, b in zip(items, x)) else tuple(items)
    elif cls is dict:
        made = {}
        memo[id(x)] = (x, made)
        for key, value in x.items():
            made[deepcopy(key, memo)] = deepcopy(value, memo)
        return made
    elif cls in (set, frozenset):
        made = cls(deepcopy(item, memo) for item in x)
    elif cls is bytearray:
        made = x.copy()
    elif cls is slice:
        made = slice(deepcopy(x.start, memo), deepcopy(x.stop, memo), deepcopy(x.step, memo))
    else:
        custom = getattr(cls, "__deepcopy__", None)
        reduced = _reduced(x) if custom is None else None
        if custom is not None:
            made = custom(x, memo)
        elif isinstance(reduced, str):
            made = x
        elif reduced is not None:
            made = _from_reduced(reduced, lambda value: deepcopy(value, memo))
        else:
            return _rebuilt(x, lambda value: deepcopy(value, memo), memo)
    memo[id(x)] = (x, made)
    return made


def _reduced(x):
    """What a class of the script says of how to make its objects anew; None if it says nothing."""
    for name, args in (("__reduce_ex__", (4,)), ("__reduce__", ())):
        method = getattr(type(x), name, None)
        if method is not None and method is not getattr(object, name):
            return method(x, *args)
    return None


def _from_reduced(reduced, each):
    function, args, *rest = reduced
    made = function(*[each(arg) for arg in args])
    state, items, pairs = (rest + [None] * 3)[:3]
    if state is not None:
        _set_state(made, each(state))
    if items is not None:
        for item in items:
            made.append(each(item))
    if pairs is not None:
        for key, value in pairs:
            made[each(key)] = each(value)
    return made


def _set_state(made, state):
    if hasattr(made, "__setstate__"):
        made.__setstate__(state)
        return
    slots = None
    if isinstance(state, tuple) and len(state) == 2:
        state, slots = state
    for part in (state, slots):
        for name, value in (part or {}).items():
            setattr(made, name, value)


def _makes_its_own(cls):
    return any("__new__" in base.__dict__ for base in cls.__mro__ if base is not object)


def _rebuilt(x, each, memo=None):
    """An instance of a class of the script with its attributes and, if it extends a builtin type, its content."""
    cls = type(x)
    if isinstance(x, BaseException):
        made = cls.__new__(cls, *x.args)
        made.args = each(x.args)
    elif isinstance(x, (tuple, int, float, complex, str, bytes)):
        made = cls.__new__(cls, *[each(arg) for arg in x.__getnewargs__()])
    elif isinstance(x, frozenset):
        made = cls.__new__(cls, x)
    elif isinstance(x, (list, set, dict, bytearray)) or hasattr(cls, "__iter__") and hasattr(cls, "maxlen"):
        made = cls.__new__(cls) if not hasattr(cls, "maxlen") else cls(maxlen=x.maxlen)
    else:
        made = _copied_iterator(x, each)
        if made is not None:
            if memo is not None:
                memo[id(x)] = (x, made)
            return made
        try:
            made = object.__new__(cls) if not _makes_its_own(cls) else None
        except TypeError:
            raise TypeError(f"cannot pickle '{cls.__name__}' object") from None
        if made is None:
            made = cls.__new__(cls, *(x.__getnewargs__() if hasattr(cls, "__getnewargs__") else ()))
    if memo is not None:
        memo[id(x)] = (x, made)
    if isinstance(x, dict):
        for key, value in x.items():
            dict.__setitem__(made, each(key), each(value))
    elif isinstance(x, list):
        for item in x:
            list.append(made, each(item))
    elif isinstance(x, (set, bytearray)):
        made.update(each(item) for item in x) if isinstance(x, set) else made.extend(x)
    elif hasattr(cls, "maxlen"):
        made.extend(each(item) for item in x)
    if cls.__getstate__ is not object.__getstate__:
        state = x.__getstate__()
        if state:
            _set_state(made, each(state))
        return made
    state = getattr(x, "__dict__", None)
    if state and hasattr(cls, "__setstate__"):
        _set_state(made, each(dict(state)))
        return made
    if state:
        for name, value in list(state.items()):
            made.__dict__[name] = each(value)
    for base in cls.__mro__:
        slots = base.__dict__.get("__slots__", ())
        for name in (slots,) if isinstance(slots, str) else slots:
            if name not in ("__dict__", "__weakref__"):
                value = getattr(x, name, _missing)
                if value is not _missing:
                    setattr(made, name, each(value))
    return made
