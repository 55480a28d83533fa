"""Queues between threads. `Queue` can be subclassed in Python's way: `_init`, `_qsize`, `_put`, `_get`, `mutex`,
`queue`."""
from collections import deque
from heapq import heappush as _push, heappop as _pop
from threading import Condition as _Condition, Lock as _Lock


class Empty(Exception):
    """Nothing is in the queue."""
    __module__ = "_queue"


class Full(Exception):
    """No more fits into the queue."""


class Queue:
    """One lock guards the items; three conditions on it say what threads may be waiting for."""

    def __init__(self, maxsize=0):
        self.maxsize, self.unfinished_tasks = maxsize, 0
        self.mutex = guard = _Lock()
        self.not_empty, self.not_full, self.all_tasks_done = _Condition(guard), _Condition(guard), _Condition(guard)
        self._init(maxsize)

    # How items are kept: what they are kept in, how one goes in and how one comes out.
    _keeping = deque, deque.append, deque.popleft

    # What a subclass may do in another way.

    def _init(self, maxsize):
        self.queue = self._keeping[0]()

    def _qsize(self):
        return self.queue.__len__()

    def _put(self, item):
        self._keeping[1](self.queue, item)

    def _get(self):
        return self._keeping[2](self.queue)

    # The ends of the queue. Everything is done holding the lock, as soon as the state that it needs is reached.

    def put(self, item, block=True, timeout=None):
        wait = timeout if block and self.maxsize > 0 else None
        self._done_when(self._has_room, self.not_full, Full, block, wait, self._take_in, item)

    def get(self, block=True, timeout=None):
        return self._done_when(self._qsize, self.not_empty, Empty, block, timeout if block else None, self._give_out)

    def put_nowait(self, item):
        self.put(item, False)

    def get_nowait(self):
        return self.get(False)

    def _done_when(self, reached, word, refusal, may_wait, timeout, act, *args):
        if timeout is not None and timeout < 0:
            raise ValueError("'timeout' must be a non-negative number")
        with self.mutex:
            if not reached() and not (may_wait and word.wait_for(reached, timeout)):
                raise refusal
            return act(*args)

    def _has_room(self):
        return not 0 < self.maxsize <= self._qsize()

    def _take_in(self, item):
        self._put(item)
        self.unfinished_tasks += 1
        self.not_empty.notify()

    def _give_out(self):
        given = self._get()
        self.not_full.notify()
        return given

    # What is left to do.

    def task_done(self):
        self._done_when(lambda: self.unfinished_tasks > 0, None, ValueError("task_done() called too many times"), False,
                        None, self._count_down)

    def _count_down(self):
        self.unfinished_tasks -= 1
        if not self.unfinished_tasks:
            self.all_tasks_done.notify_all()

    def join(self):
        self._done_when(lambda: not self.unfinished_tasks, self.all_tasks_done, None, True, None, bool)

    # How much there is; others may change it before the answer arrives.

    def qsize(self):
        with self.mutex:
            return self._qsize()

    def empty(self):
        return self.qsize() == 0

    def full(self):
        return 0 < self.maxsize <= self.qsize()


class PriorityQueue(Queue):
    """The smallest item comes out first."""
    _keeping = list, _push, _pop


class LifoQueue(Queue):
    """The newest item comes out first."""
    _keeping = list, list.append, list.pop


class SimpleQueue:
    """A queue without bound and without a count of open tasks."""

    def __init__(self):
        self._items = Queue()
        self.get, self.get_nowait, self.empty, self.qsize = (
            self._items.get, self._items.get_nowait, self._items.empty, self._items.qsize)

    def put(self, item, block=True, timeout=None):
        self._items.put(item)

    def put_nowait(self, item):
        self._items.put(item)
