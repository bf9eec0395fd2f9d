"""The tone of the ridges under a tactile fingertip.

`fit` finds the common frequency of all channels of an array or a recording. `replay` runs a recording through the code that the
chip runs, and `simulate` makes a recording. `read` returns a recording's arrays, and `live` a board's events. They call the
functions of the command `ridgetone`, so numbers are the same to the last bit. `feel` estimates the firing of mechanoreceptors.
Error messages use the names of Python's arguments.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, Unpack, overload

import numpy.typing as npt

from . import _events, _ridgetone
from ._events import *
from ._events import Event, Fit, event
from ._feel import Conversion, Felt, feel, volts_per_um
from ._live import Live, live
from ._objects import Object, Settings, load
from ._recording import Path, Recording, Samples, Times, native, read
from ._replayed import Replayed
from ._show import Picture
from ._simulate import Simulated, simulate
from ._windows import Fits, Options, arrays
from ._ridgetone import Error, UsageError, __version__

__all__ = _events.__all__ + [
    "Conversion", "Error", "Felt", "Fits", "Live", "Object", "Picture", "Recording", "Replayed", "Settings", "Simulated", "UsageError", "__version__", "feel", "fit",
    "live", "picture", "read", "replay", "settings", "simulate", "volts_per_um",
]  # fmt: skip


def __dir__() -> list[str]:
    return sorted(__all__)


@overload
def fit(
    samples: Samples, rate_hz: float | None = None, *, window_s: None = None, stride_s: None = None, **options: Unpack[Options]
) -> Fit: ...
@overload
def fit(
    samples: Samples, rate_hz: float | None = None, *, window_s: float, stride_s: float | None = None, **options: Unpack[Options]
) -> Fits: ...
def fit(
    samples: Samples,
    rate_hz: float | None = None,
    *,
    window_s: float | None = None,
    stride_s: float | None = None,
    time_s: npt.ArrayLike | None = None,
    names: list[str] | None = None,
    from_s: float | None = None,
    to_s: float | None = None,
    columns: Sequence[str | int] | None = None,
    time_column: str | None = None,
    harmonics: int | None = None,
    mains_hz: float | None = None,
    speed_column: str | None = None,
    position_column: str | None = None,
    positions: Path | None = None,
    speed_mm_s: npt.ArrayLike | None = None,
    position_mm: npt.ArrayLike | None = None,
    whole: bool = False,
    mm_per_count: float | None = None,
    min_hz: float | None = None,
    max_hz: float | None = None,
    exclude: str | Sequence[str] = (),
    moving_speed: bool = False,
) -> Fit | Fits:
    """Fit all channels with one common frequency, as `ridgetone fit` does.

    An array of float32 or float64 is not copied, whatever its strides; others are converted to float64. Do not write to it from
    another thread during the fit, which releases the interpreter's lock.

    Parameters
    ----------
    samples : array, data frame, Recording or path
        A row for each sample and a column for each channel, in any unit; NaN and masked values are missing readings. If a file
        has the slide of a touch, only the slide is fitted.
    rate_hz : float, optional
        Rows per second, Hz.
    window_s, stride_s : float, optional
        Fit windows of this length, one every `stride_s` seconds (default: back to back). The whole recording is used.
    time_s : array, optional
        A time for each row, in seconds or as dates, evenly spaced or not.
    names : list of str, optional
        Names of an array's columns.
    from_s, to_s : float, optional
        First and last time to use, s.
    columns : list of str, optional
        Columns to fit, by name or number, `3-8` for a range; all by default.
    time_column : str, optional
        Column of the time in a file or a data frame: `NAME`, `NAME:UNIT` with s, ms, us, ns, min, h or d, or `none`.
    harmonics : int, optional
        Maximum number of harmonics, including the fundamental, 1 to 5. Default: 5.
    mains_hz : float, optional
        Frequency of an interferer in all channels, such as mains hum, Hz.
    speed_mm_s, position_mm : array, optional
        Speed or position of each row, for a fit by position. The result is in cycles per mm, whatever the speed.
    speed_column, position_column : str, optional
        Names of the columns with the speed or the position.
    positions : path, optional
        File with a robot's positions or speeds for the raw frames of a recording, as for `ridgetone fit --positions`;
        `speed_column` or `position_column` then names a column of this file.
    whole : bool
        Fit the whole file, not only the slide.
    mm_per_count : float, optional
        Length of one count, if positions are encoder counts, mm.
    min_hz, max_hz : float, optional
        Bounds of the frequency, Hz.
    exclude : str or sequence of str
        Effects that the recording does not contain: `overtones`, `curved_baseline`, `coloured_noise`, `shared_noise`, `impulses`,
        or `all`, the lean scene: a single sine in white noise. The fit is then faster, but biased if they are present.
    moving_speed : bool
        Assume a 50 % chance that the speed varies; sigma grows by 20 %.

    Returns
    -------
    Fit
        The fit; `picture` draws it.
    Fits
        With `window_s`: arrays with one row per window.

    Raises
    ------
    UsageError
        Arguments contradict each other, or make no sense.
    Error
        The samples cannot be fitted. With `window_s`, such a window has the status `no_fit` instead.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(1000) / 250
    >>> found = fit(np.c_[np.sin(50 * t), 3 * np.cos(50 * t) + 1], rate_hz=250)
    >>> found.status, round(found.frequency_hz, 3)
    ('good', 7.958)
    >>> fits = fit(np.c_[np.sin(50 * t), 3 * np.cos(50 * t) + 1], rate_hz=250, window_s=1, stride_s=0.5)
    >>> fits.frequency_hz.round(3)
    array([7.958, 7.958, 7.958, 7.958, 7.958, 7.958, 7.958])
    """
    by = {
        "speed_mm_s": speed_mm_s,
        "position_mm": position_mm,
        "speed_column": speed_column,
        "position_column": position_column,
    }
    if len(several := [name for name, value in by.items() if value is not None]) > 1:
        raise UsageError(f"{' and '.join(several)}: one of them is enough")
    beside = None
    if position_mm is not None:
        beside, position_column = ("position_mm", position_mm), "position_mm:mm"
    elif speed_mm_s is not None:
        beside, speed_column = ("speed_mm_s", speed_mm_s), "speed_mm_s:mm/s"
    given = native(samples, Times(time_s, time_column, rate_hz, bool(columns)), names, beside)
    options: dict[str, object] = {
        "rate_hz": rate_hz,
        "from_s": from_s,
        "to_s": to_s,
        "columns": [str(name) for name in columns or []],
        "harmonics": harmonics,
        "mains_hz": mains_hz,
        "speed_column": speed_column,
        "position_column": position_column,
        "positions": positions,
        "whole": whole,
        "mm_per_count": mm_per_count,
        "min_hz": min_hz,
        "max_hz": max_hz,
        "exclude": [exclude] if isinstance(exclude, str) else list(exclude),
        "moving_speed": moving_speed,
    }
    if window_s is not None:
        return arrays(_ridgetone.fit_windows(given, options, window_s, window_s if stride_s is None else stride_s))
    if stride_s is not None:
        raise UsageError("stride_s is for windows: give window_s, too")
    text, remarks, fitted = _ridgetone.fit(given, options)
    _warn(remarks)
    found = load(Fit, text)
    vars(found)["_fitted"] = fitted
    return found


def replay(
    samples: Samples | None = None,
    *,
    scene: Path | None = None,
    rate_hz: float | None = None,
    time_s: npt.ArrayLike | None = None,
    names: list[str] | None = None,
    time_column: str | None = None,
    scale: float = 1.0,
    seed: int | None = None,
    settings: Mapping[str, Any] | None = None,
) -> Replayed:
    """Runs a recording through the code that the chip runs, as `ridgetone replay` does.

    Parameters
    ----------
    samples : array, data frame, `Recording`, `Simulated` or path, optional
        Samples in volts, or in units of `scale` volts: a row for each frame and a column for each of at most 16 channels, at
        180 to 23,740 rows per second. They are not resampled. A recording of telemetry supplies its raw frames, bit for bit.
    scene : path, optional
        Scene file to play to a simulated ADS1258 if there are no samples. Default: the plain scene.
    rate_hz : float, optional
        Rows per second, if there are no times.
    time_s : array, optional
        A time for each row, seconds or dates.
    names : list of str, optional
        Names of the channels of an array.
    time_column : str, optional
        Column of the time in a file or data frame, ``NAME`` or ``NAME:UNIT``.
    scale : float
        Volts per unit of the samples.
    seed : int, optional
        Seed of a scene, in place of its own.
    settings : mapping, optional
        Settings in place of the board's or the library's, such as ``{"window_s": 0.5}``.

    Returns
    -------
    Replayed
        All events in order, with the fields of the command's JSON. `contacts`, `slides`, `estimates` and `releases` select from
        them, and `columns` makes arrays of their fields. Samples yield neither `Hello` nor `Health`.

    Raises
    ------
    Error
        The samples cannot be read, or their rate is outside the library's range.

    >>> touch = replay(simulate())
    >>> [slide] = touch.slides
    >>> round(slide.end_s - slide.start_s, 1)
    2.0
    """
    return _replay(
        samples, scene, Times(time_s, time_column, rate_hz), names, scale, seed, settings, False
    )[0]


def picture(
    samples: Fit | Samples | None = None,
    *,
    scene: Path | None = None,
    rate_hz: float | None = None,
    time_s: npt.ArrayLike | None = None,
    names: list[str] | None = None,
    time_column: str | None = None,
    scale: float = 1.0,
    seed: int | None = None,
    settings: Mapping[str, Any] | None = None,
) -> Picture:
    """Draws a result of `fit`: readings, fit, residual and spectra, as `ridgetone fit --svg` does. Replays anything else as
    `replay` does, and draws the channels, the phases of the touch and the fitted tone. A notebook displays the picture; as a
    str it is SVG.
    """
    if isinstance(samples, Fit):
        if (fitted := vars(samples).get("_fitted")) is None:
            raise UsageError("a copy of a fit has no samples to draw: fit again")
        return Picture(fitted.picture())
    times = Times(time_s, time_column, rate_hz)
    svg = _replay(samples, scene, times, names, scale, seed, settings, True)[1]
    return Picture(svg or "")


def _replay(
    samples: Samples | None,
    scene: Path | None,
    times: Times,
    names: list[str] | None,
    scale: float,
    seed: int | None,
    settings: Mapping[str, Any] | None,
    draws: bool,
) -> tuple[Replayed, str | None]:
    if samples is not None and scene is not None:
        raise UsageError("a scene does not go with samples")
    given = None if samples is None else native(samples, times, names)
    lines, remarks, svg = _ridgetone.replay(
        given, scene, times.rate_hz, scale, seed, json.dumps(settings or {}), draws
    )
    _warn(remarks, 4)
    return Replayed(event(line) for line in lines), svg


def settings(file: Path | None = None, **changes: Any) -> Settings:
    """Returns the library's settings, or those of a file, with changes by name: `settings(window_s=0.5)`.

    For a board's settings see `Live.settings` and `Live.set`.
    """
    return load(Settings, _ridgetone.settings(file, json.dumps(changes)))


def _warn(remarks: list[str], level: int = 3) -> None:
    for remark in remarks:
        warnings.warn(remark, stacklevel=level)
