"""Heaps in lists: the smallest item is item 0, every item is at most those at 2 i + 1 and 2 i + 2."""
from _heapq import heapify, heappop, heappush, heappushpop, heapreplace
from itertools import count as _count, islice as _islice


def nsmallest(n, iterable, key=None):
    return _first(n, iterable, key, False)


def nlargest(n, iterable, key=None):
    return _first(n, iterable, key, True)


def _first(n, iterable, key, reverse):
    """The first `n` in order; of equal ones those that came first. Few more than those are kept at a time."""
    if n == 1:
        nothing = object()
        found = (max if reverse else min)(iter(iterable), default=nothing, key=key)
        return [] if found is nothing else [found]
    length = _length_of(iterable)
    if length is not None and n >= length:
        return sorted(iterable, key=key, reverse=reverse)[:n]
    source = iter(iterable)
    # What is no number is refused in the words of these.
    n = min(-range(0, -n, -1).stop if reverse else range(n).stop, 2 ** 63 - 1)
    if n <= 0:
        return []
    most = max(n, 1024)
    some = list(_islice(source, most))
    if len(some) < most:
        return sorted(some, key=key, reverse=reverse)[:n]
    kept, number, step = [], 0, -1 if reverse else 1
    while some:
        if key is not None:
            # The number decides among equal ones, so that the items themselves are never compared.
            some = list(zip(map(key, some), _count(number, step), some))
            number += step * len(some)
        kept = sorted(kept + some, reverse=reverse)[:n]
        some = list(_islice(source, most))
    return kept if key is None else [row[2] for row in kept]


def _length_of(iterable):
    """How many items there are, None where that is not known."""
    try:
        return len(iterable)
    except (AttributeError, TypeError):
        return None


class _Head:
    """The next item of one of the iterables that are merged."""

    __slots__ = ("item", "value", "number", "iterator", "key", "reverse")

    def __init__(self, number, iterator, key, reverse):
        self.number = number
        self.iterator = iterator
        self.key = key
        self.reverse = reverse

    def step(self):
        for item in self.iterator:
            self.item = item
            self.value = item if self.key is None else self.key(item)
            return True
        return False

    def __lt__(self, other):
        first, second = (other.value, self.value) if self.reverse else (self.value, other.value)
        if first < second:
            return True
        return self.number < other.number and not second < first


def merge(*iterables, key=None, reverse=False):
    heads = [_Head(number, iter(iterable), key, reverse) for number, iterable in enumerate(iterables)]
    heads = [head for head in heads if head.step()]
    heapify(heads)
    while heads:
        head = heads[0]
        yield head.item
        if head.step():
            heapreplace(heads, head)
        else:
            heappop(heads)
