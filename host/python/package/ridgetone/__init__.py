"""The tone of the ridges under a tactile fingertip.

`fit` finds the one frequency that all channels of an array or of a recording share. `replay` runs a recording through the code
that the chip runs. `read` gives a recording's arrays, `live` a board's events. All of them are the command `ridgetone`'s own
functions: the same numbers to the last bit. `feel` estimates the firing of mechanoreceptors. Errors name Python's arguments.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

import numpy.typing as npt

from . import _events, _ridgetone
from ._events import *
from ._events import Event, Fit, event
from ._feel import Conversion, Felt, feel, volts_per_um
from ._live import Live, live
from ._objects import Object, Settings, load
from ._recording import Path, Recording, Samples, Times, native, read
from ._show import Picture
from ._ridgetone import Error, UsageError, __version__

__all__ = _events.__all__ + [
    "Conversion", "Error", "Felt", "Live", "Object", "Picture", "Recording", "Settings", "UsageError", "__version__", "feel", "fit", "live", "picture", "read",
    "replay", "settings", "volts_per_um",
]  # fmt: skip


def __dir__() -> list[str]:
    return sorted(__all__)


def fit(
    samples: Samples,
    rate_hz: float | None = None,
    *,
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
    exclude: Sequence[str] = (),
    moving_speed: bool = False,
) -> Fit:
    """Fits all channels with one common frequency, as `ridgetone fit` does.

    `samples` is an array with a row for each sample and a column for each channel, in any unit; NaN and masked values are
    missing readings. It may also be a data frame, a `Recording` or a file; of a file the slide of a touch is fitted, if there is
    one, unless `whole`. Give `rate_hz`, in hertz, or `time_s`, a time for each row in seconds or as dates, evenly spaced or not.
    A data frame may have them: as a column whose name says that it is the time, a column or an index of dates, or `time_column`, which is `NAME`,
    `NAME:UNIT` with s, ms, us, ns, min, h or d, or `none`, as for files.

    `speed_mm_s` or `position_mm`, a value for each row, fit by position: cycles per mm at any speed. `speed_column` and
    `position_column` name columns that have them. `positions` is a file of a robot's positions or speeds for the raw frames of a
    recording, as for `ridgetone fit --positions`; the two names are then of its columns. `min_hz` and `max_hz` bound the frequency. `picture` draws the result.
    `exclude` names what the recording does not hold, of `curved_baseline`, `coloured_noise`, `shared_noise`, `impulses` and
    `all`; `moving_speed` says that the speed changes as likely as not.

    An array of float32 or float64 is not copied, whatever its strides; others are converted to float64. Do not write to it
    from another thread meanwhile: the interpreter's lock is released.

    >>> import numpy as np
    >>> t = np.arange(1000) / 250
    >>> found = fit(np.c_[np.sin(50 * t), 3 * np.cos(50 * t) + 1], rate_hz=250)
    >>> found.status, round(found.frequency_hz, 3)
    ('good', 7.958)
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
    text, remarks, fitted = _ridgetone.fit(
        given,
        rate_hz,
        from_s,
        to_s,
        [str(name) for name in columns or []],
        harmonics,
        mains_hz,
        speed_column,
        position_column,
        positions,
        whole,
        mm_per_count,
        min_hz,
        max_hz,
        list(exclude),
        moving_speed,
    )
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
) -> list[Event]:
    """Runs a recording through the code that the chip runs, as `ridgetone replay` does.

    `samples` are volts, or `scale` times volts, at most 16 channels at 180 to 23,740 rows a second: they are taken as they are, at
    their own rate. A recording of telemetry gives its raw frames, bit for bit. Without samples a `scene`, a file or the plain scene,
    is played to a simulated ADS1258. `settings` are those of the board or of the library with some in place, such as
    `{"window_s": 0.5}`. Events of samples have no `Hello` and no `Health`.
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
    """Draws a result of `fit`: readings, fit, residual and spectra, as `ridgetone fit --svg` does. Of anything else it replays
    as `replay` does, and draws the channels, the phases of the touch and the fitted tone. A notebook shows the picture; as a
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
) -> tuple[list[Event], str | None]:
    if samples is not None and scene is not None:
        raise UsageError("a scene does not go with samples")
    given = None if samples is None else native(samples, times, names)
    lines, remarks, svg = _ridgetone.replay(
        given, scene, times.rate_hz, scale, seed, json.dumps(settings or {}), draws
    )
    _warn(remarks, 4)
    return [event(line) for line in lines], svg


def settings(file: Path | None = None, **changes: Any) -> Settings:
    """The library's settings, or those of a file, with some changed by their names: `settings(window_s=0.5)`.

    For those of a board see `Live.settings` and `Live.set`.
    """
    return load(Settings, _ridgetone.settings(file, json.dumps(changes)))


def _warn(remarks: list[str], level: int = 3) -> None:
    for remark in remarks:
        warnings.warn(remark, stacklevel=level)
