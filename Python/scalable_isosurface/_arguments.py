# SPDX-License-Identifier: BSD-3-Clause
"""Arguments of wrong types and values, told by their names."""

from __future__ import annotations

import operator
import os
from typing import Any, Optional, Tuple

import numpy


def take_integer(name: str, value: Any, least: Optional[int] = None) -> int:
    """An integer, of Python or NumPy."""
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} is an integer, and not {value!r}") from None
    if not -(1 << 63) <= number < 1 << 63 or (least is not None and number < least):
        raise ValueError(f"{name} is an integer of at least {least or 0}, and not {value!r}")
    return number


def take_number(name: str, value: Any) -> float:
    """A finite number."""
    number = take_numbers(name, value)
    if number.ndim:
        raise TypeError(f"{name} is a number, and not {value!r}")
    return float(number)


def take_numbers(name: str, value: Any, shape: Optional[Tuple[int, ...]] = None, what: str = "") -> numpy.ndarray:
    """Finite numbers, of a shape that `what` describes."""
    try:
        array = numpy.asarray(value)
        if value is None or array.dtype.kind not in "biufO":
            raise TypeError
        numbers = array.astype(float)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name} is {what or 'a number, or numbers'}, and not {value!r}") from None
    if shape is not None and numbers.shape != shape:
        raise ValueError(f"{name} is {what}, and not {value!r}")
    if not numpy.isfinite(numbers).all():
        raise ValueError(f"{name} has a number that is not finite: {value!r}")
    return numbers


def take_text(name: str, value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{name} is a str, and not {value!r}")
    if not value.isascii() and value.encode(errors="ignore").decode() != value:
        raise ValueError(f"{name} has a character that is none of Unicode: {value!r}")
    return value


def take_path(name: str, value: Any) -> str:
    """The name of a file. Bytes that are not UTF-8 are in it as `os.fsdecode` has them."""
    try:
        path = os.fspath(value)
    except TypeError:
        path = None
    if not isinstance(path, str):
        raise TypeError(f"{name} is the name of a file, a str or a path, and not {type(value).__name__}")
    if "\0" in path:
        raise ValueError(f"{name}: the name of a file has no character of code 0: {path!r}")
    return path


def take_threads(threads: Any) -> int:
    """0 if there is no number, and so as many as there are cores."""
    return 0 if threads is None else take_integer("threads", threads, 0)
