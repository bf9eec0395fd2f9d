"""Recordings as arrays."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass, field
from os import PathLike, fspath
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from . import _ridgetone
from ._events import Event, event

Path: TypeAlias = str | PathLike[str]
Array: TypeAlias = npt.NDArray[np.float64]

# A unit at the end of a column's name, in brackets. Columns of our own have volts.
_UNIT = re.compile(r"[\[(]([^\])]+)[\])]\s*$")
_TAXEL = re.compile(r"ain\d+$")


@dataclass(frozen=True, slots=True)
class Recording:
    """Samples of some channels, and what a board said of them.

    `values` has a row for each sample and a column for each channel; NaN is a missing reading. `time_s` has the times of the
    rows, or is None where there are none; then `rate_hz` may be given to whatever takes it.
    """

    file: str
    names: list[str]
    units: list[str | None]
    values: Array
    time_s: Array | None
    events: list[Event] = field(default_factory=list, repr=False)

    @property
    def rate_hz(self) -> float | None:
        """Rows per second by the first and the last time, for a quick look: `fit` finds it better. None without times."""
        if self.time_s is None or len(self.time_s) < 2:
            return None
        return float((len(self.time_s) - 1) / (self.time_s[-1] - self.time_s[0]))

    def __getitem__(self, name: str) -> Array:
        """The values of the channel of this name."""
        return self.values[:, self.names.index(name)]

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[np.generic]:
        return np.array(self.values, dtype=dtype, copy=copy)


Samples: TypeAlias = Recording | Path | npt.ArrayLike


def read(path: Path, *, time_column: str | None = None) -> Recording:
    """Reads a recording: a table as CSV, telemetry (`.rec`), or what `export` made of it (`.mcap`, JSON lines).

    Of telemetry the channels are the raw frames in volts, in no row if it was recorded without `--raw`, and `events` has its
    other messages. Of a table `time_column` says which column is the time, as `NAME`, `NAME:UNIT` or `none`; what is guessed of
    a table otherwise is said in a warning.
    """
    lines = _ridgetone.messages(path)
    events = [event(line) for line in lines or []]
    guessed = None
    try:
        names, times, values, guessed = _ridgetone.Samples.file(path, time_column).read()
    except _ridgetone.Error as error:
        if not events or "holds no frames" not in str(error):
            raise
        names, times, values = [f"ain{taxel}" for taxel in range(16)], bytearray(), bytearray()
    if guessed is not None:
        warnings.warn(f"{fspath(path)}: {guessed}", stacklevel=2)
    array = np.frombuffer(values, dtype=np.float64).reshape(-1, len(names))
    time_s = None if times is None else np.frombuffer(times, dtype=np.float64)
    return Recording(fspath(path), names, [unit(name) for name in names], array, time_s, events)


def unit(name: str) -> str | None:
    """The unit of a column, by its name; None if it does not say."""
    found = _UNIT.search(name)
    return found[1].strip() if found else "V" if _TAXEL.match(name) else None


def native(
    samples: Samples, time_s: npt.ArrayLike | None = None, names: list[str] | None = None
) -> _ridgetone.Samples:
    """Samples for the native part. An array of f32 or f64 is read where it is; any other is converted to f64."""
    if isinstance(samples, (str, PathLike)):
        if time_s is not None or names is not None:
            raise _ridgetone.UsageError("time_s and names are for arrays: a file has its own")
        return _ridgetone.Samples.file(samples, None)
    file = "array"
    if isinstance(samples, Recording):
        file, time_s = samples.file, samples.time_s if time_s is None else time_s
        names, samples = names or samples.names, samples.values
    values = numbers(samples)
    if values.ndim == 1:
        values = values[:, np.newaxis]
    if values.ndim != 2:
        raise _ridgetone.UsageError(f"an array of {values.ndim} dimensions: rows, then channels are needed")
    names = names or [f"ch{channel}" for channel in range(values.shape[1])]
    times = None if time_s is None else numbers(time_s).reshape(-1, 1)
    return _ridgetone.Samples.array(file, names, values, times)


def numbers(values: npt.ArrayLike) -> npt.NDArray[np.float32] | Array:
    array = np.asarray(values)
    if array.dtype in (np.float32, np.float64) and array.dtype.isnative:
        return array
    if array.dtype.kind not in "biuf":
        raise _ridgetone.UsageError(f"an array of {array.dtype}: numbers are needed")
    return array.astype(np.float64)
