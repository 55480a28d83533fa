"""The script's number functions that Python's math module has already, under the script's names (manual 3.2)."""

from math import acos, asin, atan, atan2, ceil, cos, floor, pow, sin, sqrt, tan
from random import random
from typing import Sized

__all__ = [
    "acos",
    "asin",
    "atan",
    "atan2",
    "ceil",
    "cos",
    "floor",
    "get_list_length",
    "length",
    "pow",
    "random",
    "sin",
    "sqrt",
    "tan",
]


def length(v: Sized) -> int:
    """Number of entries of a list or characters of a string (manual 3.2.8)."""
    return len(v)


def get_list_length(v: Sized) -> int:
    """Number of entries of a list (manual 3.2.7)."""
    return len(v)
