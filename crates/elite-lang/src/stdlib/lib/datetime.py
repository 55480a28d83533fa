"""Dates, times of day and spans of time. The controller's local time is UTC."""
from _time import time as _now, _format
from math import floor as _floor
from operator import index as _index

MINYEAR = 1
MAXYEAR = 9999

_MONTHS = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"]
_FULL_MONTHS = ["January", "February", "March", "April", "May", "June", "July", "August", "September", "October",
                "November", "December"]
_DAYS = ["Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun"]
_FULL_DAYS = ["Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday"]


_SAME = object()  # what `replace` leaves as it is


def _is_leap(year):
    return year % 4 == 0 and (year % 100 != 0 or year % 400 == 0)


def _days_in_month(year, month):
    return 29 if month == 2 and _is_leap(year) else (31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31)[month - 1]


def _days_before_year(year):
    year -= 1
    return year * 365 + year // 4 - year // 100 + year // 400


def _days_before_month(year, month):
    return sum(_days_in_month(year, m) for m in range(1, month))


def _to_ordinal(year, month, day):
    return _days_before_year(year) + _days_before_month(year, month) + day


def _from_ordinal(n):
    year = min(n // 365 + 1, MAXYEAR + 1)
    while _days_before_year(year) >= n:
        year -= 1
    n -= _days_before_year(year)
    month = 1
    while n > _days_in_month(year, month):
        n -= _days_in_month(year, month)
        month += 1
    return year, month, n


def _check_int(value):
    """A number of 32 bits, which is what C has here."""
    number = value
    if not isinstance(value, int):
        if not hasattr(type(value), "__index__"):
            raise TypeError(f"'{_of_type(value)}' object cannot be interpreted as an integer")
        number = type(value).__index__(value)
        if not isinstance(number, int):
            raise TypeError(f"__index__ returned non-int (type {type(number).__name__})")
    number = int.__index__(number)  # the number that it is, whatever its class says
    if -0x80000000 <= number <= 0x7fffffff:
        return number
    if number.bit_length() < 64 or number == -2 ** 63:
        raise OverflowError(f"signed integer is {'greater than maximum' if number > 0 else 'less than minimum'}")
    raise OverflowError("Python int too large to convert to C long")


def _seconds(value):
    """Seconds since 1970, as C takes them."""
    if isinstance(value, float):
        if value != value:
            raise ValueError("Invalid value NaN (not a number)")
        fits = -2.0 ** 63 <= value < 2.0 ** 63
    elif hasattr(type(value), "__index__"):
        value = _index(value)
        fits = value.bit_length() < 64 or value == -2 ** 63
    else:
        raise TypeError(f"'{_of_type(value)}' object cannot be interpreted as an integer")
    if not fits:
        raise OverflowError("timestamp out of range for platform time_t")
    return value


def _days_of(seconds):
    days = _floor(seconds) // 86400
    if not -719162 <= days <= 2932896:
        # In years of the calendar that goes on both ways, 400 of which have as many days each time.
        cycles, rest = divmod(days + 719162, 146097)
        year = cycles * 400 + _from_ordinal(rest + 1)[0]
        if not -0x80000000 <= year <= 0x7fffffff:
            raise OSError(75, "Value too large for defined data type")
        raise ValueError(f"year {year} is out of range")
    return days


def _of_type(value):
    """How C calls its type: those of this module with the module."""
    cls = type(value)
    return f"datetime.{cls.__name__}" if cls.__module__ == "datetime" else cls.__name__


def _argument(value):
    return "None" if value is None else _of_type(value)


def _check_date(year, month, day):
    if not MINYEAR <= year <= MAXYEAR:
        raise ValueError(f"year {year} is out of range")
    if not 1 <= month <= 12:
        raise ValueError("month must be in 1..12")
    if not 1 <= day <= _days_in_month(year, month):
        raise ValueError("day is out of range for month")


def _check_time(hour, minute, second, microsecond, fold):
    for value, most, name in ((hour, 23, "hour"), (minute, 59, "minute"), (second, 59, "second"),
                              (microsecond, 999999, "microsecond")):
        if not 0 <= value <= most:
            raise ValueError(f"{name} must be in 0..{most}")
    if fold not in (0, 1):
        raise ValueError("fold must be either 0 or 1")


def _check_zone(tz):
    if tz is not None and not isinstance(tz, tzinfo):
        raise TypeError(f"tzinfo argument must be None or of a tzinfo subclass, not type '{type(tz).__name__}'")


def _named(value):
    """How `repr` names its class: those of this module with the module."""
    cls = type(value)
    return f"datetime.{cls.__name__}" if cls in (timedelta, date, time, datetime) else cls.__name__


class timedelta:
    """A span of time: days, seconds and microseconds, the latter two never negative."""

    __slots__ = ("_days", "_seconds", "_microseconds")

    def __init__(self, days=0, seconds=0, microseconds=0, milliseconds=0, minutes=0, hours=0, weeks=0):
        total = 0
        rest = 0.0
        # In the order in which C looks at them.
        for name, value, factor in (("microseconds", microseconds, 1), ("milliseconds", milliseconds, 1000),
                                    ("seconds", seconds, 1000000), ("minutes", minutes, 60000000),
                                    ("hours", hours, 3600000000), ("days", days, 86400000000),
                                    ("weeks", weeks, 604800000000)):
            if isinstance(value, int):
                total = total + value * factor  # `+`, which refuses in its own words
            elif isinstance(value, float):
                value = float.__pos__(value)  # the number that it is, whatever its class says
                whole = int(value)
                total = total + whole * factor
                rest += (value - whole) * factor
            else:
                raise TypeError(f"unsupported type for timedelta {name} component: {_of_type(value)}")
        nearest = total + round(rest)
        if abs(rest - int(rest)) == 0.5 and nearest % 2 == 1:
            nearest += 1 if rest > round(rest) else -1
        self._set(nearest)

    def _set(self, total):
        days, rest = divmod(total, 86400000000)
        if isinstance(rest, float):
            raise TypeError("'float' object cannot be interpreted as an integer")
        if abs(days) > 999999999:
            if abs(days) > 2147483647:
                raise OverflowError("Python int too large to convert to C int")
            raise OverflowError(f"days={days}; must have magnitude <= 999999999")
        self._days = days
        self._seconds, self._microseconds = divmod(rest, 1000000)

    days = property(lambda self: self._days)
    seconds = property(lambda self: self._seconds)
    microseconds = property(lambda self: self._microseconds)

    def _total(self):
        return (self._days * 86400 + self._seconds) * 1000000 + self._microseconds

    def total_seconds(self):
        return self._total() / 10 ** 6

    def __repr__(self):
        parts = [f"{name}={value}" for name, value in (("days", self._days), ("seconds", self._seconds),
                                                       ("microseconds", self._microseconds)) if value]
        return f"{_named(self)}({', '.join(parts) or '0'})"

    def __str__(self):
        minutes, seconds = divmod(self._seconds, 60)
        hours, minutes = divmod(minutes, 60)
        text = f"{hours}:{minutes:02}:{seconds:02}"
        if self._days:
            text = f"{self._days} day{'' if abs(self._days) == 1 else 's'}, {text}"
        if self._microseconds:
            text += f".{self._microseconds:06}"
        return text

    def __add__(self, other):
        if isinstance(other, timedelta):
            return _span(self._total() + other._total())
        return NotImplemented

    __radd__ = __add__

    def __sub__(self, other):
        if isinstance(other, timedelta):
            return _span(self._total() - other._total())
        return NotImplemented

    def __rsub__(self, other):
        if isinstance(other, timedelta):
            return other - self
        return NotImplemented

    def __neg__(self):
        return _span(-self._total())

    def __pos__(self):
        return self

    def __abs__(self):
        return _span(abs(self._total()))

    def __mul__(self, other):
        if isinstance(other, int):
            return _span(other * self._total())  # in this order: a class may have its own multiplication
        if isinstance(other, float):
            a, b = other.as_integer_ratio()
            return _span(_rounded_quotient(self._total() * a, b))
        return NotImplemented

    __rmul__ = __mul__

    def __floordiv__(self, other):
        if isinstance(other, timedelta):
            return self._total() // other._total()
        if isinstance(other, int):
            return _span(self._total() // other)
        return NotImplemented

    def __truediv__(self, other):
        if isinstance(other, timedelta):
            return self._total() / other._total()
        if isinstance(other, int):
            return _span(_rounded_quotient(self._total(), other))
        if isinstance(other, float):
            a, b = other.as_integer_ratio()
            return _span(_rounded_quotient(self._total() * b, a))
        return NotImplemented

    def __mod__(self, other):
        if isinstance(other, timedelta):
            return _span(self._total() % other._total())
        return NotImplemented

    def __divmod__(self, other):
        if isinstance(other, timedelta):
            quotient, rest = divmod(self._total(), other._total())
            return quotient, _span(rest)
        return NotImplemented

    def __eq__(self, other):
        return self._total() == other._total() if isinstance(other, timedelta) else NotImplemented

    def __lt__(self, other):
        return self._total() < other._total() if isinstance(other, timedelta) else NotImplemented

    def __le__(self, other):
        return self._total() <= other._total() if isinstance(other, timedelta) else NotImplemented

    def __gt__(self, other):
        return self._total() > other._total() if isinstance(other, timedelta) else NotImplemented

    def __ge__(self, other):
        return self._total() >= other._total() if isinstance(other, timedelta) else NotImplemented

    def __hash__(self):
        return hash((self._days, self._seconds, self._microseconds))

    def __bool__(self):
        return self._total() != 0


def _rounded_quotient(a, b):
    """The integer nearest to a / b, ties to even."""
    quotient, rest = divmod(a, b)
    rest *= 2
    above = rest > b if b > 0 else rest < b
    if above or rest == b and quotient % 2 == 1:
        quotient += 1
    return quotient


def _span(microseconds):
    made = timedelta()
    made._set(microseconds)
    return made


timedelta.min = timedelta(-999999999)
timedelta.max = timedelta(days=999999999, hours=23, minutes=59, seconds=59, microseconds=999999)
timedelta.resolution = timedelta(microseconds=1)


class tzinfo:
    """What a time zone has to answer."""

    __slots__ = ()

    def tzname(self, dt):
        raise NotImplementedError("a tzinfo subclass must implement tzname()")

    def utcoffset(self, dt):
        raise NotImplementedError("a tzinfo subclass must implement utcoffset()")

    def dst(self, dt):
        raise NotImplementedError("a tzinfo subclass must implement dst()")

    def fromutc(self, dt):
        if not isinstance(dt, datetime):
            raise TypeError("fromutc: argument must be a datetime")
        if dt.tzinfo is not self:
            raise ValueError("fromutc: dt.tzinfo is not self")
        offset, dst = dt.utcoffset(), dt.dst()
        if offset is None or dst is None:
            raise ValueError(f"fromutc: non-None {'utcoffset' if offset is None else 'dst'}() result required")
        standard = offset - dst
        if standard:
            # Whether it is summer is asked at the standard time of the zone.
            dt += standard
            dst = dt.dst()
            if dst is None:
                raise ValueError("fromutc: tz.dst gave inconsistent results; cannot convert")
        return dt + dst


_NO_NAME = object()


class timezone(tzinfo):
    __slots__ = ("_offset", "_name")

    def __new__(cls, *args, **names):
        # There is one of no offset and no name.
        only = (*args, *names.values()) if names.keys() <= {"offset"} else ()
        utc = getattr(cls, "utc", None)
        return utc if utc and len(only) == 1 and only[0] == timedelta(0) else object.__new__(cls)

    def __init__(self, offset, name=_NO_NAME):
        if not isinstance(offset, timedelta):
            raise TypeError("timezone() argument 1 must be datetime.timedelta, not " + _argument(offset))
        if name is _NO_NAME:
            name = None
        elif not isinstance(name, str):
            raise TypeError(f"timezone() argument 2 must be str, not {_argument(name)}")
        if not timedelta(-1) < offset < timedelta(1):
            raise ValueError("offset must be a timedelta strictly between -timedelta(hours=24) and "
                             f"timedelta(hours=24), not {offset!r}.")
        self._offset = offset
        self._name = name

    def __getinitargs__(self):
        return (self._offset,) if self._name is None else (self._offset, self._name)

    def __reduce__(self):
        return timezone, self.__getinitargs__(), None

    def utcoffset(self, dt):
        return self._offset

    def dst(self, dt):
        return None

    def tzname(self, dt):
        if self._name is not None:
            return self._name
        return "UTC" + (_offset_text(self._offset) if self._offset else "")

    def fromutc(self, dt):
        if not isinstance(dt, datetime):
            raise TypeError("fromutc: argument must be a datetime")
        if dt.tzinfo is not self:
            raise ValueError("fromutc: dt.tzinfo is not self")
        return dt + self._offset

    def __eq__(self, other):
        return self._offset == other._offset if isinstance(other, timezone) else NotImplemented

    def __hash__(self):
        return hash(self._offset)

    def __repr__(self):
        if self is timezone.utc:
            return "datetime.timezone.utc"
        name = "" if self._name is None else f", {self._name!r}"
        return f"datetime.timezone({self._offset!r}{name})"

    def __str__(self):
        return self.tzname(None)


def _offset_text(offset, separator=":"):
    total = offset._total() // 1000000
    sign = "-" if total < 0 else "+"
    minutes, seconds = divmod(abs(total), 60)
    hours, minutes = divmod(minutes, 60)
    text = f"{sign}{hours:02}{separator}{minutes:02}"
    return f"{text}{separator}{seconds:02}" if seconds else text


timezone.utc = timezone(timedelta(0))
timezone.min = timezone(-timedelta(hours=23, minutes=59))
timezone.max = timezone(timedelta(hours=23, minutes=59))
UTC = timezone.utc


def _strftime(self, format, fields, microsecond=0):
    offset, name = self.utcoffset() if hasattr(self, "utcoffset") else None, ""
    if hasattr(self, "tzname"):
        name = self.tzname() or ""
    if not isinstance(format, str):
        raise TypeError(f"strftime() argument 1 must be str, not {_argument(format)}")
    format.encode()  # no half letters
    format = format.partition("\0")[0]  # C's texts end there
    out, at = "", 0
    while True:
        found = format.find("%", at)
        if found < 0 or found + 1 >= len(format):
            out += format[at:]
            break
        out += format[at:found]
        code = format[found + 1]
        if code == "f":
            out += f"{microsecond:06}"
        elif code == "z":
            out += "" if offset is None else _offset_text(offset, "")
        elif code == "Z":
            out += name.replace("%", "%%")
        else:
            out += "%" + code
        at = found + 2
    return _format(out, fields)


def _formatted(value, spec):
    if not isinstance(spec, str):
        raise TypeError(f"__format__() argument 1 must be str, not {_argument(spec)}")
    return value.strftime(spec) if spec else str(value)


class date:
    __slots__ = ("_year", "_month", "_day")

    def __init__(self, year, month, day):
        self._year, self._month, self._day = year, month, day = _check_int(year), _check_int(month), _check_int(day)
        _check_date(year, month, day)

    year = property(lambda self: self._year)
    month = property(lambda self: self._month)
    day = property(lambda self: self._day)

    @classmethod
    def today(cls):
        return cls.fromtimestamp(_now())

    @classmethod
    def fromtimestamp(cls, timestamp):
        return cls(*_from_ordinal(_days_of(_seconds(timestamp)) + 719163))

    @classmethod
    def fromordinal(cls, n):
        n = _check_int(n)
        if n < 1:
            raise ValueError("ordinal must be >= 1")
        if n > 3652059:
            raise ValueError("year is out of range")
        return cls(*_from_ordinal(n))

    @classmethod
    def fromisoformat(cls, date_string):
        if not isinstance(date_string, str):
            raise TypeError("fromisoformat: argument must be str")
        fields = _iso_date(date_string)
        if fields is None:
            raise ValueError(f"Invalid isoformat string: {date_string!r}")
        return cls(*fields)

    @classmethod
    def fromisocalendar(cls, year, week, day):
        try:
            year, week, day = _check_int(year), _check_int(week), _check_int(day)
        except OverflowError:
            raise ValueError("ISO calendar component out of range") from None
        if not MINYEAR <= year <= MAXYEAR:
            raise ValueError(f"Year is out of range: {year}")
        first = _iso_week_one(year)
        weeks = (_iso_week_one(year + 1) - first) // 7
        if not 1 <= week <= weeks:
            raise ValueError(f"Invalid week: {week}")
        if not 1 <= day <= 7:
            raise ValueError(f"Invalid day: {day} (range is [1, 7])")
        return cls(*_from_ordinal(first + (week - 1) * 7 + day - 1))

    def toordinal(self):
        return _to_ordinal(self._year, self._month, self._day)

    def weekday(self):
        return (self.toordinal() + 6) % 7

    def isoweekday(self):
        return self.weekday() + 1

    def isocalendar(self):
        year, today = self._year, self.toordinal()
        if today >= _iso_week_one(year + 1):
            year += 1
        elif today < _iso_week_one(year):
            year -= 1
        return IsoCalendarDate((year, (today - _iso_week_one(year)) // 7 + 1, self.isoweekday()))

    def isoformat(self):
        return f"{self._year:04}-{self._month:02}-{self._day:02}"

    def __str__(self):
        return self.isoformat()

    def __repr__(self):
        return f"{_named(self)}({self._year}, {self._month}, {self._day})"

    def ctime(self):
        return self.strftime("%a %b %e 00:00:00 %Y")

    def _fields(self):
        first = _to_ordinal(self._year, 1, 1)
        return (self._year, self._month, self._day, 0, 0, 0, self.weekday(), self.toordinal() - first + 1, -1)

    def timetuple(self):
        from time import struct_time
        return struct_time(self._fields())

    def strftime(self, format):
        return _strftime(self, format, self._fields())

    def __format__(self, spec):
        return _formatted(self, spec)

    def replace(self, year=_SAME, month=_SAME, day=_SAME):
        return type(self)(self._year if year is _SAME else year, self._month if month is _SAME else month,
                          self._day if day is _SAME else day)

    def __add__(self, other):
        if isinstance(other, timedelta) and not isinstance(self, datetime):
            n = self.toordinal() + other.days
            if not 0 < n <= 3652059:
                raise OverflowError("date value out of range")
            return type(self).fromordinal(n)
        return NotImplemented

    __radd__ = __add__

    def __sub__(self, other):
        if isinstance(self, datetime) or isinstance(other, datetime):
            return NotImplemented
        if isinstance(other, timedelta):
            return self + timedelta(-other.days)
        if isinstance(other, date):
            return timedelta(self.toordinal() - other.toordinal())
        return NotImplemented

    def _key(self):
        return self._year, self._month, self._day

    def _comparable(self, other):
        return isinstance(other, date) and not isinstance(other, datetime)

    def __eq__(self, other):
        return self._key() == other._key() if self._comparable(other) else NotImplemented

    def __lt__(self, other):
        return self._key() < other._key() if self._comparable(other) else NotImplemented

    def __le__(self, other):
        return self._key() <= other._key() if self._comparable(other) else NotImplemented

    def __gt__(self, other):
        return self._key() > other._key() if self._comparable(other) else NotImplemented

    def __ge__(self, other):
        return self._key() >= other._key() if self._comparable(other) else NotImplemented

    def __hash__(self):
        return hash(self._key())


class IsoCalendarDate(tuple):
    year = property(lambda self: self[0])
    week = property(lambda self: self[1])
    weekday = property(lambda self: self[2])

    def __repr__(self):
        return f"datetime.IsoCalendarDate(year={self[0]}, week={self[1]}, weekday={self[2]})"


def _iso_week_one(year):
    """The ordinal of the Monday of week 1, which is the week with the year's first Thursday."""
    first = _to_ordinal(year, 1, 1)
    weekday = (first + 6) % 7
    return first - weekday + (7 if weekday > 3 else 0)


def _digits(text, count):
    return int(text) if len(text) == count and text.isdigit() and text.isascii() else None


def _iso_date(text):
    if len(text) == 10 and text[4] == "-" and text[7] == "-":
        parts = _digits(text[:4], 4), _digits(text[5:7], 2), _digits(text[8:], 2)
    elif len(text) == 8 and text.isdigit():
        parts = _digits(text[:4], 4), _digits(text[4:6], 2), _digits(text[6:], 2)
    elif text[4:5] == "W" or text[4:6] == "-W":
        return _iso_week_date(text)
    else:
        return None
    return None if None in parts else parts


def _iso_week_date(text):
    dashed = text[4] == "-"
    week, rest = (text[6:8], text[8:]) if dashed else (text[5:7], text[7:])
    day = "1"
    if rest:
        if dashed and not rest.startswith("-"):
            return None
        day = rest[1:] if dashed else rest
    parts = _digits(text[:4], 4), _digits(week, 2), _digits(day, 1)
    if None in parts:
        return None
    year, week, day = parts
    first = _iso_week_one(year)
    weeks = (_iso_week_one(year + 1) - first) // 7
    if not 1 <= week <= weeks or not 1 <= day <= 7:
        return None
    return _from_ordinal(first + (week - 1) * 7 + day - 1)


def _iso_time(text):
    """Hour, minute, second, microsecond and zone; None if the text is none."""
    zone = None
    for i, c in enumerate(text):
        if c in "+-Z":
            rest, text = text[i:], text[:i]
            if rest == "Z":
                zone = timezone.utc
            else:
                offset = _iso_time(rest[1:])
                if offset is None or offset[4] is not None:
                    return None
                span = timedelta(hours=offset[0], minutes=offset[1], seconds=offset[2], microseconds=offset[3])
                zone = timezone(-span if rest[0] == "-" else span) if span else timezone.utc
            break
    fraction = 0
    for point in ".,":
        if point in text:
            text, digits = text.split(point, 1)
            if not digits.isdigit():
                return None
            fraction = int((digits + "000000")[:6])
    if ":" in text:
        pieces = text.split(":")
    else:
        pieces = [text[i:i + 2] for i in range(0, len(text), 2)]
    if not 1 <= len(pieces) <= 3:
        return None
    values = [_digits(piece, 2) for piece in pieces]
    if None in values:
        return None
    values += [0] * (3 - len(values))
    return (*values, fraction, zone)


class time:
    __slots__ = ("_hour", "_minute", "_second", "_microsecond", "_tzinfo", "_fold")

    def __init__(self, hour=0, minute=0, second=0, microsecond=0, tzinfo=None, *, fold=0):
        numbers = [_check_int(number) for number in (hour, minute, second, microsecond, fold)]
        _check_time(*numbers)
        _check_zone(tzinfo)
        self._hour, self._minute, self._second, self._microsecond, self._fold = numbers
        self._tzinfo = tzinfo

    hour = property(lambda self: self._hour)
    minute = property(lambda self: self._minute)
    second = property(lambda self: self._second)
    microsecond = property(lambda self: self._microsecond)
    tzinfo = property(lambda self: self._tzinfo)
    fold = property(lambda self: self._fold)

    @classmethod
    def fromisoformat(cls, time_string):
        if not isinstance(time_string, str):
            raise TypeError("fromisoformat: argument must be str")
        fields = _iso_time(time_string.lstrip("T"))
        if fields is None:
            raise ValueError(f"Invalid isoformat string: {time_string!r}")
        return cls(*fields)

    def utcoffset(self):
        return None if self._tzinfo is None else self._tzinfo.utcoffset(None)

    def tzname(self):
        return None if self._tzinfo is None else self._tzinfo.tzname(None)

    def dst(self):
        return None if self._tzinfo is None else self._tzinfo.dst(None)

    def isoformat(self, timespec="auto"):
        if not isinstance(timespec, str):
            raise TypeError(f"isoformat() argument 1 must be str, not {_argument(timespec)}")
        text = _time_text(self._hour, self._minute, self._second, self._microsecond, timespec)
        offset = self.utcoffset()
        return text if offset is None else text + _offset_text(offset)

    def __str__(self):
        return self.isoformat()

    def __repr__(self):
        text = f"{_named(self)}({self._hour}, {self._minute}"
        if self._second or self._microsecond:
            text += f", {self._second}"
        if self._microsecond:
            text += f", {self._microsecond}"
        if self._fold:
            text += ", fold=1"
        if self._tzinfo is not None:
            text += f", tzinfo={self._tzinfo!r}"
        return text + ")"

    def strftime(self, format):
        fields = (1900, 1, 1, self._hour, self._minute, self._second, 0, 1, -1)
        return _strftime(self, format, fields, self._microsecond)

    def __format__(self, spec):
        return _formatted(self, spec)

    def replace(self, hour=_SAME, minute=_SAME, second=_SAME, microsecond=_SAME, tzinfo=True, *, fold=_SAME):
        return type(self)(self._hour if hour is _SAME else hour, self._minute if minute is _SAME else minute,
                          self._second if second is _SAME else second,
                          self._microsecond if microsecond is _SAME else microsecond,
                          self._tzinfo if tzinfo is True else tzinfo, fold=self._fold if fold is _SAME else fold)

    def _key(self):
        offset = self.utcoffset()
        total = ((self._hour * 60 + self._minute) * 60 + self._second) * 1000000 + self._microsecond
        return total if offset is None else total - offset._total()

    def _compare(self, other):
        if (self.utcoffset() is None) != (other.utcoffset() is None):
            raise TypeError("can't compare offset-naive and offset-aware times")
        return self._key() - other._key()

    def __eq__(self, other):
        if not isinstance(other, time):
            return NotImplemented
        return (self.utcoffset() is None) == (other.utcoffset() is None) and self._key() == other._key()

    def __lt__(self, other):
        return self._compare(other) < 0 if isinstance(other, time) else NotImplemented

    def __le__(self, other):
        return self._compare(other) <= 0 if isinstance(other, time) else NotImplemented

    def __gt__(self, other):
        return self._compare(other) > 0 if isinstance(other, time) else NotImplemented

    def __ge__(self, other):
        return self._compare(other) >= 0 if isinstance(other, time) else NotImplemented

    def __hash__(self):
        return hash(self._key())


def _time_text(hour, minute, second, microsecond, timespec):
    if timespec == "auto":
        timespec = "microseconds" if microsecond else "seconds"
    forms = {
        "hours": f"{hour:02}",
        "minutes": f"{hour:02}:{minute:02}",
        "seconds": f"{hour:02}:{minute:02}:{second:02}",
        "milliseconds": f"{hour:02}:{minute:02}:{second:02}.{microsecond // 1000:03}",
        "microseconds": f"{hour:02}:{minute:02}:{second:02}.{microsecond:06}",
    }
    if timespec not in forms:
        timespec.encode()  # no half letters
        if "\0" in timespec:
            raise ValueError("embedded null character")
        raise ValueError("Unknown timespec value")
    return forms[timespec]


_date, _time = date, time  # the names of parameters and methods below hide them


class datetime(date):
    __slots__ = ("_hour", "_minute", "_second", "_microsecond", "_tzinfo", "_fold")

    def __init__(self, year, month, day, hour=0, minute=0, second=0, microsecond=0, tzinfo=None, *, fold=0):
        # All of them are numbers before any is looked at further.
        numbers = [_check_int(number) for number in (year, month, day, hour, minute, second, microsecond, fold)]
        _check_date(*numbers[:3])
        _check_time(*numbers[3:])
        _check_zone(tzinfo)
        self._year, self._month, self._day = numbers[:3]
        self._hour, self._minute, self._second, self._microsecond, self._fold = numbers[3:]
        self._tzinfo = tzinfo

    hour = property(lambda self: self._hour)
    minute = property(lambda self: self._minute)
    second = property(lambda self: self._second)
    microsecond = property(lambda self: self._microsecond)
    tzinfo = property(lambda self: self._tzinfo)
    fold = property(lambda self: self._fold)

    @classmethod
    def now(cls, tz=None):
        return cls.fromtimestamp(_now(), tz)

    @classmethod
    def utcnow(cls):
        return cls.fromtimestamp(_now())

    @classmethod
    def today(cls):
        return cls.fromtimestamp(_now())

    @classmethod
    def fromtimestamp(cls, timestamp, tz=None):
        _check_zone(tz)
        timestamp = _seconds(timestamp)
        _days_of(timestamp)
        whole = _floor(timestamp)
        microsecond = round((timestamp - whole) * 1000000)
        made = cls(1970, 1, 1) + _span(whole * 1000000 + microsecond)
        if tz is None:
            return made
        return tz.fromutc(made.replace(tzinfo=tz))

    @classmethod
    def utcfromtimestamp(cls, t):
        return cls.fromtimestamp(t)

    @classmethod
    def combine(cls, date, time, tzinfo=True):
        for place, part, kind in ((1, date, _date), (2, time, _time)):
            if not isinstance(part, kind):
                raise TypeError(f"combine() argument {place} must be datetime.{kind.__name__}, not {_argument(part)}")
        return cls(date.year, date.month, date.day, time.hour, time.minute, time.second, time.microsecond,
                   time.tzinfo if tzinfo is True else tzinfo, fold=time.fold)

    @classmethod
    def fromisoformat(cls, date_string):
        if not isinstance(date_string, str):
            raise TypeError("fromisoformat: argument must be str")
        length = 10 if date_string[4:5] == "-" else 8
        fields = _iso_date(date_string[:length])
        clock = (0, 0, 0, 0, None)
        if fields is not None and len(date_string) > length:
            clock = _iso_time(date_string[length + 1:]) if len(date_string) > length + 1 else None
        if fields is None or clock is None:
            raise ValueError(f"Invalid isoformat string: {date_string!r}")
        return cls(*fields, *clock)

    @classmethod
    def strptime(cls, date_string, format):
        for place, text in ((1, date_string), (2, format)):
            if not isinstance(text, str):
                raise TypeError(f"strptime() argument {place} must be str, not {_argument(text)}")
        return _strptime(cls, date_string, format)

    def timestamp(self):
        offset = self.utcoffset()
        since = self._microseconds() - _EPOCH
        return (since if offset is None else since - offset._total()) / 10 ** 6

    def _microseconds(self):
        seconds = (self._hour * 60 + self._minute) * 60 + self._second
        return (self.toordinal() * 86400 + seconds) * 1000000 + self._microsecond

    def utcoffset(self):
        return None if self._tzinfo is None else self._tzinfo.utcoffset(self)

    def tzname(self):
        return None if self._tzinfo is None else self._tzinfo.tzname(self)

    def dst(self):
        return None if self._tzinfo is None else self._tzinfo.dst(self)

    def date(self):
        return date(self._year, self._month, self._day)

    def time(self):
        return time(self._hour, self._minute, self._second, self._microsecond, fold=self._fold)

    def timetz(self):
        return time(self._hour, self._minute, self._second, self._microsecond, self._tzinfo, fold=self._fold)

    def astimezone(self, tz=None):
        tz = timezone.utc if tz is None else tz
        if not isinstance(tz, tzinfo):
            raise TypeError(f"tzinfo argument must be None or of a tzinfo subclass, not type '{type(tz).__name__}'")
        offset = self.utcoffset() or timedelta(0)
        return tz.fromutc((self.replace(tzinfo=None) - offset).replace(tzinfo=tz))

    def replace(self, year=_SAME, month=_SAME, day=_SAME, hour=_SAME, minute=_SAME, second=_SAME, microsecond=_SAME,
                tzinfo=True, *, fold=_SAME):
        return type(self)(self._year if year is _SAME else year, self._month if month is _SAME else month,
                          self._day if day is _SAME else day, self._hour if hour is _SAME else hour,
                          self._minute if minute is _SAME else minute, self._second if second is _SAME else second,
                          self._microsecond if microsecond is _SAME else microsecond,
                          self._tzinfo if tzinfo is True else tzinfo, fold=self._fold if fold is _SAME else fold)

    def _fields(self):
        fields = date._fields(self)
        return fields[:3] + (self._hour, self._minute, self._second) + fields[6:]

    def utctimetuple(self):
        offset = self.utcoffset()
        return (self if offset is None else self - offset).timetuple()

    def ctime(self):
        return self.strftime("%a %b %e %H:%M:%S %Y")

    def isoformat(self, sep="T", timespec="auto"):
        if not isinstance(sep, str) or len(sep) != 1:
            raise TypeError(f"isoformat() argument 1 must be a unicode character, not {_argument(sep)}")
        if not isinstance(timespec, str):
            raise TypeError(f"isoformat() argument 2 must be str, not {_argument(timespec)}")
        text = _time_text(self._hour, self._minute, self._second, self._microsecond, timespec)
        offset = self.utcoffset()
        return date.isoformat(self) + sep + text + ("" if offset is None else _offset_text(offset))

    def __str__(self):
        return self.isoformat(" ")

    def __repr__(self):
        values = [self._year, self._month, self._day, self._hour, self._minute, self._second, self._microsecond]
        while len(values) > 5 and values[-1] == 0:
            values.pop()
        zone = ", fold=1" if self._fold else ""
        zone += "" if self._tzinfo is None else f", tzinfo={self._tzinfo!r}"
        return f"{_named(self)}({', '.join(map(str, values))}{zone})"

    def strftime(self, format):
        return _strftime(self, format, self._fields(), self._microsecond)

    def __add__(self, other):
        if not isinstance(other, timedelta):
            return NotImplemented
        days, rest = divmod(self._microseconds() + other._total(), 86400000000)
        if not 0 < days <= 3652059:
            raise OverflowError("date value out of range")
        seconds, microsecond = divmod(rest, 1000000)
        minutes, second = divmod(seconds, 60)
        hour, minute = divmod(minutes, 60)
        return type(self)(*_from_ordinal(days), hour, minute, second, microsecond, self._tzinfo)

    __radd__ = __add__

    def __sub__(self, other):
        if isinstance(other, timedelta):
            return self + -other
        if not isinstance(other, datetime):
            return NotImplemented
        mine, theirs = self.utcoffset(), other.utcoffset()
        difference = self._microseconds() - other._microseconds()
        if (mine is None) != (theirs is None):
            raise TypeError("can't subtract offset-naive and offset-aware datetimes")
        return _span(difference if mine is None else difference - mine._total() + theirs._total())

    def _key(self):
        offset = self.utcoffset()
        return self._microseconds() - (0 if offset is None else offset._total())

    def _comparable(self, other):
        if not isinstance(other, datetime):
            if isinstance(other, date):
                raise TypeError(f"can't compare {type(self).__module__}.{type(self).__name__} to "
                                f"{type(other).__module__}.{type(other).__name__}")
            return False
        if (self.utcoffset() is None) != (other.utcoffset() is None):
            raise TypeError("can't compare offset-naive and offset-aware datetimes")
        return True

    def __eq__(self, other):
        if not isinstance(other, datetime):
            return False if isinstance(other, date) else NotImplemented
        return (self.utcoffset() is None) == (other.utcoffset() is None) and self._key() == other._key()

    def __hash__(self):
        return hash(self._key())


date.min, date.max, date.resolution = date(1, 1, 1), date(9999, 12, 31), timedelta(days=1)
time.min, time.max, time.resolution = time(0, 0), time(23, 59, 59, 999999), timedelta.resolution
datetime.min = datetime(1, 1, 1)
datetime.max = datetime(9999, 12, 31, 23, 59, 59, 999999)
datetime.resolution = timedelta.resolution
_EPOCH = datetime(1970, 1, 1)._microseconds()

#: Numbers in texts: the least, the most, and how many digits they have, or fewer.
_RANGES = {"d": (1, 31, 2), "m": (1, 12, 2), "H": (0, 23, 2), "I": (1, 12, 2), "M": (0, 59, 2), "S": (0, 61, 2),
           "j": (1, 366, 3), "U": (0, 53, 2), "W": (0, 53, 2), "V": (1, 53, 2), "u": (1, 7, 1), "w": (0, 6, 1)}
_NAMES = {"b": _MONTHS, "B": _FULL_MONTHS, "a": _DAYS, "A": _FULL_DAYS, "p": ["AM", "PM"], "Z": ["UTC", "GMT"]}
_PATTERNS = {"f": "[0-9]{1,6}", "y": r"\d{2}", "Y": r"\d{4}", "G": r"\d{4}", "%": "%",
             "z": r"[+-]\d\d:?[0-5]\d(?::?[0-5]\d(?:\.\d{1,6})?)?|(?-i:Z)"}
_AS_PARTS = {"c": "%a %b %d %H:%M:%S %Y", "x": "%m/%d/%y", "X": "%H:%M:%S"}


def _pattern_of(code):
    """What a directive stands for in a text; None if it is none."""
    pattern = _PATTERNS.get(code)
    if pattern is None:
        if code in _NAMES:
            pattern = "|".join(sorted(_NAMES[code], reverse=True))
        elif code in _RANGES:
            least, most, digits = _RANGES[code]
            # Those with more digits first: of 45 the 4 is a day.
            pattern = "|".join(f"{number:0{width}}" for width in range(digits, 0, -1)
                               for number in range(0 if code == "V" and width == 1 else least, most + 1)
                               if number < 10 ** width)
            pattern += "| [1-9]" if code == "d" else ""
        else:
            return None
        _PATTERNS[code] = pattern
    return pattern


#: The patterns of the formats that were used last.
_FORMATS = {}


def _parts_of(text, format):
    """The texts of the directives of a format, by their letters and in their order."""
    pattern = _FORMATS.get(format)
    if pattern is None:
        pattern = _pattern_of_format(format)
        if len(_FORMATS) >= 16:
            _FORMATS.clear()
        _FORMATS[format] = pattern
    match = pattern.match(text)
    if match is None:
        raise ValueError(f"time data {text!r} does not match format {format!r}")
    if match.end() < len(text):
        raise ValueError(f"unconverted data remains: {text[match.end():]}")
    return match.groupdict()


def _pattern_of_format(format):
    import re
    pattern, at, whole = "", 0, format
    while at < len(format):
        c = format[at]
        at += 1
        if c.isspace():
            while format[at:at + 1].isspace():
                at += 1
            pattern += r"\s+"
        elif c != "%":
            pattern += re.escape(c)
        else:
            code = format[at:at + 1]
            at += 1
            if not code:
                raise ValueError(f"stray % in format '{whole}'")
            if code in _AS_PARTS:
                format = _AS_PARTS[code] + format[at:]
                at = 0
                continue
            directive = _pattern_of(code)
            if directive is None:
                raise ValueError(f"'{code}' is a bad directive in format '{whole}'")
            pattern += directive if code == "%" else f"(?P<{code}>{directive})"
    return re.compile(pattern, re.IGNORECASE)


def _zone_of(text):
    """An offset as `%z` reads it."""
    if text == "Z":
        return timedelta(0)
    digits = text[1:]
    if digits[2] == ":":
        digits = digits.replace(":", "", 1)
        if len(digits) > 5 and digits[4] != ":":
            raise ValueError(f"Inconsistent use of : in {text}")
        digits = digits.replace(":", "")
    whole, _, fraction = digits.partition(".")
    offset = timedelta(hours=int(whole[:2]), minutes=int(whole[2:4]), seconds=int(whole[4:6] or 0),
                       microseconds=int((fraction + "000000")[:6]))
    return -offset if text[0] == "-" else offset


_ISO_YEAR = "a weekday directive ('%A', '%a', '%w', or '%u')."


def _strptime(cls, text, format):
    parts = _parts_of(text, format)
    year = iso_year = weekday = None
    month = day = 1
    hour = 0
    for code, part in parts.items():
        if code == "y":
            year = int(part)
            year += 2000 if year <= 68 else 1900
        elif code == "Y":
            year = int(part)
        elif code == "G":
            iso_year = int(part)
        elif code in "bB":
            month = [name.lower() for name in _NAMES[code]].index(part.lower()) + 1
        elif code == "m":
            month = int(part)
        elif code == "d":
            day = int(part)
        elif code == "H":
            hour = int(part)
        elif code == "I":
            hour = int(part) % 12 + (12 if parts.get("p", "").lower() == "pm" else 0)
        elif code in "aA":
            weekday = [name.lower() for name in _NAMES[code]].index(part.lower())
        elif code in "wu":
            weekday = (int(part) - 1) % 7
    if iso_year is not None:
        if "j" in parts:
            raise ValueError("Day of the year directive '%j' is not compatible with ISO year directive '%G'. "
                             "Use '%Y' instead.")
        if "V" not in parts or weekday is None:
            raise ValueError("ISO year directive '%G' must be used with the ISO week directive '%V' and " + _ISO_YEAR)
    elif "V" in parts:
        if year is None or weekday is None:
            raise ValueError("ISO week directive '%V' must be used with the ISO year directive '%G' and " + _ISO_YEAR)
        raise ValueError("ISO week directive '%V' is incompatible with the year directive '%Y'. "
                         "Use the ISO year '%G' instead.")
    year = 1900 if year is None else year
    ordinal = None
    if "j" in parts:
        ordinal = _to_ordinal(year, 1, 1) + int(parts["j"]) - 1
    elif iso_year is not None:
        ordinal = _iso_week_one(iso_year) + (int(parts["V"]) - 1) * 7 + weekday
    elif weekday is not None and ("U" in parts or "W" in parts):
        # The weeks begin on Sunday or Monday; days before the first such day are in week 0.
        code = [code for code in parts if code in "UW"][-1]
        after = 1 if code == "U" else 0
        new_year = _to_ordinal(year, 1, 1)
        begins, number = ((new_year + 6) % 7 + after) % 7, int(parts[code])
        # Where the year begins with such a day, its first week is week 0 as well.
        weeks = number - 1 if number and begins else max(number - 1, 0)
        ordinal = new_year + (7 - begins if number and begins else -begins) + weeks * 7 + (weekday + after) % 7
    if ordinal is not None:
        year, month, day = _from_ordinal(ordinal)
    zone = None
    if "z" in parts:
        zone = timezone(_zone_of(parts["z"]), *([parts["Z"]] if "Z" in parts else []))
    microsecond = int((parts.get("f", "") + "000000")[:6])
    return cls(year, month, day, hour, int(parts.get("M", 0)), int(parts.get("S", 0)), microsecond, zone)
