"""Signals that a program sends to itself: alarms, and what `raise_signal` and `os.kill` of its own process say.

They never leave the task: a handler of the program runs on its main thread, the default of a signal that would end the
controller is refused. Signals that others send to the controller do not reach programs. Needs the permission `process`,
but for the numbers."""
import _process
import _system

_NAMES = {1: "SIGHUP", 2: "SIGINT", 3: "SIGQUIT", 4: "SIGILL", 5: "SIGTRAP", 6: "SIGABRT", 7: "SIGBUS", 8: "SIGFPE",
          9: "SIGKILL", 10: "SIGUSR1", 11: "SIGSEGV", 12: "SIGUSR2", 13: "SIGPIPE", 14: "SIGALRM", 15: "SIGTERM",
          16: "SIGSTKFLT", 17: "SIGCHLD", 18: "SIGCONT", 19: "SIGSTOP", 20: "SIGTSTP", 21: "SIGTTIN", 22: "SIGTTOU",
          23: "SIGURG", 24: "SIGXCPU", 25: "SIGXFSZ", 26: "SIGVTALRM", 27: "SIGPROF", 28: "SIGWINCH", 29: "SIGIO",
          30: "SIGPWR", 31: "SIGSYS", 34: "SIGRTMIN", 64: "SIGRTMAX"}
_TEXTS = {1: "Hangup", 2: "Interrupt", 3: "Quit", 4: "Illegal instruction", 5: "Trace/breakpoint trap", 6: "Aborted",
          7: "Bus error", 8: "Floating point exception", 9: "Killed", 10: "User defined signal 1",
          11: "Segmentation fault", 12: "User defined signal 2", 13: "Broken pipe", 14: "Alarm clock",
          15: "Terminated", 17: "Child exited", 18: "Continued", 19: "Stopped (signal)", 20: "Stopped"}


class _Number(int):
    """A number with a name."""
    _names = {}

    def __new__(cls, value, /):
        value = int(value)
        if value not in cls._names:
            raise ValueError(f"{value} is not a valid {cls.__name__}")
        made = int.__new__(cls, value)
        made.name = cls._names[value]
        made.value = value
        return made

    def __repr__(self):
        return f"<{type(self).__name__}.{self.name}: {self.value}>"

    def __str__(self):
        return str(self.value)


class Signals(_Number):
    _names = _NAMES


class Handlers(_Number):
    _names = {0: "SIG_DFL", 1: "SIG_IGN"}



for _name, _value in [(name, value) for value, name in _NAMES.items()]:
    setattr(Signals, _name, Signals(_value))

SIGHUP, SIGINT, SIGQUIT, SIGILL = Signals(1), Signals(2), Signals(3), Signals(4)
SIGTRAP, SIGABRT, SIGBUS, SIGFPE = Signals(5), Signals(6), Signals(7), Signals(8)
SIGKILL, SIGUSR1, SIGSEGV, SIGUSR2 = Signals(9), Signals(10), Signals(11), Signals(12)
SIGPIPE, SIGALRM, SIGTERM, SIGCHLD = Signals(13), Signals(14), Signals(15), Signals(17)
SIGCONT, SIGSTOP, SIGTSTP, SIGTTIN = Signals(18), Signals(19), Signals(20), Signals(21)
SIGTTOU, SIGURG, SIGXCPU, SIGXFSZ = Signals(22), Signals(23), Signals(24), Signals(25)
SIGVTALRM, SIGPROF, SIGWINCH, SIGIO = Signals(26), Signals(27), Signals(28), Signals(29)
SIGPWR, SIGSYS, SIGRTMIN, SIGRTMAX = Signals(30), Signals(31), Signals(34), Signals(64)
SIGPOLL, SIGCLD = SIGIO, SIGCHLD
SIG_DFL, SIG_IGN = Handlers(0), Handlers(1)
NSIG = 65
ITIMER_REAL, ITIMER_VIRTUAL, ITIMER_PROF = 0, 1, 2


class ItimerError(OSError):
    pass


def default_int_handler(signalnum, frame, /):
    raise KeyboardInterrupt


_handlers = {SIGINT: default_int_handler}
_IGNORED = (SIGCHLD, SIGCONT, SIGURG, SIGWINCH)


def _checked(signalnum):
    number = int(signalnum)
    if not 1 <= number < NSIG:
        raise ValueError("signal number out of range")
    return number


def signal(signalnum, handler, /):
    _system.require("process", "signal.signal")
    number = _checked(signalnum)
    if not _process.is_main():
        raise ValueError("signal only works in main thread of the main interpreter")
    if not callable(handler) and handler not in (SIG_DFL, SIG_IGN):
        raise TypeError("signal handler must be signal.SIG_IGN, signal.SIG_DFL, or a callable object")
    if number in (SIGKILL, SIGSTOP):
        raise OSError(22, "Invalid argument")
    before = getsignal(number)
    _handlers[number] = handler
    return before


def getsignal(signalnum, /):
    return _handlers.get(_checked(signalnum), SIG_DFL)


def strsignal(signalnum, /):
    number = _checked(signalnum)
    return _TEXTS.get(number)


def valid_signals():
    return {Signals(number) if number in _NAMES else number for number in range(1, NSIG) if number not in (32, 33)}


def raise_signal(signalnum, /):
    _system.require("process", "signal.raise_signal")
    number = _checked(signalnum)
    handler = _handlers.get(number, SIG_DFL)
    if not callable(handler) or isinstance(handler, int):
        if handler == SIG_IGN or number in _IGNORED:
            return
        shown = _NAMES.get(number, number)
        raise PermissionError(1, f"the default of {shown} would end the controller; set a handler first")
    if _process.is_main():
        handler(number, None)
    else:
        _process.interrupt(handler, (number, None))


def pthread_kill(thread_id, signalnum, /):
    raise_signal(signalnum)


def pause():
    _process.pause()


# The clock that rings: when it is due next, how often after that, and which setting of it is valid.
_due = 0.0
_interval = 0.0
_setting = 0


def _ring(setting, seconds):
    global _due
    from time import monotonic, sleep
    while setting == _setting:
        sleep(seconds)
        if setting != _setting:
            return
        _due = monotonic() + _interval if _interval else 0.0
        raise_signal(SIGALRM)
        if not _interval:
            return
        seconds = _interval


def setitimer(which, seconds, interval=0.0, /):
    _system.require("process", "signal.setitimer")
    global _due, _interval, _setting
    if which != ITIMER_REAL:
        raise ItimerError(22, "only ITIMER_REAL is supported on the controller")
    if seconds < 0 or interval < 0:
        raise ItimerError(22, "Invalid argument")
    before = getitimer(which)
    _setting += 1
    _due = _interval = 0.0
    if seconds:
        if getsignal(SIGALRM) == SIG_DFL:
            raise PermissionError(1, "the default of SIGALRM would end the controller; set a handler first")
        from threading import Thread
        from time import monotonic
        _due, _interval = monotonic() + seconds, interval
        Thread(target=_ring, args=(_setting, seconds), daemon=True).start()
    return before


def getitimer(which, /):
    from time import monotonic
    return (max(_due - monotonic(), 0.0) if _due else 0.0, _interval)


def alarm(seconds, /):
    left, _ = setitimer(ITIMER_REAL, int(seconds))
    return int(left + 0.999)
