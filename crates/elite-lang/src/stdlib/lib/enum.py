"""Enumerations."""
import sys as _sys

__all__ = ["EnumType", "EnumMeta", "Enum", "IntEnum", "StrEnum", "Flag", "IntFlag", "ReprEnum", "auto", "unique",
           "property", "verify", "member", "nonmember", "FlagBoundary", "STRICT", "CONFORM", "EJECT", "KEEP",
           "global_flag_repr", "global_enum_repr", "global_str", "global_enum", "EnumCheck", "CONTINUOUS", "NAMED_FLAGS",
           "UNIQUE"]

_builtin_property = property
_missing = object()
Enum = Flag = EJECT = ReprEnum = None


class auto:
    """Stands for the next value."""

    def __init__(self, value=_missing):
        self.value = value

    def __repr__(self):
        return f"auto({'' if self.value is _missing else repr(self.value)})"


class nonmember:
    """Keeps a value from becoming a member."""

    def __init__(self, value):
        self.value = value


class member:
    """Makes a value a member that would not become one."""

    def __init__(self, value):
        self.value = value


class property:
    """A property of members whose name a member may have, too."""

    def __init__(self, fget=None, fset=None, fdel=None, doc=None):
        self.fget, self.fset, self.fdel = fget, fset, fdel
        self.__doc__ = doc or (fget.__doc__ if fget is not None else None)
        self.name = None
        self.clsname = None

    def __set_name__(self, owner, name):
        self.name = name
        self.clsname = owner.__name__

    def getter(self, fget):
        return type(self)(fget, self.fset, self.fdel)

    def setter(self, fset):
        return type(self)(self.fget, fset, self.fdel)

    def deleter(self, fdel):
        return type(self)(self.fget, self.fset, fdel)

    def __get__(self, instance, owner=None):
        if instance is None:
            found = owner.__dict__.get("_member_map_", {}).get(self.name, _missing)
            if found is _missing:
                raise AttributeError(f"{owner!r} has no attribute {self.name!r}")
            return found
        if self.fget is None:
            found = type(instance)._member_map_.get(self.name, _missing)
            if found is _missing:
                raise AttributeError(f"{type(instance)!r} member has no attribute {self.name!r}")
            return found
        return self.fget(instance)

    def __set__(self, instance, value):
        if self.fset is None:
            raise AttributeError(f"<enum {self.clsname!r}> cannot set attribute {self.name!r}")
        return self.fset(instance, value)

    def __delete__(self, instance):
        if self.fdel is None:
            raise AttributeError(f"<enum {self.clsname!r}> cannot delete attribute {self.name!r}")
        return self.fdel(instance)


def _is_dunder(name):
    return len(name) > 4 and name[:2] == name[-2:] == "__" and name[2] != "_" and name[-3] != "_"


def _is_sunder(name):
    return len(name) > 2 and name[0] == name[-1] == "_" and name[1] != "_" and name[-2] != "_"


def _is_private(cls_name, name):
    pattern = f"_{cls_name}__"
    return len(name) > len(pattern) and name.startswith(pattern) and name[len(pattern)] != "_" and (
        name[-1] != "_" or name[-2] != "_")


def _is_descriptor(value):
    kind = type(value)
    return hasattr(kind, "__get__") or hasattr(kind, "__set__") or hasattr(kind, "__delete__") or isinstance(
        value, (_function, staticmethod, classmethod, _builtin_property))


_function = type(_is_dunder)


def _is_single_bit(number):
    return number > 0 and number & (number - 1) == 0


def _bits_of(number):
    while number:
        bit = number & (~number + 1)
        yield bit
        number ^= bit


class _EnumDict(dict):
    """The names of an enumeration's body; knows which of them are members, in order."""

    def __init__(self):
        super().__init__()
        self._member_names = {}
        self._last_values = []
        self._ignore = []
        self._auto_called = False
        self._generate_next_value = None
        self._cls_name = None

    def __setitem__(self, key, value):
        if self._cls_name is not None and _is_private(self._cls_name, key):
            pass
        elif _is_sunder(key):
            if key not in ("_order_", "_generate_next_value_", "_numeric_repr_", "_missing_", "_ignore_", "_iter_member_",
                           "_iter_member_by_value_", "_iter_member_by_def_", "_add_alias_", "_add_value_alias_"):
                raise ValueError(f"_sunder_ names, such as {key!r}, are reserved for future Enum use")
            if key == "_generate_next_value_":
                if self._auto_called:
                    raise TypeError("_generate_next_value_ must be defined before members")
                self._generate_next_value = value.__func__ if isinstance(value, staticmethod) else value
            elif key == "_ignore_":
                value = value.replace(",", " ").split() if isinstance(value, str) else list(value)
                self._ignore = value
                already = set(value) & set(self._member_names)
                if already:
                    raise ValueError(f"_ignore_ cannot specify already set names: {already!r}")
        elif _is_dunder(key):
            if key == "__order__":
                key = "_order_"
        elif key in self._member_names:
            raise TypeError(f"{key!r} already defined as {self[key]!r}")
        elif key in self._ignore:
            pass
        elif isinstance(value, nonmember):
            value = value.value
        elif _is_descriptor(value):
            pass
        else:
            if key in self:
                raise TypeError(f"{key!r} already defined as {self[key]!r}")
            if isinstance(value, member):
                value = value.value
            single = True
            if isinstance(value, auto):
                single, value = True, (value,)
            elif type(value) is tuple and any(isinstance(part, auto) for part in value):
                single = False
            else:
                value = (value,)
            parts = []
            for part in value:
                if isinstance(part, auto):
                    if part.value is _missing:
                        part.value = self._generate_next_value(key, 1, len(self._member_names), self._last_values[:])
                    self._auto_called = True
                    part = part.value
                parts.append(part)
            value = parts[0] if single else tuple(parts)
            self._member_names[key] = None
            self._last_values.append(value)
        super().__setitem__(key, value)

    def update(self, members=(), **more):
        for key, value in dict(members, **more).items():
            self[key] = value


class EnumType(type):
    """The type of enumerations."""

    @classmethod
    def __prepare__(metacls, cls, bases, **keywords):
        metacls._check_for_existing_members_(cls, bases)
        namespace = _EnumDict()
        namespace._cls_name = cls
        member_type, first = metacls._get_mixins_(cls, bases)
        if first is not None:
            namespace["_generate_next_value_"] = getattr(first, "_generate_next_value_", None)
        return namespace

    def __new__(metacls, cls, bases, classdict, *, boundary=None, _simple=False, **keywords):
        classdict.setdefault("_ignore_", []).append("_ignore_")
        for key in classdict["_ignore_"]:
            classdict.pop(key, None)
        names = list(classdict._member_names)
        bad = set(names) & {"mro", ""}
        if bad:
            raise ValueError(f"invalid enum member name(s) {','.join(map(repr, bad))}")
        order = classdict.pop("_order_", None)
        values = {name: classdict[name] for name in names}
        for name in names:
            dict.__delitem__(classdict, name)
        generate = classdict.get("_generate_next_value_")
        if generate is not None and isinstance(generate, _function):
            dict.__setitem__(classdict, "_generate_next_value_", staticmethod(generate))
        member_type, first_enum = metacls._get_mixins_(cls, bases)
        own_new = classdict.get("__new__")
        made = super().__new__(metacls, cls, bases, classdict, **keywords)
        made._member_names_ = []
        made._member_map_ = {}
        made._value2member_map_ = {}
        made._unhashable_values_ = []
        made._member_type_ = member_type
        made._boundary_ = boundary or getattr(first_enum, "_boundary_", None)
        made._flag_mask_ = 0
        made._all_bits_ = 0
        made._singles_mask_ = 0
        made._inverted_ = None
        new_member, uses_args = metacls._find_new_(own_new, member_type, first_enum)
        made._new_member_ = new_member
        made._use_args_ = uses_args
        if own_new is not None and first_enum is not None:
            made.__new_member__ = new_member
        if ReprEnum is not None and ReprEnum in bases:
            if member_type is object:
                raise TypeError("ReprEnum subclasses must be mixed with a data type (i.e. int, str, float, etc.)")
            if "__format__" not in classdict:
                type.__setattr__(made, "__format__", member_type.__format__)
            if "__str__" not in classdict:
                own = member_type.__str__ if issubclass(member_type, str) else member_type.__repr__
                type.__setattr__(made, "__str__", own)
        if Enum is not None and member_type is not object:
            # What the mixed-in type says about how members look does not count.
            for name in ("__repr__", "__str__", "__format__"):
                if name not in made.__dict__:
                    home = [base for base in made.__mro__[1:] if name in base.__dict__]
                    if home and not isinstance(home[0], EnumType):
                        type.__setattr__(made, name, getattr(first_enum, name))
        is_flag = Flag is not None and issubclass(made, Flag)
        for name, value in values.items():
            metacls._add_member_(made, name, value, is_flag)
        if Enum is not None:
            type.__setattr__(made, "__new__", Enum.__new__)
        if is_flag:
            for name in ("__or__", "__and__", "__xor__", "__ror__", "__rand__", "__rxor__", "__invert__"):
                if name not in classdict:
                    type.__setattr__(made, name, getattr(Flag, name))
            single = multi = 0
            for found in made._member_map_.values():
                number = found._value_
                if _is_single_bit(number):
                    single |= number
                else:
                    multi |= number
            if made._boundary_ is not KEEP:
                missed = list(_bits_of(multi & ~single))
                if missed:
                    raise TypeError(f"invalid Flag {cls!r} -- missing values {missed} for aliases")
            members = list(made)
            if members != sorted(members, key=lambda found: found._value_):
                made._iter_member_ = made._iter_member_by_def_
        if order is not None:
            if isinstance(order, str):
                order = order.replace(",", " ").split()
            order = [name for name in order if name in made._member_names_]
            expected = made._member_names_ if not is_flag else [
                name for name in made._member_names_ if _is_single_bit(made._member_map_[name]._value_)]
            if order != expected:
                raise TypeError(f"member order does not match _order_:\n  {made._member_names_!r}\n  {order!r}")
        return made

    @staticmethod
    def _add_member_(made, name, value, is_flag):
        member_type = made._member_type_
        args = value if isinstance(value, tuple) else (value,)
        if member_type is tuple:
            args = (args,)
        if not made._use_args_:
            found = made._new_member_(made)
        else:
            found = made._new_member_(made, *args)
        if not hasattr(found, "_value_"):
            if member_type is object:
                found._value_ = value
            else:
                try:
                    found._value_ = member_type(*args)
                except Exception as error:
                    raise TypeError("_value_ not set in __new__, unable to create it") from error
        value = found._value_
        found._name_ = name
        found.__objclass__ = made
        found.__init__(*args)
        found._sort_order_ = len(made._member_names_)
        if is_flag and isinstance(value, int) and (not _is_single_bit(value)):
            alias = made._member_of_(value)
            if alias is None and value:
                pass
        known = made._member_of_(value)
        if known is not None:
            found = known
        elif not is_flag or not isinstance(value, int) or _is_single_bit(value):
            made._member_names_.append(name)
        descriptor = None
        for base in made.__mro__[1:]:
            candidate = base.__dict__.get(name)
            if candidate is not None:
                descriptor = candidate
                break
        if isinstance(descriptor, property):
            # A property of that name stays one for members.
            redirect = property(descriptor.fget, descriptor.fset, descriptor.fdel)
            redirect.__set_name__(made, name)
            type.__setattr__(made, name, redirect)
        else:
            type.__setattr__(made, name, found)
        made._member_map_[name] = found
        if known is None:
            try:
                made._value2member_map_.setdefault(value, found)
            except TypeError:
                made._unhashable_values_.append((value, found))
        if is_flag and isinstance(value, int):
            made._flag_mask_ |= value
            if _is_single_bit(value):
                made._singles_mask_ |= value
            made._all_bits_ = 2 ** made._flag_mask_.bit_length() - 1

    def _member_of_(cls, value):
        try:
            return cls._value2member_map_.get(value)
        except TypeError:
            for known, found in cls._unhashable_values_:
                if known == value:
                    return found
            return None

    @classmethod
    def _check_for_existing_members_(metacls, name, bases):
        for chain in bases:
            for base in chain.__mro__:
                if isinstance(base, EnumType) and base._member_names_:
                    raise TypeError(f"<enum {name!r}> cannot extend {base!r}")

    @classmethod
    def _get_mixins_(metacls, name, bases):
        if not bases:
            return object, Enum
        first = bases[-1]
        if not isinstance(first, EnumType):
            raise TypeError("new enumerations should be created as `EnumName([mixin_type, ...] [data_type,] enum_type)`")
        return metacls._find_data_type_(name, bases) or object, first

    @classmethod
    def _find_data_type_(metacls, name, bases):
        found = []
        for chain in bases:
            candidate = None
            for base in chain.__mro__:
                if base is object:
                    continue
                if isinstance(base, EnumType):
                    if base._member_type_ is not object:
                        if base._member_type_ not in found:
                            found.append(base._member_type_)
                        break
                elif "__new__" in base.__dict__ or base in _DATA_TYPES or "__dataclass_fields__" in base.__dict__:
                    kind = candidate or base
                    if kind not in found:
                        found.append(kind)
                    break
                else:
                    candidate = candidate or base
        if len(found) > 1:
            raise TypeError(f"too many data types for {name!r}: {set(found)!r}")
        return found[0] if found else None

    @classmethod
    def _find_new_(metacls, own_new, member_type, first_enum):
        new = own_new
        if isinstance(new, staticmethod):
            new = new.__func__
        if new is None and first_enum is not None:
            saved = getattr(first_enum, "__new_member__", None)
            if saved is not None:
                new = saved
        if new is None:
            if member_type is object:
                return object.__new__, False
            return member_type.__new__, True
        return new, True

    def __bool__(cls):
        return True

    def __call__(cls, value, names=None, *, module=None, qualname=None, type=None, start=1, boundary=None):
        if names is None:
            return cls.__new__(cls, value)
        return cls._create_(value, names, module=module, qualname=qualname, type=type, start=start, boundary=boundary)

    def __contains__(cls, member):
        if not isinstance(member, Enum):
            kind = _type(member)
            raise TypeError(f"unsupported operand type(s) for 'in': '{kind.__qualname__}' and '{cls.__class__.__qualname__}'")
        return isinstance(member, cls) and member._name_ in cls._member_map_

    def __delattr__(cls, attr):
        if attr in cls._member_map_:
            raise AttributeError(f"{cls.__name__!r} cannot delete member {attr!r}.")
        super().__delattr__(attr)

    def __dir__(cls):
        return sorted({"__class__", "__contains__", "__doc__", "__getitem__", "__init_subclass__", "__iter__", "__len__",
                       "__members__", "__module__", "__name__", "__qualname__", *cls._member_names_})

    def __getattr__(cls, name):
        raise AttributeError(name)

    def __getitem__(cls, name):
        return cls._member_map_[name]

    def __iter__(cls):
        return (cls._member_map_[name] for name in cls._member_names_)

    def __len__(cls):
        return len(cls._member_names_)

    @_builtin_property
    def __members__(cls):
        return _MappingProxy(cls._member_map_)

    def __repr__(cls):
        kind = "flag" if Flag is not None and issubclass(cls, Flag) else "enum"
        return f"<{kind} {cls.__name__!r}>"

    def __reversed__(cls):
        return (cls._member_map_[name] for name in reversed(cls._member_names_))

    def __setattr__(cls, name, value):
        if name in cls.__dict__.get("_member_map_", {}):
            raise AttributeError(f"cannot reassign member {name!r}")
        super().__setattr__(name, value)

    def _create_(cls, class_name, names, *, module=None, qualname=None, type=None, start=1, boundary=None):
        bases = (cls,) if type is None else (type, cls)
        namespace = EnumType.__prepare__(class_name, bases)
        if isinstance(names, str):
            names = names.replace(",", " ").split()
        if isinstance(names, (tuple, list)) and names and isinstance(names[0], str):
            original, names, last = names, [], []
            for count, name in enumerate(original):
                value = namespace._generate_next_value(name, start, count, last[:])
                last.append(value)
                names.append((name, value))
        elif isinstance(names, dict):
            names = list(names.items())
        for item in names:
            name, value = item
            namespace[name] = value
        namespace["__module__"] = module or "__main__"
        if qualname is not None:
            namespace["__qualname__"] = qualname
        return cls.__class__(class_name, bases, namespace, boundary=boundary)


_type = type
EnumMeta = EnumType
_DATA_TYPES = (int, float, complex, str, bytes, bytearray, tuple, list, dict, set, frozenset)


class _MappingProxy(dict):
    """The members of an enumeration, to read."""

    def __repr__(self):
        return f"mappingproxy({dict(self)!r})"

    def __str__(self):
        return dict.__repr__(self)

    def __setitem__(self, key, value):
        raise TypeError("'mappingproxy' object does not support item assignment")

    def __delitem__(self, key):
        raise TypeError("'mappingproxy' object does not support item deletion")


_MappingProxy.__name__ = "mappingproxy"


class Enum(metaclass=EnumType):
    """A set of names with values."""

    def __new__(cls, value):
        if type(value) is cls:
            return value
        found = cls._member_of_(value)
        if found is not None:
            return found
        failure = None
        try:
            result = cls._missing_(value)
        except Exception as error:
            failure = error
            result = None
        try:
            if isinstance(result, cls):
                return result
            if Flag is not None and issubclass(cls, Flag) and cls._boundary_ is EJECT and isinstance(result, int):
                return result
            unknown = ValueError(f"{value!r} is not a valid {cls.__qualname__}")
            if result is None and failure is None:
                raise unknown
            if failure is None:
                failure = TypeError(f"error in {cls.__name__}._missing_: returned {result!r} instead of None or a valid member")
            if not isinstance(failure, ValueError):
                failure.__context__ = unknown
            raise failure
        finally:
            failure = unknown = None

    def __init__(self, *args, **keywords):
        pass

    @staticmethod
    def _generate_next_value_(name, start, count, last_values):
        if not last_values:
            return start
        try:
            last = sorted(last_values)[-1]
            return last + 1
        except TypeError:
            for last in reversed(last_values):
                try:
                    return last + 1
                except TypeError:
                    pass
            return start

    @classmethod
    def _missing_(cls, value):
        return None

    def __repr__(self):
        return f"<{self.__class__.__name__}.{self._name_}: {_value_repr(self)}>"

    def __str__(self):
        return f"{self.__class__.__name__}.{self._name_}"

    def __dir__(self):
        own = {name for cls in type(self).__mro__ for name in cls.__dict__ if name[0] != "_" and name not in self._member_map_}
        own.update(name for name in self.__dict__ if name[0] != "_")
        return sorted({"__class__", "__doc__", "__eq__", "__hash__", "__module__"} | own)

    def __format__(self, format_spec):
        return str.__format__(str(self), format_spec)

    def __hash__(self):
        return hash(self._name_)

    def __copy__(self):
        return self

    def __deepcopy__(self, memo):
        return self

    @property
    def name(self):
        return self._name_

    @property
    def value(self):
        return self._value_


def _value_repr(member):
    kind = type(member)._member_type_
    value = member._value_
    if kind is not object and hasattr(kind, "__dataclass_fields__"):
        return kind.__repr__(member)
    return repr(value)


class ReprEnum(Enum):
    """Only changes the repr(), leaving str() and format() to the mixed-in type."""


class IntEnum(int, ReprEnum):
    """Members are integers."""

    __str__ = int.__repr__
    __format__ = int.__format__


class StrEnum(str, ReprEnum):
    """Members are texts."""

    def __new__(cls, *values):
        if len(values) > 3:
            raise TypeError(f"too many arguments for str(): {values!r}")
        if len(values) == 1 and not isinstance(values[0], str):
            raise TypeError(f"{values[0]!r} is not a string")
        if len(values) >= 2 and not isinstance(values[1], str):
            raise TypeError(f"encoding must be a string, not {values[1]!r}")
        if len(values) == 3 and not isinstance(values[2], str):
            raise TypeError(f"errors must be a string, not {values[2]!r}")
        value = str(*values)
        found = str.__new__(cls, value)
        found._value_ = value
        return found

    __str__ = str.__str__
    __format__ = str.__format__

    @staticmethod
    def _generate_next_value_(name, start, count, last_values):
        return name.lower()


class FlagBoundary(StrEnum):
    """What happens to values outside of a flag's bits."""

    STRICT = auto()
    CONFORM = auto()
    EJECT = auto()
    KEEP = auto()


STRICT, CONFORM, EJECT, KEEP = FlagBoundary


class Flag(Enum, boundary=STRICT):
    """Members that can be combined."""

    _numeric_repr_ = repr

    @staticmethod
    def _generate_next_value_(name, start, count, last_values):
        if not last_values:
            return start if start is not None else 1
        last = max(last_values)
        try:
            high = last.bit_length() - 1
        except Exception:
            raise TypeError(f"invalid flag value {last!r}") from None
        return 2 ** (high + 1)

    @classmethod
    def _iter_member_by_value_(cls, value):
        for bit in _bits_of(value & cls._flag_mask_):
            found = cls._value2member_map_.get(bit)
            if found is not None:
                yield found

    _iter_member_ = _iter_member_by_value_

    @classmethod
    def _iter_member_by_def_(cls, value):
        yield from sorted(cls._iter_member_by_value_(value), key=lambda found: found._sort_order_)

    @classmethod
    def _missing_(cls, value):
        if not isinstance(value, int):
            raise ValueError(f"{value!r} is not a valid {cls.__qualname__}")
        mask, every = cls._flag_mask_, cls._all_bits_
        negative = None
        if not ~every <= value <= every or value & (every ^ mask):
            if cls._boundary_ is STRICT:
                width = max(value.bit_length(), mask.bit_length())
                raise ValueError(f"{cls!r} invalid value {value!r}\n    given {_bin(value, width)}\n  allowed {_bin(mask, width)}")
            if cls._boundary_ is CONFORM:
                value = value & mask
            elif cls._boundary_ is EJECT:
                return value
            elif cls._boundary_ is KEEP:
                if value < 0:
                    value = max(every + 1, 2 ** value.bit_length()) + value
        if value < 0:
            negative = value
            if cls._boundary_ in (EJECT, KEEP):
                value = every + 1 + value
            else:
                value = cls._singles_mask_ & value
        unknown = value & ~mask
        aliases = value & ~cls._singles_mask_
        found = cls._value2member_map_.get(value)
        if found is not None:
            return found
        if unknown and cls._boundary_ is not KEEP:
            raise ValueError(f"{cls.__name__}({value!r}) -->  unknown values {unknown!r} [{_bin(unknown, unknown.bit_length())}]")
        if cls._member_type_ is object:
            made = object.__new__(cls)
        else:
            made = cls._member_type_.__new__(cls, value)
        if not hasattr(made, "_value_"):
            made._value_ = value
        members = list(cls._iter_member_(value))
        if members:
            made._name_ = "|".join(found._name_ for found in members)
            if unknown:
                made._name_ += f"|{cls._numeric_repr_(unknown)}"
        elif unknown and cls._boundary_ is KEEP:
            made._name_ = cls._numeric_repr_(unknown)
        else:
            made._name_ = None
        made = cls._value2member_map_.setdefault(value, made)
        if negative is not None:
            cls._value2member_map_[negative] = made
        return made

    def __contains__(self, other):
        if not isinstance(other, self.__class__):
            raise TypeError(f"unsupported operand type(s) for 'in': {type(other).__qualname__!r} and {self.__class__.__qualname__!r}")
        return other._value_ & self._value_ == other._value_

    def __iter__(self):
        yield from self._iter_member_(self._value_)

    def __len__(self):
        return self._value_.bit_count()

    def __repr__(self):
        if self._name_ is None:
            return f"<{self.__class__.__name__}: {type(self)._numeric_repr_(self._value_)}>"
        return f"<{self.__class__.__name__}.{self._name_}: {type(self)._numeric_repr_(self._value_)}>"

    def __str__(self):
        if self._name_ is None:
            return f"{self.__class__.__name__}({self._value_!r})"
        return f"{self.__class__.__name__}.{self._name_}"

    def __bool__(self):
        return bool(self._value_)

    def __number(self, other):
        if isinstance(other, self.__class__):
            return other._value_
        if type(self)._member_type_ is not object and isinstance(other, type(self)._member_type_):
            return other
        return None

    def __or__(self, other):
        number = self.__number(other)
        return NotImplemented if number is None else self.__class__(self._value_ | number)

    def __and__(self, other):
        number = self.__number(other)
        return NotImplemented if number is None else self.__class__(self._value_ & number)

    def __xor__(self, other):
        number = self.__number(other)
        return NotImplemented if number is None else self.__class__(self._value_ ^ number)

    def __invert__(self):
        if self._inverted_ is None:
            if self._boundary_ in (EJECT, KEEP):
                self._inverted_ = self.__class__(~self._value_)
            else:
                self._inverted_ = self.__class__(self._singles_mask_ & ~self._value_)
        return self._inverted_

    __ror__ = __or__
    __rand__ = __and__
    __rxor__ = __xor__


class IntFlag(int, ReprEnum, Flag, boundary=KEEP):
    """Flags that are integers."""

    __str__ = int.__repr__
    __format__ = int.__format__
    __repr__ = Flag.__repr__
    __or__ = Flag.__or__
    __and__ = Flag.__and__
    __xor__ = Flag.__xor__
    __ror__ = Flag.__or__
    __rand__ = Flag.__and__
    __rxor__ = Flag.__xor__
    __invert__ = Flag.__invert__


def _bin(number, width):
    if number >= 0:
        digits, sign = bin(number)[2:], "0"
    else:
        digits, sign = bin(~number ^ ((1 << max(width, number.bit_length())) - 1))[2:], "1"
        digits = bin(number & ((1 << width) - 1))[2:]
    return f"0b{sign} {digits.rjust(width, sign)}"


def unique(enumeration):
    """Refuses enumerations with two names for one value."""
    duplicates = [(name, found._name_) for name, found in enumeration.__members__.items() if name != found._name_]
    if duplicates:
        listed = ", ".join(f"{alias} -> {name}" for alias, name in duplicates)
        raise ValueError(f"duplicate values found in {enumeration!r}: {listed}")
    return enumeration


class EnumCheck(StrEnum):
    """What `verify` checks."""

    CONTINUOUS = "no skipped integer values"
    NAMED_FLAGS = "multi-flag aliases may not contain unnamed flags"
    UNIQUE = "one name per value"


CONTINUOUS, NAMED_FLAGS, UNIQUE = EnumCheck


class verify:
    """Checks an enumeration."""

    def __init__(self, *checks):
        self.checks = checks

    def __call__(self, enumeration):
        name = enumeration.__name__
        for check in self.checks:
            if check is UNIQUE:
                duplicates = [(alias, found._name_) for alias, found in enumeration.__members__.items() if alias != found._name_]
                if duplicates:
                    listed = ", ".join(f"{alias} -> {target}" for alias, target in duplicates)
                    raise ValueError(f"aliases found in {enumeration!r}: {listed}")
            elif check is CONTINUOUS:
                values = {found._value_ for found in enumeration}
                if len(values) < 2:
                    continue
                low, high = min(values), max(values)
                if issubclass(enumeration, Flag):
                    missing = [2 ** i for i in range(low.bit_length(), high.bit_length() - 1) if 2 ** i not in values]
                    kind = "flag"
                else:
                    missing = [i for i in range(low + 1, high) if i not in values]
                    kind = "enum"
                if missing:
                    raise ValueError(f"invalid {kind} {name!r}: missing values {', '.join(map(str, missing))}")
            elif check is NAMED_FLAGS:
                names = set(enumeration._member_names_)
                values = [found._value_ for found in enumeration]
                bad, missing = [], 0
                for alias, found in enumeration._member_map_.items():
                    if alias in names or found._value_ < 0:
                        continue
                    missed = [bit for bit in _bits_of(found._value_) if bit not in values]
                    if missed:
                        bad.append(alias)
                        for bit in missed:
                            missing |= bit
                if bad:
                    alias = f"alias {bad[0]} is missing" if len(bad) == 1 else (
                        f"aliases {', '.join(bad[:-1])} and {bad[-1]} are missing")
                    value = f"value {missing:#x}" if _is_single_bit(missing) else f"combined values of {missing:#x}"
                    raise ValueError(f"invalid Flag {name!r}: {alias} {value} [use enum.show_flag_values(value) for details]")
        return enumeration


def show_flag_values(value):
    """The single bits of a value."""
    return list(_bits_of(value))


def global_enum_repr(self):
    return f"{self.__class__.__module__.split('.')[-1]}.{self._name_}"


def global_flag_repr(self):
    module = self.__class__.__module__.split(".")[-1]
    if self._name_ is None:
        return f"{module}.{self.__class__.__name__}({self._value_!r})"
    return "|".join(f"{module}.{name}" for name in self._name_.split("|"))


def global_str(self):
    if self._name_ is None:
        return f"{self.__class__.__name__}({self._value_!r})"
    return self._name_


def global_enum(cls, update_str=False):
    """Members show themselves as names of their module. Scripts are one module, so their names are not bound there."""
    cls.__repr__ = global_flag_repr if issubclass(cls, Flag) else global_enum_repr
    if not issubclass(cls, ReprEnum) or update_str:
        cls.__str__ = global_str
    return cls


def pickle_by_global_name(self, proto):
    return self.name


def pickle_by_enum_name(self, proto):
    return getattr, (self.__class__, self._name_)
