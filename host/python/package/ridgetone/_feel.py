"""Estimates the firing of mechanoreceptors over a recording, and scores (Sensors 18 (2018) 1588), with `ridgetone-feel`.

NumPy cuts the recording into windows and transforms them (equation 7); the native part evaluates the other equations.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _ridgetone
from ._objects import Object
from ._recording import Array, Samples, Times, native

# Window over which the paper computes its intensities, seconds.
PAPER_WINDOW_S = 3.0
# Minimum number of rows in a window.
_ROWS_MIN = 64
# Maximum deviation of a time stamp from even spacing, rows.
_UNEVEN_MAX = 0.25


class Felt(Object):
    """The result of `feel`.

    `receptors` has `receptor` ("FA I", "FA II", "SA I", "SA II"), `intensity` and `intensity_sigma`; `scores` has `name`
    ("soft", "rough"), `score` and `score_sigma`. If there is no value, `absent` has the reason.
    """

    file: str
    rate_hz: float
    window_s: float
    windows: int
    channels: list[str]
    m: float | None
    m_sigma: float | None
    receptors: list[Object]
    scores: list[Object]


class Conversion(Object):
    """The result of `volts_per_um`: a value for each channel, NaN if the reference produces no line in it."""

    frequency_hz: float
    channels: list[str]
    volts_per_um: list[float]
    sigma_fraction: list[float]


def feel(
    samples: Samples,
    rate_hz: float | None = None,
    *,
    volts_per_um: float | Sequence[float],
    sigma_fraction: float | Sequence[float] = 0.0,
    m: float | tuple[float, float] | None = None,
    window_s: float = PAPER_WINDOW_S,
    time_s: npt.ArrayLike | None = None,
    names: list[str] | None = None,
    from_s: float | None = None,
    to_s: float | None = None,
    columns: list[str] | None = None,
    time_column: str | None = None,
) -> Felt:
    """Estimates the firing of four kinds of mechanoreceptors while a finger slides, and the scores soft and rough.

    Parameters
    ----------
    samples, rate_hz, time_s, names, time_column
        As for `fit`, in volts or any other unit. Rows have to be evenly spaced in time; missing readings are interpolated.
    volts_per_um
        Amplitude in the samples' unit for one micrometre from peak to peak, for all channels or for each. See `volts_per_um`.
    sigma_fraction
        Relative standard deviation of `volts_per_um`; the error is common to all channels.
    m
        Ratio of tangential to normal force, alone or with its standard deviation. The score "rough" needs it.
    window_s
        Maximum length of a window. Intensities of windows other than 3 s are converted to 3 s, with more uncertainty.
    from_s, to_s, columns
        Part of the recording to use: only the slide, and only columns of vibration.

    Returns
    -------
    Felt
        Intensities (equations 8 and 9), averaged over the channels, and scores (equations 11 and 12), from 1 to 7.
    """
    data = _Even.of(samples, Times(time_s, time_column, rate_hz), names, _Part(from_s, to_s, columns))
    per_um = _for_each(volts_per_um, "volts_per_um", data.names)
    sigmas = _for_each(sigma_fraction, "sigma_fraction", data.names)
    used = ~np.isnan(per_um)
    if not used.any() or not (per_um[used] > 0).all() or not (sigmas[used] >= 0).all():
        raise _ridgetone.UsageError("volts_per_um has to be greater than 0, and sigma_fraction at least 0")
    windows = list(data.windows(window_s))
    spectra = np.stack([data.spectrum(window)[used] / per_um[used, np.newaxis] for window in windows])
    # The native part squares the amplitudes in f32, where larger ones could overflow.
    if not spectra.max() < 1e15:
        raise _ridgetone.UsageError(f"volts_per_um={volts_per_um}: amplitudes of {spectra.max():.1e} um are no vibration of skin")
    rows, with_sigma = len(windows[0]), (float(m), 0.0) if isinstance(m, (int, float)) else m
    found = _ridgetone.feel(spectra.astype(np.float32), rows / data.rate_hz, float(sigmas[used].mean()), with_sigma)
    return Felt(
        file=data.file,
        rate_hz=data.rate_hz,
        window_s=rows / data.rate_hz,
        windows=len(windows),
        channels=[name for name, is_used in zip(data.names, used, strict=True) if is_used],
        m=None if with_sigma is None else with_sigma[0],
        m_sigma=None if with_sigma is None else with_sigma[1],
        receptors=[_row("receptor", "intensity", row) for row in found[:4]],
        scores=[_row("name", "score", row) for row in found[4:]],
    )


def volts_per_um(
    samples: Samples,
    rate_hz: float | None = None,
    *,
    ra_um: float,
    rsm_mm: float,
    speed_mm_s: float,
    ra_sigma_um: float = 0.0,
    time_s: npt.ArrayLike | None = None,
    names: list[str] | None = None,
    from_s: float | None = None,
    to_s: float | None = None,
    columns: list[str] | None = None,
    time_column: str | None = None,
) -> Conversion:
    """Measures the conversion for `feel` with a surface of known roughness (equations 5 and 6).

    Parameters
    ----------
    samples
        Recording of the finger while it slides over the surface, at the rate of the later recordings.
    ra_um, ra_sigma_um
        Arithmetic average roughness of the surface, with its standard deviation, micrometres.
    rsm_mm, speed_mm_s
        Mean width of the roughness profile's elements, and speed of the finger; speed over width is the frequency of the line.

    Returns
    -------
    Conversion
        For each channel, the amplitude per micrometre from peak to peak, and its relative standard deviation.
    """
    if not min(ra_um, rsm_mm, speed_mm_s) > 0 or not ra_sigma_um >= 0:
        raise _ridgetone.UsageError("ra_um, rsm_mm and speed_mm_s have to be greater than 0, and ra_sigma_um at least 0")
    data = _Even.of(samples, Times(time_s, time_column, rate_hz), names, _Part(from_s, to_s, columns))
    windows = list(data.windows(PAPER_WINDOW_S))
    hz, measured_s = speed_mm_s / rsm_mm, len(windows[0]) / data.rate_hz
    if not 1 / measured_s <= hz < data.rate_hz / 2:
        raise _ridgetone.UsageError(
            f"speed_mm_s over rsm_mm is {hz:.4g} Hz: choose from {1 / measured_s:.4g} Hz, a cycle a window, to {data.rate_hz / 2:.4g} Hz, "
            "half the rate"
        )
    spectra = np.stack([data.spectrum(window) for window in windows])
    # The powers of small values would be below the range of f32.
    scale = float(spectra.max()) or 1.0
    lines = [(data.amplitude(window, hz) / scale).tolist() for window in windows]
    surface = {"ra_um": ra_um, "ra_sigma_um": ra_sigma_um, "rsm_mm": rsm_mm, "speed_mm_s": speed_mm_s}
    found = _ridgetone.volts_per_um(lines, (spectra / scale).astype(np.float32), measured_s, surface)
    if not any(found):
        raise _ridgetone.Error(f"{data.file}: no channel has a line at {hz:.4g} Hz: choose a part in which the finger slides over the reference")
    pairs = [one or (np.nan, np.nan) for one in found]
    return Conversion(
        frequency_hz=hz,
        channels=data.names,
        volts_per_um=[scale * value for value, _ in pairs],
        sigma_fraction=[sigma / value for value, sigma in pairs],
    )


def _row(name: str, what: str, row: tuple[str, tuple[float, float] | None, str | None]) -> Object:
    value, sigma = row[1] or (None, None)
    found = {name: row[0], what: value, f"{what}_sigma": sigma}
    return Object(found if row[2] is None else {**found, "absent": row[2]})


def _for_each(value: float | Sequence[float], what: str, names: list[str]) -> Array:
    values = np.asarray(value, dtype=np.float64)
    if values.shape not in [(), (len(names),)]:
        raise _ridgetone.UsageError(f"{what}: {values.size} values for {len(names)} channels: give one, or one for each")
    return np.broadcast_to(values, len(names))


@dataclass(frozen=True)
class _Part:
    from_s: float | None
    to_s: float | None
    columns: list[str] | None


@dataclass(frozen=True)
class _Even:
    """Rows that are evenly spaced in time, without gaps."""

    file: str
    names: list[str]
    rate_hz: float
    values: Array

    @classmethod
    def of(cls, samples: Samples, times: Times, names: list[str] | None, part: _Part) -> _Even:
        given = native(samples, times, names)
        names, stamps, read, guessed = given.read()
        if guessed is not None:
            warnings.warn(f"{given.name}: {guessed}", stacklevel=4)
        values = np.frombuffer(read, dtype=np.float64).reshape(-1, len(names))
        if times.rate_hz is not None and not 0 < times.rate_hz < np.inf:
            raise _ridgetone.UsageError(f"rate_hz={times.rate_hz}: must be greater than 0")
        if stamps is not None:
            t_s = np.frombuffer(stamps, dtype=np.float64)
        elif times.rate_hz is not None:
            t_s = np.arange(len(values)) / times.rate_hz
        else:
            raise _ridgetone.UsageError(f"{given.name}: give rate_hz, or time_s, a time for each row")
        for name in part.columns or []:
            if name not in names:
                raise _ridgetone.UsageError(f"{given.name}: no column {name}: choose from {', '.join(names)}")
        chosen = [names.index(name) for name in part.columns or names]
        is_in = (t_s >= (-np.inf if part.from_s is None else part.from_s)) & (t_s <= (np.inf if part.to_s is None else part.to_s))
        values, t_s = values[is_in][:, chosen], t_s[is_in]
        if len(t_s) < _ROWS_MIN:
            raise _ridgetone.Error(f"{given.name}: {len(t_s)} rows: at least {_ROWS_MIN} are needed")
        rate_hz, slots = (times.rate_hz, np.arange(len(t_s))) if times.rate_hz is not None else _slots(t_s, given.name)
        even = np.empty((slots[-1] + 1, len(chosen)))
        for channel, column in enumerate(chosen):
            known = np.isfinite(values[:, channel])
            if not known.any():
                raise _ridgetone.Error(f"{given.name}: column {names[column]} has no reading: choose others with columns")
            even[:, channel] = np.interp(np.arange(len(even)), slots[known], values[known, channel])
        return cls(given.name, [names[column] for column in chosen], rate_hz, even)

    def windows(self, longest_s: float) -> Iterator[Array]:
        """Yields windows that overlap by half or less, so that each counts as independent."""
        if not longest_s > 0:
            raise _ridgetone.UsageError(f"window_s={longest_s}: must be greater than 0")
        rows, all_rows = round(min(longest_s * self.rate_hz, len(self.values))), len(self.values)
        if rows < _ROWS_MIN:
            raise _ridgetone.UsageError(f"window_s={longest_s}: {rows} rows at {self.rate_hz:.6g} Hz, at least {_ROWS_MIN} are needed")
        steps = (all_rows - rows) // (rows // 2)
        for step in range(steps + 1):
            start = step * (all_rows - rows) // max(steps, 1)
            yield self.values[start : start + rows]

    @staticmethod
    def _weighted(window: Array) -> Array:
        """Subtracts the mean, and applies a Hamming window scaled to keep the amplitude of a sine."""
        rows = len(window)
        hamming = 0.54 - 0.46 * np.cos(2 * np.pi * np.arange(rows) / rows)
        weighted: Array = hamming[:, np.newaxis] * (window - window.mean(axis=0)) * (2 / (0.54 * rows))
        return weighted

    def spectrum(self, window: Array) -> Array:
        """Returns amplitudes by channel and bin: a sine of n whole cycles has its amplitude in bin n."""
        return np.abs(np.fft.rfft(self._weighted(window), axis=0))[: len(window) // 2].T

    def amplitude(self, window: Array, hz: float) -> Array:
        """Returns the amplitudes at a frequency that may lie between two bins."""
        turns = np.exp(-2j * np.pi * hz / self.rate_hz * np.arange(len(window)))
        amplitudes: Array = np.abs(turns @ self._weighted(window))
        return amplitudes


def _slots(t_s: Array, file: str) -> tuple[float, npt.NDArray[np.intp]]:
    """Returns the rate, and a number for each row; gaps skip numbers."""
    steps = np.diff(t_s)
    worst = np.inf
    for step_s in (t_s[-1] - t_s[0]) / (len(t_s) - 1), np.median(steps):
        if not step_s > 0:
            continue
        slots = np.rint((t_s - t_s[0]) / step_s)
        if 1 <= np.diff(slots).min() and slots[-1] < 2 * len(t_s):
            rate_hz = float(slots[-1] / (t_s[-1] - t_s[0]))
            worst = np.abs((t_s - t_s[0]) * rate_hz - slots).max()
            if worst < _UNEVEN_MAX:
                return rate_hz, slots.astype(np.intp)
    raise _ridgetone.Error(
        f"{file}: rows are not evenly spaced in time, as spectra need, or half of them are missing: give rate_hz if the stamps are wrong"
    )
