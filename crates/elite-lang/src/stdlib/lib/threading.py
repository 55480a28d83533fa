"""Threads of a task, and what they wait for each other with. Locks are native; the rest is built from them."""
import _thread
from _time import monotonic as _now
from _thread import lock as Lock, get_ident

TIMEOUT_MAX = 9223372036.0
_RLock = _thread.RLock


def RLock():
    return _RLock()


class Condition:
    """A lock, and threads that wait for word about what it guards."""

    def __init__(self, lock=None):
        if lock is None:
            lock = RLock()
        self._lock = lock
        self.acquire = lock.acquire
        self.release = lock.release
        self._waiters = []

    def __enter__(self):
        return self._lock.__enter__()

    def __exit__(self, *args):
        return self._lock.__exit__(*args)

    def __repr__(self):
        return f"<Condition({self._lock}, {len(self._waiters)})>"

    def _is_owned(self):
        if hasattr(self._lock, "_is_owned"):
            return self._lock._is_owned()
        if self._lock.acquire(False):
            self._lock.release()
            return False
        return True

    def _release_save(self):
        if hasattr(self._lock, "_release_save"):
            return self._lock._release_save()
        self._lock.release()

    def _acquire_restore(self, saved):
        if hasattr(self._lock, "_acquire_restore"):
            self._lock._acquire_restore(saved)
        else:
            self._lock.acquire()

    def wait(self, timeout=None):
        if not self._is_owned():
            raise RuntimeError("cannot wait on un-acquired lock")
        waiter = Lock()
        waiter.acquire()
        self._waiters.append(waiter)
        saved = self._release_save()
        told = False
        try:
            if timeout is None:
                waiter.acquire()
                told = True
            elif timeout > 0:
                told = waiter.acquire(True, timeout)
            else:
                told = waiter.acquire(False)
            return told
        finally:
            if not told and waiter in self._waiters:
                self._waiters.remove(waiter)
            self._acquire_restore(saved)

    def wait_for(self, predicate, timeout=None):
        end = None if timeout is None else _now() + timeout
        result = predicate()
        while not result:
            left = None if end is None else end - _now()
            if left is not None and left <= 0:
                break
            self.wait(left)
            result = predicate()
        return result

    def notify(self, n=1):
        if not self._is_owned():
            raise RuntimeError("cannot notify on un-acquired lock")
        while n > 0 and self._waiters:
            self._waiters.pop(0).release()
            n -= 1

    def notify_all(self):
        self.notify(len(self._waiters))

    notifyAll = notify_all


class Semaphore:
    def __init__(self, value=1):
        if value < 0:
            raise ValueError("semaphore initial value must be >= 0")
        self._cond = Condition(Lock())
        self._value = value

    def acquire(self, blocking=True, timeout=None):
        if not blocking and timeout is not None:
            raise ValueError("can't specify timeout for non-blocking acquire")
        with self._cond:
            end = None if timeout is None else _now() + timeout
            while self._value == 0:
                if not blocking:
                    return False
                left = None if end is None else end - _now()
                if left is not None and left <= 0:
                    return False
                self._cond.wait(left)
            self._value -= 1
            return True

    __enter__ = acquire

    def release(self, n=1):
        if n < 1:
            raise ValueError("n must be one or more")
        with self._cond:
            self._value += n
            self._cond.notify(n)

    def __exit__(self, type, value, traceback):
        self.release()


class BoundedSemaphore(Semaphore):
    def __init__(self, value=1):
        super().__init__(value)
        self._initial_value = value

    def release(self, n=1):
        if n < 1:
            raise ValueError("n must be one or more")
        with self._cond:
            if self._value + n > self._initial_value:
                raise ValueError("Semaphore released too many times")
            self._value += n
            self._cond.notify(n)


class Event:
    def __init__(self):
        self._cond = Condition(Lock())
        self._flag = False

    def is_set(self):
        return self._flag

    isSet = is_set

    def set(self):
        with self._cond:
            self._flag = True
            self._cond.notify_all()

    def clear(self):
        with self._cond:
            self._flag = False

    def wait(self, timeout=None):
        with self._cond:
            if not self._flag:
                self._cond.wait_for(self.is_set, timeout)
            return self._flag


class BrokenBarrierError(RuntimeError):
    pass


class Barrier:
    """Lets threads go on together, always `parties` at once."""

    def __init__(self, parties, action=None, timeout=None):
        self._cond = Condition(Lock())
        self._action = action
        self._timeout = timeout
        self._parties = parties
        self._count = 0
        self._round = 0
        self._broken = False

    parties = property(lambda self: self._parties)
    n_waiting = property(lambda self: self._count)
    broken = property(lambda self: self._broken)

    def wait(self, timeout=None):
        if timeout is None:
            timeout = self._timeout
        with self._cond:
            if self._broken:
                raise BrokenBarrierError
            index, current = self._count, self._round
            self._count += 1
            if self._count == self._parties:
                if self._action is not None:
                    try:
                        self._action()
                    except:
                        self._break()
                        raise
                self._next()
            else:
                done = self._cond.wait_for(lambda: self._round != current or self._broken, timeout)
                if not done or self._broken:
                    self._break()
                    raise BrokenBarrierError
            return index

    def _next(self):
        self._count = 0
        self._round += 1
        self._cond.notify_all()

    def _break(self):
        self._broken = True
        self._cond.notify_all()

    def reset(self):
        with self._cond:
            if self._count > 0:
                self._broken = True
                self._cond.notify_all()
                self._broken = False
            self._next()

    def abort(self):
        with self._cond:
            self._break()


_active = {}
# Started, but not yet running.
_limbo = []
_counter = 0


def _new_name(template="Thread-{}"):
    global _counter
    _counter += 1
    return template.format(_counter)


class Thread:
    def __init__(self, group=None, target=None, name=None, args=(), kwargs=None, *, daemon=None):
        if group is not None:
            raise AssertionError("group argument must be None for now")
        self._target = target
        self._args = args
        self._kwargs = {} if kwargs is None else kwargs
        if name is None:
            name = _new_name()
            if target is not None and hasattr(target, "__name__"):
                name += f" ({target.__name__})"
        self._name = str(name)
        self._daemonic = current_thread().daemon if daemon is None else bool(daemon)
        self._ident = None
        self._done = Event()
        self._started = False
        self._stopped = False

    def __repr__(self):
        status = "initial"
        if self._started:
            status = "stopped" if self._stopped else "started"
        if self._daemonic:
            status += " daemon"
        if self._ident is not None:
            status += f" {self._ident}"
        return f"<{type(self).__name__}({self._name}, {status})>"

    def start(self):
        if not hasattr(self, "_started"):
            raise RuntimeError("thread.__init__() not called")
        if self._started:
            raise RuntimeError("threads can only be started once")
        self._started = True
        _limbo.append(self)
        try:
            self._ident = _thread.start_new_thread(self._bootstrap, ())
        except Exception:
            self._started = False
            _limbo.remove(self)
            raise

    def _bootstrap(self):
        self._ident = get_ident()
        _active[self._ident] = self
        _limbo.remove(self)
        try:
            self.run()
        except SystemExit:
            pass
        finally:
            self._stopped = True
            _active.pop(self._ident, None)
            self._done.set()

    def run(self):
        if self._target is not None:
            self._target(*self._args, **self._kwargs)

    def join(self, timeout=None):
        if not self._started:
            raise RuntimeError("cannot join thread before it is started")
        if self is current_thread():
            raise RuntimeError("cannot join current thread")
        self._done.wait(None if timeout is None else max(timeout, 0))

    def is_alive(self):
        return self._started and not self._stopped

    @property
    def name(self):
        return self._name

    @name.setter
    def name(self, name):
        self._name = str(name)

    @property
    def ident(self):
        return self._ident

    native_id = ident

    @property
    def daemon(self):
        return self._daemonic

    @daemon.setter
    def daemon(self, daemonic):
        if self._started:
            raise RuntimeError("cannot set daemon status of active thread")
        self._daemonic = bool(daemonic)

    def isDaemon(self):
        return self._daemonic

    def setDaemon(self, daemonic):
        self.daemon = daemonic

    def getName(self):
        return self.name

    def setName(self, name):
        self.name = name


class Timer(Thread):
    """Calls a function once some seconds have passed, unless it is cancelled before."""

    def __init__(self, interval, function, args=None, kwargs=None):
        super().__init__()
        self.interval = interval
        self.function = function
        self.args = [] if args is None else args
        self.kwargs = {} if kwargs is None else kwargs
        self.finished = Event()

    def cancel(self):
        self.finished.set()

    def run(self):
        self.finished.wait(self.interval)
        if not self.finished.is_set():
            self.function(*self.args, **self.kwargs)
        self.finished.set()


class _OtherThread(Thread):
    """The main program, or a thread that was started in another way."""

    def __init__(self, name, ident):
        self._name = name
        self._daemonic = False
        self._ident = ident
        self._started = True
        self._stopped = False
        self._done = Event()


_main = _OtherThread("MainThread", 1)
_active[1] = _main


def current_thread():
    ident = get_ident()
    thread = _active.get(ident)
    if thread is None:
        thread = _active[ident] = _OtherThread(_new_name("Dummy-{}"), ident)
        thread._daemonic = True
    return thread


currentThread = current_thread
get_native_id = get_ident


def main_thread():
    return _main


def enumerate():
    return list(_active.values()) + _limbo


def active_count():
    return len(_active) + len(_limbo)


activeCount = active_count


def _shutdown():
    while True:
        waiting = [thread for thread in enumerate() if not isinstance(thread, _OtherThread) and not thread._daemonic]
        if not waiting:
            return
        waiting[0].join()


class local:
    """Attributes that every thread has for itself."""

    def __init__(self):
        object.__setattr__(self, "_values", {})

    def _own(self):
        values = object.__getattribute__(self, "_values")
        ident = get_ident()
        if ident not in values:
            values[ident] = {}
        return values[ident]

    def __getattr__(self, name):
        own = self._own()
        if name in own:
            return own[name]
        raise AttributeError(f"'_thread._local' object has no attribute '{name}'")

    def __setattr__(self, name, value):
        self._own()[name] = value

    def __delattr__(self, name):
        own = self._own()
        if name not in own:
            raise AttributeError(f"'_thread._local' object has no attribute '{name}'")
        del own[name]


ThreadError = RuntimeError
_trace = _profile = None


def settrace(func):
    """Kept, never called: programs are not traced."""
    global _trace
    _trace = func


def gettrace():
    return _trace


def setprofile(func):
    """Kept, never called: programs are not profiled."""
    global _profile
    _profile = func


def getprofile():
    return _profile


def stack_size(size=0, /):
    if size and size < 32768:
        raise ValueError(f"size not valid: {size} bytes")
    return 0


local.__name__ = local.__qualname__ = "_local"
