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
from ._frame import DataFrame, Framed, is_frame, seconds

Path: TypeAlias = str | PathLike[str]
Array: TypeAlias = npt.NDArray[np.float64]

# Unit in brackets at the end of a column's name. Our own columns of taxels are in volts.
_UNIT = re.compile(r"[\[(]([^\])]+)[\])]\s*$")
_TAXEL = re.compile(r"ain\d+$")


@dataclass(frozen=True, slots=True)
class Recording:
    """Samples of some channels, with the messages of the board.

    `values` has a row for each sample and a column for each channel; NaN is a missing reading. `time_s` has the times of the
    rows, or is None if there are none; then pass `rate_hz` to the function that takes the recording.
    """

    file: str
    names: list[str]
    units: list[str | None]
    values: Array
    time_s: Array | None
    events: list[Event] = field(default_factory=list, repr=False)

    @property
    def rate_hz(self) -> float | None:
        """Rows per second from the first and the last time; `fit` determines it more accurately. None without times."""
        if self.time_s is None or len(self.time_s) < 2:
            return None
        return float((len(self.time_s) - 1) / (self.time_s[-1] - self.time_s[0]))

    def __getitem__(self, name: str) -> Array:
        """Returns the values of the channel of this name."""
        return self.values[:, self.names.index(name)]

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[np.generic]:
        return np.array(self.values, dtype=dtype, copy=copy)


Samples: TypeAlias = Recording | Path | DataFrame | npt.ArrayLike


def read(path: Path, *, time_column: str | None = None, flatten: bool = False) -> Recording:
    """Reads a recording: a table as CSV, telemetry (`.rec`), or what `export` made of it (`.mcap`, JSON lines).

    From telemetry, the channels are the raw frames in volts (no rows if it was recorded without `--raw`), and `events` has the
    other messages. For a table, `time_column` names the time column, as `NAME`, `NAME:UNIT` or `none`; a warning lists what is
    guessed. With `flatten`, rows hold consecutive samples of one series.
    """
    lines = _ridgetone.messages(path)
    events = [event(line) for line in lines or []]
    guessed = None
    try:
        names, times, values, guessed = _ridgetone.Samples.file(path, time_column, flatten).read()
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
    """Returns the unit that a column's name declares; None without one."""
    found = _UNIT.search(name)
    return found[1].strip() if found else "V" if _TAXEL.match(name) else None


@dataclass(frozen=True, slots=True)
class Times:
    """Times of rows, as passed by the caller."""

    time_s: npt.ArrayLike | None = None
    time_column: str | None = None
    rate_hz: float | None = None
    has_columns: bool = False
    """True if the caller chose the columns, which are then channels."""


def native(
    samples: Samples,
    times: Times | None = None,
    names: list[str] | None = None,
    beside: tuple[str, npt.ArrayLike] | None = None,
) -> _ridgetone.Samples:
    """Converts samples for the native part. An array of f32 or f64 is not copied; any other is converted to f64. `beside` is an
    additional column with its name.
    """
    times = times or Times()
    time_s = times.time_s
    if isinstance(samples, (str, PathLike)):
        if time_s is not None or names is not None or beside is not None:
            raise _ridgetone.UsageError("time_s, names, speed_mm_s and position_mm are for arrays: a file has columns")
        return _ridgetone.Samples.file(samples, times.time_column, False, times.has_columns)
    file = "array"
    if hasattr(samples, "to_frame") and not is_frame(samples):
        samples = samples.to_frame()
    if is_frame(samples):
        framed = Framed(samples, "none" if time_s is not None else times.time_column, times.rate_hz is None)
        file, samples, names = "data frame", framed.values, names or framed.names
        time_s = framed.time_s if time_s is None else time_s
    elif times.time_column is not None:
        raise _ridgetone.UsageError("time_column is for files and data frames: give time_s, a time for each row")
    if isinstance(samples, Recording):
        file, time_s = samples.file, samples.time_s if time_s is None else time_s
        names, samples = names or samples.names, samples.values
    values = numbers(samples)
    if values.ndim == 1:
        values = values[:, np.newaxis]
    if values.ndim != 2:
        raise _ridgetone.UsageError(f"an array of {values.ndim} dimensions: rows, then channels are needed")
    if values.shape[1] > 16 and values.shape[1] > 4 * values.shape[0]:
        rows, columns = values.shape
        raise _ridgetone.UsageError(f"{rows} rows of {columns} channels: give the array transposed, x.T, with a row for each sample")
    names = names or [f"ch{channel}" for channel in range(values.shape[1])]
    stamps = None if time_s is None else numbers(time_s, is_time=True).reshape(-1, 1)
    column: dict[str, object] | None = None
    if beside is not None:
        column = {"name": beside[0], "values": numbers(beside[1]).reshape(-1, 1)}
    return _ridgetone.Samples.array(file, names, values, stamps, column)


def numbers(values: object, *, is_time: bool = False) -> npt.NDArray[np.float32] | Array:
    """Converts values to an array of floats. Masked values become NaN."""
    if is_time and getattr(values, "tz", None) is not None:
        values = values.tz_convert("UTC").tz_localize(None)  # type: ignore[attr-defined]
    array = np.asanyarray(values)
    if is_time and array.dtype.kind in "mM":
        return seconds(array)
    if array.dtype.kind not in "biuf":
        raise _ridgetone.UsageError(f"an array of {array.dtype}: numbers are needed")
    if isinstance(array, np.ma.MaskedArray):
        is_float = array.dtype in (np.float32, np.float64)
        hidden = np.ma.getmask(array)
        array = np.asarray(array) if is_float else np.asarray(array).astype(np.float64)
        if hidden is not np.ma.nomask:
            array = np.where(hidden, array.dtype.type(np.nan), array)
    array = np.asarray(array)
    if array.dtype in (np.float32, np.float64) and array.dtype.isnative:
        return array
    return array.astype(np.float64)
