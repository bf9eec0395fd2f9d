"""Data frames: their columns of numbers, and which of them is the time."""

from __future__ import annotations

import warnings
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from . import _ridgetone

Array = npt.NDArray[np.float64]


class DataFrame(Protocol):
    """A table of pandas or of polars, or anything else with named columns."""

    @property
    def columns(self) -> Any: ...
    def to_numpy(self) -> Any: ...


class Framed:
    """The channels of a data frame, and the times of its rows if they are known."""

    def __init__(self, frame: Any, time_column: str | None, needs_time: bool) -> None:
        names = [str(name) for name in frame.columns]
        columns = [_numbers(_column(frame, at)) for at in range(len(names))]
        split = _split_time(names, columns) if time_column is None and "time_s" not in names else None
        at, unit = (None, 1.0) if split else _time(names, columns, time_column)
        self.time_s: Array | None = None
        if split:
            self.time_s = columns[split[0]].astype(np.float64) + columns[split[1]] * split[2]
        elif at is not None:
            self.time_s = _seconds(columns[at], unit)
        elif time_column is None and needs_time:
            self.time_s = _index_s(getattr(frame, "index", None))
        times = split[:2] if split else (at,)
        channels = [(name, values) for number, (name, values) in enumerate(zip(names, columns, strict=True)) if number not in times]
        used = [(name, values.astype(np.float64)) for name, values in channels if values.dtype.kind in "biuf"]
        if words := [name for name, values in channels if values.dtype.kind not in "biuf"]:
            warnings.warn(f"no numbers, and so no channels: {', '.join(words)}", stacklevel=5)
        self.names = [name for name, _ in used]
        self.values = np.column_stack([values for _, values in used]) if used else np.zeros((len(frame), 0))


def is_frame(samples: object) -> bool:
    return hasattr(samples, "columns") and hasattr(samples, "to_numpy")


def _column(frame: Any, at: int) -> Any:
    """Returns a column by its position, because several columns may have one name."""
    return frame.iloc[:, at] if hasattr(frame, "iloc") else frame[frame.columns[at]]


def _numbers(column: Any) -> npt.NDArray[Any]:
    """Returns a column's values: missing numbers of any type as NaN, times with a zone in UTC."""
    if getattr(getattr(column, "dtype", None), "tz", None) is not None:
        column = column.dt.tz_convert("UTC").dt.tz_localize(None)
    values = np.asarray(column.to_numpy())
    if values.dtype.kind != "O":
        return values
    try:
        return np.asarray(column.to_numpy(dtype=np.float64, na_value=np.nan))
    except (TypeError, ValueError):
        return values


def _time(names: list[str], columns: list[npt.NDArray[Any]], time_column: str | None) -> tuple[int | None, float]:
    """Returns the index of the time column, or None, and the seconds per unit of the time."""
    if time_column == "none":
        return None, 1.0
    if time_column is not None:
        name, _, unit = time_column.rpartition(":")
        seconds_of_unit = _ridgetone.time_unit(unit)
        if time_column in names or seconds_of_unit is None:
            name, seconds_of_unit = time_column, None
        if name not in names:
            raise _ridgetone.UsageError(f"no column {name}; there are: {', '.join(names)}")
        at = names.index(name)
        # As for a file, the name may declare the unit.
        return at, _named_unit(name, columns[at]) or 1.0 if seconds_of_unit is None else seconds_of_unit
    if "time_s" in names:
        return names.index("time_s"), 1.0
    named = [at for at, name in enumerate(names) if _ridgetone.is_time(name) and columns[at].dtype.kind in "biuf"]
    named = [at for at in named if _grows(columns[at])]
    if len(named) == 1:
        at = named[0]
        if (unit_s := _named_unit(names[at], columns[at])) is not None:
            return at, unit_s
        raise _ridgetone.UsageError(f'column {names[at]} may be the time: say its unit with time_column="{names[at]}:ms" (or s, us, ns, min, h, d), or "none" and rate_hz')
    dates = [at for at, values in enumerate(columns) if values.dtype.kind in "mM"]
    if len(dates) > 1:
        several = ", ".join(names[at] for at in dates)
        raise _ridgetone.UsageError(f'{several} may all be the time: choose with time_column="{names[dates[0]]}", or "none"')
    return (dates[0] if dates else None), 1.0


def _split_time(names: list[str], columns: list[npt.NDArray[Any]]) -> tuple[int, int, float] | None:
    """Returns the indices of a column of whole seconds and of one of its fraction, as for a file, and the fraction's unit in seconds."""
    for at, fraction_at, unit_s in _ridgetone.split_times(names):
        seconds, fraction = columns[at], columns[fraction_at]
        if seconds.dtype.kind not in "iuf" or fraction.dtype.kind not in "iuf" or not len(seconds):
            continue
        # The years 2000 to 2100, as for a file.
        is_dated = 946_684_800 <= seconds[0] < 4_102_444_800
        is_clock = np.all(np.diff(seconds.astype(np.float64)) >= 0) and (is_dated or seconds[-1] > seconds[0])
        is_whole = np.all(seconds == np.floor(seconds)) and np.all(fraction == np.floor(fraction))
        if is_clock and is_whole and np.all((fraction >= 0) & (fraction * unit_s < 1)):
            return at, fraction_at, unit_s
    return None


def _named_unit(name: str, values: npt.NDArray[Any]) -> float | None:
    """Returns the seconds per unit of a time, from its name, or 1 for dates and for numbers with decimals; None if unknown."""
    if values.dtype.kind in "mM":
        return 1.0
    unit_s = _ridgetone.declared_unit(name)
    if unit_s is not None:
        return unit_s
    known = values[np.isfinite(values)] if values.dtype.kind == "f" else values
    if len(known) > 1 and _may_be_days(known):
        raise _ridgetone.UsageError(f'column {name} begins with {known[0]}, which may be days, as Excel and MATLAB count them: say so with time_column="{name}:d", or "{name}:s" if it is in seconds')
    return 1.0 if len(known) and np.any(known != np.floor(known)) else None


def _may_be_days(values: npt.NDArray[Any]) -> bool:
    """Returns True if numbers may be days since 1900 or since year 0, as for a file."""
    first, step = float(values[0]), float(np.median(np.diff(values[:1000].astype(np.float64))))
    return (20_000 <= first < 80_000 or 700_000 <= first < 780_000) and first != int(first) and 0 < step < 1e-3


def _grows(values: npt.NDArray[Any]) -> bool:
    """Returns True if a column may be a clock: it never decreases, and is not constant."""
    steps = np.diff(values[:1000].astype(np.float64))
    return bool(len(steps)) and bool(np.all(steps >= 0)) and bool(np.any(steps > 0))


def _index_s(index: Any) -> Array | None:
    """Returns the times of an index of dates, or of one called `time_s`."""
    if index is None:
        return None
    if getattr(index, "tz", None) is not None:
        index = index.tz_convert("UTC").tz_localize(None)
    values = np.asarray(index.to_numpy())
    return _seconds(values, 1.0) if values.dtype.kind in "mM" or index.name == "time_s" else None


def _seconds(values: npt.NDArray[Any], unit: float) -> Array:
    return seconds(values) if values.dtype.kind in "mM" else values.astype(np.float64) * unit


def seconds(times: npt.NDArray[Any]) -> Array:
    """Converts dates of any unit to seconds since the first, and durations to seconds. Missing times become NaN."""
    known = times[~np.isnat(times)]
    if times.dtype.kind == "M" and len(known):
        times = times - known[0]
    # A date in days or months has no fraction of a second to lose.
    exact = times.astype("timedelta64[ns]")
    return np.where(np.isnat(exact), np.nan, exact.astype(np.int64) * 1e-9)
