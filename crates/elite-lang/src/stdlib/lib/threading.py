"""Threads of a task. What they wait for each other with is native (`_thread`); here it is opened for attributes, and
here is the list of the threads."""
import _thread
from _thread import get_ident, lock as Lock
from itertools import count as _count

TIMEOUT_MAX = 9223372036.0
ThreadError = RuntimeError
get_native_id = get_ident


def RLock():
    return _thread.RLock()


class BrokenBarrierError(RuntimeError):
    """A barrier was given up before all had come."""


class Condition(_thread.Condition):
    """A lock, and threads that wait for word about what it guards."""


class Event(_thread.Event):
    """A flag that threads wait for."""

    isSet = _thread.Event.is_set


class Semaphore(_thread.Semaphore):
    """So many may go on at once."""


class BoundedSemaphore(_thread.BoundedSemaphore, Semaphore):
    """The same, released no more often than acquired."""


class Barrier(_thread.Barrier):
    """Lets threads go on together, always `parties` at once."""


# Who there is: threads that run, by number, and behind them those that are started but have not run yet.
_running = {}
_starting = []


def _kept(name, doc, check=None):
    """An attribute of a thread under its public name, which is kept under `_name`."""
    place = "_" + name

    def put(self, value):
        setattr(self, place, check(self, value))

    return property(lambda self: getattr(self, place), check and put, None, doc)


def _daemon_before_start(self, flag):
    if self._life != "initial":
        raise RuntimeError("cannot set daemon status of active thread")
    return bool(flag)


class Thread:
    """A function that runs beside the others: `initial` until it is started, `stopped` when it has returned."""

    _numbers = _count(1)

    def __init__(self, group=None, target=None, name=None, args=(), kwargs=None, *, daemon=None):
        if group is not None:
            raise AssertionError("group argument must be None for now")
        self._life, self._ident, self._over = "initial", None, Event()
        self._target, self._args, self._kwargs = target, args, kwargs or {}
        called = f" ({target.__name__})" if hasattr(target, "__name__") else ""
        self._name = str(name) if name is not None else f"Thread-{next(Thread._numbers)}{called}"
        self._daemon = bool(current_thread()._daemon if daemon is None else daemon)

    name = _kept("name", "What people call it.", lambda self, name: str(name))
    daemon = _kept("daemon", "Whether the program ends without it.", _daemon_before_start)
    ident = _kept("ident", "Its number, once it has run.")
    native_id = ident

    def getName(self):
        return self.name

    def setName(self, name):
        self.name = name

    def isDaemon(self):
        return self.daemon

    def setDaemon(self, daemonic):
        self.daemon = daemonic

    def __repr__(self):
        words = [self._life, *["daemon"] * self._daemon, *([] if self._ident is None else [str(self._ident)])]
        return f"<{type(self).__name__}({self._name}, {' '.join(words)})>"

    def start(self):
        life = getattr(self, "_life", None)
        if life != "initial":
            raise RuntimeError("thread.__init__() not called" if life is None else "threads can only be started once")
        self._life = "started"
        _starting.append(self)
        try:
            self._ident = _thread.start_new_thread(self._live, ())
        except Exception:
            self._life = "initial"
            _starting.remove(self)
            raise

    def _live(self):
        self._ident = get_ident()
        _running[self._ident] = self
        _starting.remove(self)
        try:
            self.run()
        except SystemExit:
            pass
        finally:
            self._life = "stopped"
            _running.pop(self._ident, None)
            self._over.set()

    def run(self):
        if self._target is not None:
            self._target(*self._args, **self._kwargs)

    def is_alive(self):
        return self._life == "started"

    def join(self, timeout=None):
        problem = ("cannot join thread before it is started" if self._life == "initial" else
                   "cannot join current thread" if self._ident == get_ident() else None)
        if problem:
            raise RuntimeError(problem)
        self._over.wait(timeout)


class Timer(Thread):
    """Calls a function once some seconds have passed, unless it is cancelled before."""

    def __init__(self, interval, function, args=None, kwargs=None):
        Thread.__init__(self)
        self.interval, self.function, self.finished = interval, function, Event()
        self.args, self.kwargs = args or [], kwargs or {}

    def cancel(self):
        self.finished.set()

    def run(self):
        cancelled = self.finished.wait(self.interval)
        if not cancelled:
            self.function(*self.args, **self.kwargs)
        self.cancel()


class _Found(Thread):
    """A thread that was not started from here: the main program, or one of the controller."""

    def __init__(self, name, ident, daemon):
        self._life, self._ident, self._over = "started", ident, Event()
        self._name, self._daemon = name, daemon
        _running[ident] = self


_main = _Found("MainThread", 1, False)
_found_numbers = _count(1)


def main_thread():
    return _main


def current_thread():
    ident = get_ident()
    return _running.get(ident) or _Found(f"Dummy-{next(_found_numbers)}", ident, True)


def enumerate():
    return [*_running.values(), *_starting]


def active_count():
    return len(enumerate())


currentThread, activeCount = current_thread, active_count


def _shutdown():
    """What the end of the main program waits for."""
    while waited_for := [thread for thread in enumerate() if not (thread._daemon or isinstance(thread, _Found))]:
        waited_for[0].join()


class local:
    """Attributes that every thread has for itself."""

    def __init__(self):
        object.__setattr__(self, "_by_thread", {})

    def _mine(self):
        return object.__getattribute__(self, "_by_thread").setdefault(get_ident(), {})

    def __getattr__(self, name):
        try:
            return self._mine()[name]
        except KeyError:
            raise AttributeError(f"'_thread._local' object has no attribute '{name}'") from None

    def __setattr__(self, name, value):
        self._mine()[name] = value

    def __delattr__(self, name):
        if self._mine().pop(name, _nothing) is _nothing:
            raise AttributeError(f"'_thread._local' object has no attribute '{name}'")


_nothing = object()
local.__name__ = local.__qualname__ = "_local"

# Programs are not traced: what should be called is kept, and never called.
_observers = {"trace": None, "profile": None}


def settrace(func):
    _observers["trace"] = func


def setprofile(func):
    _observers["profile"] = func


def gettrace():
    return _observers["trace"]


def getprofile():
    return _observers["profile"]


def stack_size(size=0, /):
    if 0 < size < 32768 or size < 0:
        raise ValueError(f"size not valid: {size} bytes")
    return 0
