"""Enumerations.

The body of a class is taken apart as it runs (`_Body`): every name has a role, and those of members are kept with their
values. The class is made of the rest; then each member is made (`_Members`), entered under its name and value, and,
among flags, its bits are added to the mask. Members of flags that nobody named are made when they are met first.
"""

__all__ = ["EnumType", "EnumMeta", "Enum", "IntEnum", "StrEnum", "Flag", "IntFlag", "ReprEnum", "auto", "unique",
           "property", "verify", "member", "nonmember", "FlagBoundary", "STRICT", "CONFORM", "EJECT", "KEEP",
           "global_flag_repr", "global_enum_repr", "global_str", "global_enum", "EnumCheck", "CONTINUOUS",
           "NAMED_FLAGS", "UNIQUE"]

_attribute = property
_kind_of = type
_function = type(lambda: 0)
_nothing = object()
# Until the classes are made that these name.
Enum = Flag = ReprEnum = None


class auto:
    """Stands for the next value."""

    def __init__(self, value=_nothing):
        self.value = value

    def __repr__(self):
        return "auto(%s)" % ("_auto_null" if self.value is _nothing else repr(self.value))


class _Marked:
    """A value of the body with a word on what becomes of it."""

    def __init__(self, value):
        self.value = value


class nonmember(_Marked):
    """Keeps a value from becoming a member."""


class member(_Marked):
    """Makes a value a member that would not become one."""


class property:
    """A property of members whose name a member may have, too: asked of the class, it is that member."""

    def __init__(self, fget=None, fset=None, fdel=None, doc=None):
        self.fget, self.fset, self.fdel, self.name, self.clsname = fget, fset, fdel, None, None
        self.__doc__ = doc or getattr(fget, "__doc__", None)

    def __set_name__(self, owner, name):
        self.name, self.clsname = name, owner.__name__

    def _with(self, **changed):
        return type(self)(**{"fget": self.fget, "fset": self.fset, "fdel": self.fdel, **changed})

    def getter(self, fget):
        return self._with(fget=fget)

    def setter(self, fset):
        return self._with(fset=fset)

    def deleter(self, fdel):
        return self._with(fdel=fdel)

    def __get__(self, instance, owner=None):
        if instance is not None and self.fget:
            return self.fget(instance)
        home = owner if instance is None else type(instance)
        named = home.__dict__.get("_member_map_", {})
        if self.name in named:
            return named[self.name]
        raise AttributeError(self.name if instance is None else f"{home!r} member has no attribute {self.name!r}")

    def _do(self, function, word, *args):
        if not function:
            raise AttributeError(f"<enum {self.clsname!r}> cannot {word} attribute {self.name!r}")
        return function(*args)

    def __set__(self, instance, value):
        self._do(self.fset, "set", instance, value)

    def __delete__(self, instance):
        self._do(self.fdel, "delete", instance)


# The body of the class.

_SETTINGS = ("_order_", "_generate_next_value_", "_numeric_repr_", "_missing_", "_ignore_", "_iter_member_",
             "_iter_member_by_value_", "_iter_member_by_def_", "_add_alias_", "_add_value_alias_")


def _wrapped_in(name, marks):
    """Whether a name stands between so many underscores, exactly."""
    inner = name[marks:-marks]
    return bool(inner) and name == "_" * marks + inner + "_" * marks and "_" not in (inner[0], inner[-1])


def _words(names):
    return names.replace(",", " ").split() if isinstance(names, str) else list(names)


def _acts_as_attribute(value):
    """Whether a value is what classes have beside plain values: a method, a property, a descriptor."""
    return isinstance(value, (_function, staticmethod, classmethod, _attribute)) or any(
        hasattr(type(value), name) for name in ("__get__", "__set__", "__delete__"))


class _Body(dict):
    """The names of a body. `members` has those that become members, with their values, in order."""

    def __init__(self, owner, next_value):
        dict.__init__(self)
        self.owner, self.next_value = owner, next_value
        self.members, self.ignored, self.has_counted = {}, [], False

    def _role(self, name, value):
        """How an assignment is taken: by the method of this name."""
        secret = f"_{self.owner}__"
        if name.startswith(secret) and len(name) > len(secret) and not name.endswith("__"):
            return "plain"
        if _wrapped_in(name, 1):
            return "setting"
        if _wrapped_in(name, 2) or name in self.ignored:
            return "plain"
        if name in self.members:
            raise TypeError(f"{name!r} already defined as {self.members[name]!r}")
        is_plain = isinstance(value, nonmember) or _acts_as_attribute(value) and not isinstance(value, member)
        return "plain" if is_plain else "member"

    def __setitem__(self, name, value):
        kept = getattr(self, "_as_" + self._role(name, value))(name, value)
        dict.__setitem__(self, "_order_" if name == "__order__" else name, kept)

    def _as_plain(self, name, value):
        return value.value if isinstance(value, nonmember) else value

    def _as_setting(self, name, value):
        if name not in _SETTINGS:
            raise ValueError(f"_sunder_ names, such as {name!r}, are reserved for future Enum use")
        if name == "_ignore_":
            value = self.ignored = _words(value)
            if clash := {word for word in value if word in self.members}:
                raise ValueError(f"_ignore_ cannot specify already set names: {clash!r}")
        elif name == "_generate_next_value_":
            if self.has_counted:
                raise TypeError(f"{name} must be defined before members")
            self.next_value = getattr(value, "__func__", value)
        return value

    def _as_member(self, name, value):
        if name in self:
            raise TypeError(f"{name!r} already defined as {self[name]!r}")
        if isinstance(value, member):
            value = value.value
        if type(value) is tuple and any(isinstance(part, auto) for part in value):
            value = tuple(self._counted(name, part) for part in value)
        value = self.members[name] = self._counted(name, value)
        return value

    def _counted(self, name, value):
        """The value that `auto()` stands for."""
        if not isinstance(value, auto):
            return value
        self.has_counted = True
        if value.value is _nothing:
            value.value = self.next_value(name, 1, len(self.members), [*self.members.values()])
        return value.value

    def update(self, entries=(), **named):
        for name, value in {**dict(entries), **named}.items():
            self[name] = value


# Members.

_DATA = (int, float, complex, str, bytes, bytearray, tuple, list, dict, set, frozenset)


def _data_type(name, bases):
    """The type of values that members are themselves, by the bases of their class; `object` if they only have one."""
    found = []
    for base in bases:
        # A class without data that derives from one with data counts as that data.
        lowest = None
        for ancestor in base.__mro__[:-1]:
            if isinstance(ancestor, EnumType):
                data = ancestor._member_type_
                if data is object:
                    continue
            elif ancestor in _DATA or not {"__new__", "__dataclass_fields__"}.isdisjoint(ancestor.__dict__):
                data = lowest or ancestor
            else:
                lowest = lowest or ancestor
                continue
            if data not in found:
                found.append(data)
            break
    if len(found) > 1:
        raise TypeError(f"too many data types for {name!r}: {set(found)!r}")
    return found[0] if found else object


class _Members:
    """Makes the members of one class and enters them: as soon as the class is there, before anybody is told of it."""

    def __init__(self, values, data, new, parent, texts):
        self.values, self.data, self.parent, self.texts = values, data, parent, texts
        new = getattr(new, "__func__", new) or getattr(parent, "__new_member__", None)
        self.new = new or data.__new__
        self.takes_value = self.new is not object.__new__

    def __set_name__(self, cls, place):
        self.cls, self.is_flag = cls, Flag is not None and issubclass(cls, Flag)
        type.__delattr__(cls, place)
        if self.parent is not None:
            cls._settle_texts(self.data, self.parent, self.texts)
            type.__setattr__(cls, "__new__", self.parent.__new__)
        for name, value in self.values.items():
            self.enter(name, value)
        if self.is_flag:
            cls._settle_flags()

    def make(self, name, value):
        """A member before it is known whether its value is new."""
        parts = value if isinstance(value, tuple) and self.data is not tuple else (value,)
        made = self.new(self.cls, *parts) if self.takes_value else self.new(self.cls)
        if not hasattr(made, "_value_"):
            made._value_ = value if self.data is object else self._as_data(parts)
        made._name_, made.__objclass__, made._sort_order_ = name, self.cls, len(self.cls._member_names_)
        made.__init__(*parts)
        return made

    def _as_data(self, parts):
        try:
            return self.data(*parts)
        except Exception as problem:
            raise TypeError("_value_ not set in __new__, unable to create it") from problem

    def enter(self, name, value):
        cls, made = self.cls, self.make(name, value)
        value = made._value_
        known = cls._by_value(value)
        bits = value if self.is_flag and isinstance(value, int) else None
        if known is None:
            _remember(cls, value, made)
            if bits is None or _is_bit(bits):
                cls._member_names_.append(name)
        cls._member_map_[name] = made = made if known is None else known
        type.__setattr__(cls, name, self._reached_as(name, made))
        if bits is not None:
            cls._flag_mask_ |= bits
            cls._singles_mask_ |= bits if _is_bit(bits) else 0
            cls._all_bits_ = (1 << cls._flag_mask_.bit_length()) - 1

    def _reached_as(self, name, made):
        """A property that is inherited under the name of a member goes on for members."""
        for base in self.cls.__mro__[1:]:
            if name in base.__dict__:
                inherited = base.__dict__[name]
                if isinstance(inherited, property):
                    shared = inherited._with()
                    shared.__set_name__(self.cls, name)
                    return shared
                break
        return made


def _remember(cls, value, found):
    try:
        found = cls._value2member_map_.setdefault(value, found)
    except TypeError:
        cls._unhashable_values_.append((value, found))
    return found


def _is_bit(number):
    return number > 0 and not number & number - 1


def _bits_of(number):
    """The single bits of a number, the lowest first."""
    return [1 << place for place in range(number.bit_length()) if number >> place & 1]


class EnumType(type):
    """The type of enumerations."""

    @classmethod
    def __prepare__(metacls, name, bases, **options):
        for base in bases:
            for ancestor in base.__mro__:
                if isinstance(ancestor, EnumType) and len(ancestor):
                    raise TypeError(f"<enum {name!r}> cannot extend {ancestor!r}")
        if bases and not isinstance(bases[-1], EnumType):
            raise TypeError("new enumerations should be created as "
                            "`EnumName([mixin_type, ...] [data_type,] enum_type)`")
        return _Body(name, bases[-1]._generate_next_value_ if bases else None)

    def __new__(metacls, name, bases, body, *, boundary=None, **options):
        parent = bases[-1] if bases else None
        members, order = dict(body.members), body.get("_order_")
        if refused := {"mro", ""} & {*members}:
            raise ValueError("invalid enum member name(s) " + ",".join(map(repr, refused)))
        left_out = {"_order_", "_ignore_", *body.ignored, *members}
        rest = {key: value for key, value in body.items() if key not in left_out}
        # The rule for the next value needs no member.
        if isinstance(rule := rest.get("_generate_next_value_"), _function):
            rest["_generate_next_value_"] = staticmethod(rule)
        data = _data_type(name, bases)
        if ReprEnum in bases and data is object:
            raise TypeError("ReprEnum subclasses must be mixed with a data type (i.e. int, str, float, etc.)")
        rest.update(
            _member_names_=[], _member_map_={}, _value2member_map_={}, _unhashable_values_=[], _member_type_=data,
            _boundary_=boundary or getattr(parent, "_boundary_", None),
            _flag_mask_=0, _singles_mask_=0, _all_bits_=0, _inverted_=None,
        )
        if parent is not None and "__new__" in rest:
            # Members are made by it; the class looks them up.
            rest["__new_member__"] = rest.pop("__new__")
        texts = {key for key in ("__repr__", "__str__", "__format__") if key in rest}
        rest["_members_"] = _Members(members, data, parent and rest.get("__new_member__"), parent, texts)
        try:
            cls = super().__new__(metacls, name, bases, rest, **options)
        except RuntimeError as wrapped:
            # What is wrong with a member is told as it is.
            raise wrapped.__cause__ or wrapped
        if order is not None:
            cls._check_order([word for word in _words(order) if word in cls._member_map_])
        return cls

    def _settle_texts(cls, data, parent, own):
        """Members look as enumerations say, not as their data does, except where `ReprEnum` says so."""
        if data is object:
            return
        by_data = {}
        if ReprEnum in cls.__bases__:
            by_data = {"__str__": data.__str__ if issubclass(data, str) else data.__repr__,
                       "__format__": data.__format__}
        for name in ("__repr__", "__str__", "__format__"):
            if name in own:
                continue
            first = next((base for base in cls.__mro__[1:] if name in base.__dict__), parent)
            inherited = None if isinstance(first, EnumType) else getattr(parent, name)
            if "__dataclass_fields__" in data.__dict__ and name == "__repr__":
                inherited = parent.__repr__
            if chosen := by_data.get(name, inherited):
                type.__setattr__(cls, name, chosen)

    def _settle_flags(cls):
        for name in _FLAG_OPERATORS:
            if name not in cls.__dict__:
                type.__setattr__(cls, name, Flag.__dict__[name])
        by_definition = [cls._member_map_[name] for name in cls._member_names_]
        if any(one._value_ > other._value_ for one, other in zip(by_definition, by_definition[1:])):
            type.__setattr__(cls, "_iter_member_", cls._iter_member_by_def_)

    def _check_order(cls, wanted):
        names = [name for name in wanted if name in cls._member_names_]
        if names != cls._member_names_:
            raise TypeError(f"member order does not match _order_:\n  {cls._member_names_!r}\n  {names!r}")

    def _by_value(cls, value):
        """The member with a value; None if there is none."""
        try:
            return cls._value2member_map_.get(value)
        except TypeError:
            return next((found for known, found in cls._unhashable_values_ if known == value), None)

    # What an enumeration is as an object: a table of its members.

    def __call__(cls, value, names=None, *, module=None, qualname=None, type=None, start=1, boundary=None):
        if names is None:
            return cls.__new__(cls, value)
        bases = (cls,) if type is None else (type, cls)
        body = _kind_of(cls).__prepare__(value, bases)
        names, values = _words(names) if not isinstance(names, dict) else [*names.items()], []
        for count, entry in enumerate(names):
            name, given = (entry, _nothing) if isinstance(entry, str) else entry
            if given is _nothing:
                given = body.next_value(name, start, count, values[:])
            values.append(given)
            body[name] = given
        body.update(__module__=module or "__main__", **({} if qualname is None else {"__qualname__": qualname}))
        return _kind_of(cls)(value, bases, body, boundary=boundary)

    def __contains__(cls, value):
        if isinstance(value, Enum):
            return isinstance(value, cls) and cls._member_map_.get(value._name_, _nothing) is not _nothing
        kinds = [_kind_of(side).__qualname__ for side in (value, cls)]
        raise TypeError("unsupported operand type(s) for 'in': '%s' and '%s'" % (*kinds,))

    def __getitem__(cls, name):
        return cls._member_map_[name]

    def __len__(cls):
        return len(cls.__dict__["_member_names_"])

    def __bool__(cls):
        return True

    def __iter__(cls):
        return map(cls._member_map_.__getitem__, cls._member_names_)

    def __reversed__(cls):
        return map(cls._member_map_.__getitem__, reversed(cls._member_names_))

    @_attribute
    def __members__(cls):
        return _MappingProxy(cls._member_map_)

    def __setattr__(cls, name, value):
        if name in cls.__dict__.get("_member_map_", ()):
            raise AttributeError(f"cannot reassign member {name!r}")
        type.__setattr__(cls, name, value)

    def __delattr__(cls, name):
        if name in cls._member_map_:
            raise AttributeError(f"{cls.__name__!r} cannot delete member {name!r}.")
        type.__delattr__(cls, name)

    def __getattr__(cls, name):
        raise AttributeError(name)

    def __repr__(cls):
        is_flag = Flag is not None and issubclass(cls, Flag)
        return f"<{'flag' if is_flag else 'enum'} {cls.__name__!r}>"

    def __dir__(cls):
        return sorted(["__class__", "__contains__", "__doc__", "__getitem__", "__init_subclass__", "__iter__",
                       "__len__", "__members__", "__module__", "__name__", "__qualname__", *cls._member_names_])


EnumMeta = EnumType


class _MappingProxy(dict):
    """The members of an enumeration, to read."""

    def __repr__(self):
        return f"mappingproxy({dict(self)!r})"

    def __str__(self):
        return dict.__repr__(self)

    def _refuse(self, *args):
        raise TypeError("'mappingproxy' object does not support item assignment")

    __setitem__ = __delitem__ = _refuse


_MappingProxy.__name__ = "mappingproxy"


class Enum(metaclass=EnumType):
    """A set of names with values."""

    def __new__(cls, value):
        """The member with a value, or the one that `_missing_` has for it."""
        found = value if type(value) is cls else cls._by_value(value)
        if found is not None:
            return found
        refusal = ValueError(f"{value!r} is not a valid {cls.__qualname__}")
        try:
            found = cls._missing_(value)
        except ValueError:
            raise
        except Exception as problem:
            problem.__context__ = refusal
            raise
        if isinstance(found, cls) or isinstance(found, int) and cls._boundary_ is EJECT:
            return found
        if found is not None:
            wrong = f"error in {cls.__name__}._missing_: returned {found!r} instead of None or a valid member"
            refusal, context = TypeError(wrong), refusal
            refusal.__context__ = context
        raise refusal

    def __init__(self, *args, **named):
        """Members may be set up by their values."""

    @staticmethod
    def _generate_next_value_(name, start, count, last_values):
        """One more than the highest value, or than the last one that has a next."""
        try:
            return max(last_values, default=start - 1) + 1
        except TypeError:
            pass
        for value in last_values[::-1]:
            try:
                return value + 1
            except TypeError:
                continue
        return start

    @classmethod
    def _missing_(cls, value):
        """For subclasses that know more values than their members have."""

    name = property(lambda self: self._name_)
    value = property(lambda self: self._value_)

    def __repr__(self):
        return f"<{type(self).__name__}.{self._name_}: {_shown(self)}>"

    def __str__(self):
        return type(self).__name__ + "." + self._name_

    def __format__(self, format_spec):
        return format(str(self), format_spec)

    def __hash__(self):
        return hash(self._name_)

    def __dir__(self):
        cls = type(self)
        places = [self.__dict__, *(home.__dict__ for home in cls.__mro__)]
        found = {name for place in places for name in place
                 if not name.startswith("_") and name not in cls._member_map_}
        return sorted(found | {"__class__", "__doc__", "__eq__", "__hash__", "__module__"})

    def __copy__(self):
        return self

    def __deepcopy__(self, memo):
        return self


def _shown(found):
    """The value of a member as its own type shows it; of data classes without their name of the enumeration."""
    data = type(found)._member_type_
    if hasattr(data, "__dataclass_fields__"):
        fields = ", ".join(f"{name}={getattr(found, name)!r}" for name in data.__dataclass_fields__)
        return f"{data.__qualname__}({fields})"
    return repr(found._value_)


class ReprEnum(Enum):
    """Only the repr() is that of enumerations; str() and format() are those of the data."""


class IntEnum(int, ReprEnum):
    """Members are integers."""


class StrEnum(str, ReprEnum):
    """Members are texts."""

    def __new__(cls, *values):
        if len(values) > 3:
            raise TypeError(f"too many arguments for str(): {values!r}")
        for value, refusal in zip(values, ("%r is not a string", "encoding must be a string, not %r",
                                           "errors must be a string, not %r")):
            if not isinstance(value, str) and (len(values) == 1 or value is not values[0]):
                raise TypeError(refusal % (value,))
        text = str(*values)
        made = str.__new__(cls, text)
        made._value_ = text
        return made

    @staticmethod
    def _generate_next_value_(name, start, count, last_values):
        return str.lower(name)


class FlagBoundary(StrEnum):
    """What happens to values outside of a flag's bits."""

    STRICT, CONFORM, EJECT, KEEP = "strict", "conform", "eject", "keep"


STRICT, CONFORM, EJECT, KEEP = [*FlagBoundary]


def _operation(combine):
    """An operator of flags that makes one value of two; the other side is a flag of the class, or plain data of it."""
    def operate(self, other):
        data = type(self)._member_type_
        if isinstance(other, type(self)):
            other = other._value_
        elif data is object or not isinstance(other, data):
            return NotImplemented
        return type(self)(combine(self._value_, other))
    return operate


def _show_bits(number, width):
    """A number as its sign and so many bits."""
    own, sign = number.bit_length(), str(int(number < 0))
    digits = format(number & (1 << own) - 1, f"0{own}b")
    return f"0b{sign} {digits.rjust(width, sign)}"


class Flag(Enum, boundary=STRICT):
    """Members that can be combined."""

    _numeric_repr_ = repr

    @staticmethod
    def _generate_next_value_(name, start, count, last_values):
        """The bit above the highest one that is in use."""
        if not last_values:
            return 1 if start is None else start
        highest = max(last_values)
        if not isinstance(highest, int):
            raise TypeError(f"invalid flag value {highest!r}")
        return 1 << highest.bit_length()

    @classmethod
    def _iter_member_by_value_(cls, value):
        found = map(cls._value2member_map_.get, _bits_of(value & cls._flag_mask_))
        return (one for one in found if one is not None)

    _iter_member_ = _iter_member_by_value_

    @classmethod
    def _iter_member_by_def_(cls, value):
        return iter(sorted(cls._iter_member_by_value_(value), key=lambda found: found._sort_order_))

    @classmethod
    def _missing_(cls, value):
        """The combination of members that a value stands for."""
        if not isinstance(value, int):
            raise ValueError(f"{value!r} is not a valid {cls.__qualname__}")
        bits = cls._within(value)
        if cls._boundary_ is EJECT and bits is None:
            return value
        found = cls._value2member_map_.get(bits)
        if found is None:
            found = _remember(cls, bits, cls._combination(bits))
        if value < 0:
            _remember(cls, value, found)
        return found

    @classmethod
    def _within(cls, value):
        """The bits of a value, as the boundary has it; None for a value that is to be left as it is."""
        mask, every, rule = cls._flag_mask_, cls._all_bits_, cls._boundary_
        fits = ~every <= value <= every and not value & (every ^ mask)
        if not fits and rule is STRICT:
            width = max(value.bit_length(), mask.bit_length())
            lines = [f"{cls!r} invalid value {value!r}", f"    given {_show_bits(value, width)}",
                     f"  allowed {_show_bits(mask, width)}"]
            raise ValueError("\n".join(lines))
        if not fits and rule is EJECT:
            return None
        if not fits and rule is CONFORM:
            value &= mask
        if value >= 0:
            return value
        if rule is KEEP:
            # As many bits as the value has, if those are more than the members'.
            return value + max(every + 1, 1 << value.bit_length())
        return every + 1 + value if rule is EJECT else value & cls._singles_mask_

    @classmethod
    def _combination(cls, bits):
        data, strange = cls._member_type_, bits & ~cls._flag_mask_
        if strange and cls._boundary_ is not KEEP:
            shown = _show_bits(strange, strange.bit_length())
            raise ValueError(f"{cls.__name__}({bits!r}) -->  unknown values {strange!r} [{shown}]")
        made = object.__new__(cls) if data is object else data.__new__(cls, bits)
        names = [found._name_ for found in cls._iter_member_(bits)]
        if names and strange:
            names.append(cls._numeric_repr_(strange))
        made._value_, made._name_ = bits, "|".join(names) or None
        return made

    def __repr__(self):
        name = "" if self._name_ is None else "." + self._name_
        return f"<{type(self).__name__}{name}: {type(self)._numeric_repr_(self._value_)}>"

    def __str__(self):
        cls = type(self).__name__
        return f"{cls}({self._value_!r})" if self._name_ is None else f"{cls}.{self._name_}"

    def __bool__(self):
        return self._value_ != 0

    def __len__(self):
        return int.bit_count(self._value_)

    def __iter__(self):
        return iter(self._iter_member_(self._value_))

    def __contains__(self, other):
        cls = type(self)
        if isinstance(other, cls):
            return not other._value_ & ~self._value_
        raise TypeError(f"unsupported operand type(s) for 'in': {type(other).__qualname__!r} and {cls.__qualname__!r}")

    __or__, __and__, __xor__ = map(_operation, (int.__or__, int.__and__, int.__xor__))
    __ror__, __rand__, __rxor__ = __or__, __and__, __xor__

    def __invert__(self):
        other = self._inverted_
        if other is None:
            cls = type(self)
            keeps_all = cls._boundary_ in (KEEP, EJECT)
            other = self._inverted_ = cls(~self._value_ if keeps_all else cls._singles_mask_ & ~self._value_)
        return other


_FLAG_OPERATORS = ("__or__", "__and__", "__xor__", "__ror__", "__rand__", "__rxor__", "__invert__")


class IntFlag(int, ReprEnum, Flag, boundary=KEEP):
    """Flags that are integers."""

    __repr__ = Flag.__repr__


# Checks of whole enumerations.

def _aliases(enumeration):
    return [(name, found._name_) for name, found in enumeration.__members__.items() if found._name_ != name]


def _refuse_aliases(enumeration, word):
    if aliases := _aliases(enumeration):
        shown = ", ".join(f"{alias} -> {name}" for alias, name in aliases)
        raise ValueError(f"{word} found in {enumeration!r}: {shown}")


def unique(enumeration):
    """Refuses enumerations with two names for one value."""
    _refuse_aliases(enumeration, "duplicate values")
    return enumeration


class EnumCheck(StrEnum):
    """What `verify` checks."""

    CONTINUOUS, NAMED_FLAGS, UNIQUE = (
        "no skipped integer values", "multi-flag aliases may not contain unnamed flags", "one name per value")


CONTINUOUS, NAMED_FLAGS, UNIQUE = [*EnumCheck]


def _check_continuous(enumeration):
    values = sorted({found._value_ for found in enumeration})
    if len(values) < 2:
        return
    is_flag = issubclass(enumeration, Flag)
    between = range(values[0] + 1, values[-1])
    if is_flag:
        between = [1 << place for place in range(values[0].bit_length(), values[-1].bit_length() - 1)]
    if skipped := [str(value) for value in between if value not in values]:
        kind = "flag" if is_flag else "enum"
        raise ValueError(f"invalid {kind} {enumeration.__name__!r}: missing values {', '.join(skipped)}")


def _check_named(enumeration):
    named = {found._value_ for found in enumeration}
    unnamed = {}
    for alias, found in enumeration._member_map_.items():
        if alias not in enumeration._member_names_ and found._value_ >= 0:
            if bits := {bit for bit in _bits_of(found._value_) if bit not in named}:
                unnamed[alias] = sum(bits), bits
    if not unnamed:
        return
    *others, last = unnamed
    who = f"aliases {', '.join(others)} and {last} are" if others else f"alias {last} is"
    missing = sum({bit for _, bits in unnamed.values() for bit in bits})
    what = f"value {missing:#x}" if _is_bit(missing) else f"combined values of {missing:#x}"
    raise ValueError(f"invalid Flag {enumeration.__name__!r}: {who} missing {what} "
                     "[use enum.show_flag_values(value) for details]")


class verify:
    """Checks an enumeration."""

    _done_by = {
        UNIQUE: lambda enumeration: _refuse_aliases(enumeration, "aliases"),
        CONTINUOUS: _check_continuous,
        NAMED_FLAGS: _check_named,
    }

    def __init__(self, *checks):
        self.checks = checks

    def __call__(self, enumeration):
        for check in self.checks:
            self._done_by[check](enumeration)
        return enumeration


def show_flag_values(value):
    """The single bits of a value."""
    return _bits_of(value)


# Members as names of their module.

def _module_of(found):
    return type(found).__module__.rpartition(".")[2]


def global_enum_repr(self):
    return f"{_module_of(self)}.{self._name_}"


def global_flag_repr(self):
    module = _module_of(self)
    if self._name_ is None:
        return f"{module}.{type(self).__name__}({self._value_!r})"
    return "|".join(module + "." + name for name in self._name_.split("|"))


def global_str(self):
    return self._name_ or f"{type(self).__name__}({self._value_!r})"


def global_enum(cls, update_str=False):
    """Members show themselves as names of their module. Scripts are one module, so their names are not bound there."""
    cls.__repr__ = (global_enum_repr, global_flag_repr)[issubclass(cls, Flag)]
    if update_str or not issubclass(cls, ReprEnum):
        cls.__str__ = global_str
    return cls


def pickle_by_global_name(self, proto):
    return self._name_


def pickle_by_enum_name(self, proto):
    return getattr, (type(self), self._name_)
