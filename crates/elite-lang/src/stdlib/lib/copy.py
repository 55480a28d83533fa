"""Copies of values, shallow and deep."""


class Error(Exception):
    pass


error = Error

_ATOMIC = (type(None), bool, int, float, complex, str, bytes, range, slice, type, type(Ellipsis), type(NotImplemented))


def copy(x):
    cls = type(x)
    if isinstance(x, _ATOMIC) and cls in _ATOMIC or cls in (tuple, frozenset) or _is_code(x):
        return x
    if cls in (list, dict, set, bytearray):
        return x.copy()
    custom = getattr(cls, "__copy__", None)
    if custom is not None:
        return custom(x)
    return _rebuilt(x, lambda value: value)


_CODE = (type(len), type(lambda: None), type([].append), type(Error("").with_traceback), type(property()))


def _is_code(x):
    return isinstance(x, type) or type(x) in _CODE


def deepcopy(x, memo=None):
    if memo is None:
        memo = {}
    known = memo.get(id(x))
    if known is not None:
        return known[1]
    cls = type(x)
    if cls in _ATOMIC or _is_code(x):
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
    else:
        custom = getattr(cls, "__deepcopy__", None)
        if custom is not None:
            made = custom(x, memo)
        else:
            return _rebuilt(x, lambda value: deepcopy(value, memo), memo)
    memo[id(x)] = (x, made)
    return made


def _rebuilt(x, each, memo=None):
    """An instance of a class of the script with its attributes and, if it extends a builtin type, its content."""
    cls = type(x)
    if isinstance(x, BaseException):
        made = cls.__new__(cls, *x.args)
        made.args = each(x.args)
    elif isinstance(x, tuple):
        made = tuple.__new__(cls, [each(item) for item in x])
    elif isinstance(x, (int, float, complex, str, bytes, frozenset)):
        made = cls.__new__(cls, x)
    elif isinstance(x, (list, set, dict, bytearray)) or hasattr(cls, "__iter__") and hasattr(cls, "maxlen"):
        made = cls.__new__(cls) if not hasattr(cls, "maxlen") else cls(maxlen=x.maxlen)
    else:
        made = object.__new__(cls)
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
    state = getattr(x, "__dict__", None)
    if state:
        for name, value in list(state.items()):
            made.__dict__[name] = each(value)
    return made
