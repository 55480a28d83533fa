"""Helpers for `with`."""
from abc import ABC as _ABC, abstractmethod as _abstractmethod
from functools import wraps as _wraps
import sys as _sys


class AbstractContextManager(_ABC):
    """What has `__enter__` and `__exit__`."""

    def __enter__(self):
        return self

    @_abstractmethod
    def __exit__(self, exc_type, exc_value, traceback):
        return None


class ContextDecorator:
    """Lets a context manager decorate functions."""

    def _recreate_cm(self):
        return self

    def __call__(self, func):
        @_wraps(func)
        def inner(*args, **kwds):
            with self._recreate_cm():
                return func(*args, **kwds)
        return inner


class _Generated(ContextDecorator):
    def __init__(self, function, args, kwds):
        self._made = function, args, kwds
        self._generator = function(*args, **kwds)

    def _recreate_cm(self):
        return type(self)(*self._made)

    def __enter__(self):
        for value in self._generator:
            return value
        raise RuntimeError("generator didn't yield")

    def __exit__(self, type, value, traceback):
        if type is None:
            for _ in self._generator:
                raise RuntimeError("generator didn't stop")
            return False
        if value is None:
            value = type()
        try:
            self._generator.throw(value)
        except StopIteration as stop:
            return stop is not value
        except BaseException as raised:
            if raised is value:
                return False
            raise
        raise RuntimeError("generator didn't stop after throw()")


def contextmanager(func):
    @_wraps(func)
    def helper(*args, **kwds):
        return _Generated(func, args, kwds)
    return helper


class closing:
    def __init__(self, thing):
        self.thing = thing

    def __enter__(self):
        return self.thing

    def __exit__(self, *exc_info):
        self.thing.close()


class suppress:
    def __init__(self, *exceptions):
        self._kinds = exceptions

    def __enter__(self):
        return None

    def __exit__(self, kind, *details):
        return kind is not None and issubclass(kind, self._kinds)


class nullcontext:
    def __init__(self, enter_result=None):
        self.enter_result = enter_result

    def __enter__(self):
        return self.enter_result

    def __exit__(self, *excinfo):
        pass


class ExitStack:
    """Leaves any number of contexts, the last one first."""

    def __init__(self):
        self._exits = []

    def enter_context(self, cm):
        result = type(cm).__enter__(cm)
        self._exits.append(lambda *details: type(cm).__exit__(cm, *details))
        return result

    def push(self, exit):
        if hasattr(type(exit), "__exit__"):
            self._exits.append(lambda *details: type(exit).__exit__(exit, *details))
        else:
            self._exits.append(exit)
        return exit

    def callback(self, callback, /, *args, **kwds):
        def leave(type, value, traceback):
            callback(*args, **kwds)
        self._exits.append(leave)
        return callback

    def pop_all(self):
        other = type(self)()
        other._exits, self._exits = self._exits, []
        return other

    def close(self):
        self.__exit__(None, None, None)

    def __enter__(self):
        return self

    def __exit__(self, type_, value, traceback):
        pending = value
        while self._exits:
            leave = self._exits.pop()
            try:
                if leave(None if pending is None else type(pending), pending, None):
                    pending = None
            except BaseException as raised:
                pending = raised
        if pending is not None and pending is not value:
            raise pending
        return value is not None and pending is None


class _Meanwhile:
    """Something is another one for a while; the same context may be entered again within itself."""

    def __init__(self, other):
        self._other, self._before = other, []

    def __enter__(self):
        self._before.append(self._exchange(self._other))
        return self._other

    def __exit__(self, *details):
        self._exchange(self._before.pop())


def _exchange_stream(name, stream):
    before = getattr(_sys, name)
    setattr(_sys, name, stream)
    return before


class redirect_stdout(_Meanwhile):
    """`print` writes elsewhere."""

    def __init__(self, new_target):
        super().__init__(new_target)

    def _exchange(self, stream):
        return _exchange_stream("stdout", stream)


class redirect_stderr(_Meanwhile):
    """What goes to `sys.stderr` goes elsewhere."""

    def __init__(self, new_target):
        super().__init__(new_target)

    def _exchange(self, stream):
        return _exchange_stream("stderr", stream)


class chdir(_Meanwhile):
    """Another folder for a while."""

    def __init__(self, path):
        super().__init__(path)
        self.path = path

    def __enter__(self):
        super().__enter__()

    def _exchange(self, folder):
        import os
        before = os.getcwd()
        os.chdir(folder)
        return before
