# SPDX-License-Identifier: BSD-3-Clause
"""What the keys of NumPy's basic indexing, and an array of indices on one axis, choose of a volume."""

from __future__ import annotations

import operator
from typing import Any, List, NamedTuple, Optional, Tuple

import numpy


class AxisRange(NamedTuple):
    """Samples of an axis: every step-th one of [low, high), where step is at least 1."""

    low: int
    high: int
    step: int

    @property
    def size(self) -> int:
        return (self.high - self.low + self.step - 1) // self.step


class Selection(NamedTuple):
    """What a key chooses: a lattice to be read, and how the result is made of it."""

    shape: Tuple[int, ...]  #: of the result
    axes: Tuple[AxisRange, ...]  #: of the volume; without meaning if the result is empty
    rest: Tuple[Any, ...]  #: the key of the lattice that gives the result: a view, if runs is None
    #: Where an array chooses: an axis, and the ranges of it that are read one by one and joined.
    runs: Optional[Tuple[int, List[AxisRange]]]

    @property
    def is_empty(self) -> bool:
        return 0 in self.shape


def parse_key(key: Any, shape: Tuple[int, ...], dtype: numpy.dtype) -> Selection:
    """The selection of a key of integers, slices, Ellipsis, numpy.newaxis, and at most one array of indices
    or truth values along one axis.

    Raises
    ------
    IndexError, TypeError, ValueError
        As NumPy does for an array of the shape. TypeError also for more such arrays, or of more dimensions.
    """
    items = tuple(_simplify(item) for item in (key if isinstance(key, tuple) else (key,)))
    if sum(isinstance(item, numpy.ndarray) for item in items) > 1:
        raise _make_error()
    # An array without memory of its own knows all of NumPy's rules, and its words.
    model: Any = numpy.ndarray(shape, dtype, bytes(dtype.itemsize), 0, (0,) * len(shape))[items]
    axes: List[AxisRange] = []
    rest: List[Any] = []
    runs = None
    sizes = iter(shape)
    for item in items:
        if item is Ellipsis:
            for _ in range(len(shape) - sum(other is not None and other is not Ellipsis for other in items)):
                axes.append(AxisRange(0, next(sizes), 1))
                rest.append(slice(None))
            rest.append(Ellipsis)
        elif item is None:
            rest.append(None)
        elif isinstance(item, numpy.ndarray):
            ranges, place = _choose_each(item, next(sizes))
            runs = len(axes), ranges
            axes.append(AxisRange(0, 0, 1))
            rest.append(place)
        else:
            chosen, place = _choose(item, next(sizes))
            axes.append(chosen)
            rest.append(place)
    axes.extend(AxisRange(0, size, 1) for size in sizes)
    return Selection(numpy.shape(model), tuple(axes), tuple(rest), runs)


def _make_error() -> TypeError:
    return TypeError(
        "volumes are indexed by integers, slices, Ellipsis, numpy.newaxis, and one list of integers or truth "
        "values along an axis; read a box, and index that by other arrays"
    )


def _simplify(item: Any) -> Any:
    """An integer for what NumPy takes for one, an array for what chooses along an axis; a TypeError for what
    chooses elements one by one."""
    if type(item) in (int, slice):  # most of them
        return item
    is_flag = isinstance(item, (bool, numpy.bool_))
    if not is_flag and (item is None or item is Ellipsis or isinstance(item, (slice, str))):
        return item
    if not is_flag and numpy.ndim(item) == 0 and getattr(item, "dtype", None) != bool:
        try:
            return operator.index(item)
        except TypeError:
            return item  # NumPy says what is wrong with it
    array = numpy.asarray(item)
    if array.size == 0 and isinstance(item, list):
        return array.astype(int)
    if array.ndim and array.dtype.kind not in "biu":
        return item  # NumPy says what is wrong with it
    if array.ndim == 1:
        return array
    raise _make_error()


def _choose(item: Any, size: int) -> Tuple[AxisRange, Any]:
    """The samples of an axis that an integer or a slice chooses, and its key among them."""
    if not isinstance(item, slice):
        first = item + size if item < 0 else item
        return AxisRange(first, first + 1, 1), 0
    start, stop, step = item.indices(size)
    chosen = range(start, stop, step)
    if step > 0 or len(chosen) == 0:
        return AxisRange(start, max(start, stop), max(step, 1)), slice(None)
    return AxisRange(chosen[-1], start + 1, -step), slice(None, None, -1)


def _choose_each(item: numpy.ndarray, size: int) -> Tuple[List[AxisRange], Any]:
    """The ranges of neighbouring samples that an array chooses, and its key among all of them."""
    indices = numpy.flatnonzero(item) if item.dtype == bool else item.astype(numpy.int64)
    chosen, place = numpy.unique(numpy.where(indices < 0, indices + size, indices), return_inverse=True)
    ends = numpy.flatnonzero(numpy.diff(chosen) > 1) + 1
    return [AxisRange(int(run[0]), int(run[-1]) + 1, 1) for run in numpy.split(chosen, ends) if len(run)], place
