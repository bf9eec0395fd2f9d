"""Fits of many windows, as arrays."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike
from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Words = npt.NDArray[np.str_]


class Options(TypedDict, total=False):
    """Options of `fit` that windows share with a single fit; `fit` describes them."""

    time_s: npt.ArrayLike | None
    names: list[str] | None
    from_s: float | None
    to_s: float | None
    columns: list[str] | None
    time_column: str | None
    harmonics: int | None
    mains_hz: float | None
    speed_column: str | None
    position_column: str | None
    positions: str | PathLike[str] | None
    speed_mm_s: npt.ArrayLike | None
    position_mm: npt.ArrayLike | None
    whole: bool
    mm_per_count: float | None
    min_hz: float | None
    max_hz: float | None
    exclude: tuple[str, ...] | list[str]
    moving_speed: bool


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Fits:
    """Fits of the windows of a recording: arrays with one entry, or one row, per window.

    Numbers that a window does not have are NaN. Arrays of channels have a row for each window and a column for each name.

    Attributes
    ----------
    status : array of str
        `good`, `ambiguous`, `unsteady`, `doubtful`, `no_tone`, `too_short` or `nothing`; or `no_fit`, with the reason in `why`.
    frequency_hz, sigma_hz : array of float
        Mean of the common frequency over the window and its standard deviation, Hz.
    frequency_per_mm, sigma_per_mm, period_mm, period_sigma_mm : array of float
        Common spatial frequency, 1/mm, and period, mm, with their standard deviations.
    wander_percent, wander_sigma_percent : array of float
        RMS deviation of the frequency from its mean, and its standard deviation, %.
    chirp_hz_per_s, chirp_sigma_hz_per_s, chirp_per_mm2, chirp_sigma_per_mm2 : array of float
        Change of the frequency over the window and its standard deviation, Hz/s or 1/mm^2.
    other_tone_hz, other_tone_per_mm, other_tone_fraction : array of float
        Frequency of a second significant tone, and its power over that of the first.
    interferer_hz : array of float
        Frequency of the interferer as fitted, Hz.
    from_s, to_s, window_s : array of float
        Times of the first and the last row, and the length, s.
    rate_hz, rate_sigma_hz : array of float
        Rows per second, and the standard deviation by the time stamps, Hz.
    rows, rows_missing, readings_missing, harmonics : array of int
        Rows that were fitted, rows missing between them, blank cells, and harmonics in the fit.
    why : array of str
        Reason why a window has no fit; empty where it has one.
    names : list of str
        Names of the channels.
    usable : array of bool, windows by channels
        False for a constant channel or a ramp, which the fit omits.
    offset, amplitude, residual : array of float, windows by channels
        Level at the window's centre, amplitude of the fundamental and standard deviation of the residual, in the samples' unit.
    phase_rad : array of float, windows by channels
        Phase of the fundamental at the window's centre.
    """

    status: Words
    frequency_hz: Floats
    sigma_hz: Floats
    frequency_per_mm: Floats
    sigma_per_mm: Floats
    period_mm: Floats
    period_sigma_mm: Floats
    wander_percent: Floats
    wander_sigma_percent: Floats
    chirp_hz_per_s: Floats
    chirp_sigma_hz_per_s: Floats
    chirp_per_mm2: Floats
    chirp_sigma_per_mm2: Floats
    other_tone_hz: Floats
    other_tone_per_mm: Floats
    other_tone_fraction: Floats
    interferer_hz: Floats
    from_s: Floats
    to_s: Floats
    window_s: Floats
    rate_hz: Floats
    rate_sigma_hz: Floats
    rows: npt.NDArray[np.int64]
    rows_missing: npt.NDArray[np.int64]
    readings_missing: npt.NDArray[np.int64]
    harmonics: npt.NDArray[np.int64]
    why: Words
    names: list[str]
    usable: npt.NDArray[np.bool_]
    offset: Floats
    amplitude: Floats
    phase_rad: Floats
    residual: Floats

    def __len__(self) -> int:
        return len(self.status)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """Yields each window as a `dict`, with arrays for the channels: `pandas.DataFrame(fits)` is a table."""
        fields = [name for name in Fits.__annotations__ if name != "names"]
        return ({name: getattr(self, name)[at] for name in fields} for at in range(len(self)))

    def __repr__(self) -> str:
        counts = ", ".join(f"{count} {status}" for status, count in zip(*np.unique(self.status, return_counts=True), strict=True))
        return f"Fits({len(self)} windows: {counts})"


_COUNTS = ("rows", "rows_missing", "readings_missing", "harmonics")
_CHANNEL = ("offset", "amplitude", "phase_rad", "residual")
_TEXTS = ("status", "why")


def arrays(windows: list[tuple[float, str | None, str]]) -> Fits:
    """Makes arrays from the windows' JSON; a window without a fit has only its start and the reason."""
    fits: list[dict[str, Any]] = [
        json.loads(text) if text is not None else {"status": "no_fit", "from_s": from_s} for from_s, text, _ in windows
    ]
    cells: list[list[dict[str, Any]]] = [fit.get("channels", []) for fit in fits]
    names = next(([channel["name"] for channel in row] for row in cells if row), [])
    columns: dict[str, Any] = {"why": np.array([why for *_, why in windows]), "status": np.array([fit["status"] for fit in fits])}
    for name in Fits.__annotations__:
        if name in _COUNTS:
            columns[name] = np.array([fit.get(name, 0) for fit in fits], dtype=np.int64)
        elif name not in (*_CHANNEL, *_TEXTS, "names", "usable"):
            columns[name] = np.array([fit.get(name) for fit in fits], dtype=np.float64)
    blank: list[dict[str, Any]] = [{}] * len(names)
    cells = [row or blank for row in cells]
    for name in _CHANNEL:
        table = np.array([[channel.get(name) for channel in row] for row in cells], dtype=np.float64)
        columns[name] = table.reshape(len(fits), len(names))
    usable = np.array([[channel.get("usable", False) for channel in row] for row in cells], dtype=np.bool_)
    return Fits(names=names, usable=usable.reshape(len(fits), len(names)), **columns)
