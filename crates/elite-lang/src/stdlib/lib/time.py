"""Clocks, sleeping and calendar dates. The controller has no time zone: local time is UTC."""
from _time import time, time_ns, monotonic, monotonic_ns, perf_counter, perf_counter_ns
from _time import process_time, thread_time, sleep, timezone, altzone, daylight, tzname
from _time import _fields, _format, _unix


class struct_time(tuple):
    n_fields = 11
    n_sequence_fields = 9

    def __new__(cls, sequence):
        sequence = tuple(sequence)
        if len(sequence) < 9:
            raise TypeError("time.struct_time() takes an at least 9-sequence (" + str(len(sequence)) + "-sequence given)")
        return tuple.__new__(cls, sequence[:9])

    tm_year = property(lambda self: self[0])
    tm_mon = property(lambda self: self[1])
    tm_mday = property(lambda self: self[2])
    tm_hour = property(lambda self: self[3])
    tm_min = property(lambda self: self[4])
    tm_sec = property(lambda self: self[5])
    tm_wday = property(lambda self: self[6])
    tm_yday = property(lambda self: self[7])
    tm_isdst = property(lambda self: self[8])
    tm_zone = property(lambda self: "UTC")
    tm_gmtoff = property(lambda self: 0)

    def __repr__(self):
        names = ("tm_year", "tm_mon", "tm_mday", "tm_hour", "tm_min", "tm_sec", "tm_wday", "tm_yday", "tm_isdst")
        return "time.struct_time(" + ", ".join(f"{name}={value}" for name, value in zip(names, self)) + ")"


def gmtime(secs=None):
    return struct_time(_fields(time() if secs is None else secs))


localtime = gmtime


def mktime(t):
    return float(_unix(tuple(t)))


def strftime(format, t=None):
    return _format(format, tuple(gmtime() if t is None else t))


def asctime(t=None):
    return _format("%a %b %e %H:%M:%S %Y", tuple(gmtime() if t is None else t))


def ctime(secs=None):
    return asctime(gmtime(secs))


def strptime(string, format="%a %b %d %H:%M:%S %Y"):
    import datetime
    return datetime.datetime.strptime(string, format).timetuple()
