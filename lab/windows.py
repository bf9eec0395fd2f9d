"""Windows of frames with a known truth: tones, noises, drifts, and the Cramer-Rao bound of their common frequency.

Frequencies are in cycles per frame, so a window of `frames` rows is `frames` long: `fits` hands batches to the package at a
rate of 1. Times in seconds are at `RATE_HZ`. Arrays of values are windows by frames by channels.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import ridgetone
from scipy.linalg import toeplitz
from scipy.signal import lfilter

RATE_HZ = 241.14
"""Frames per second of the plan `paper`."""
CHANNELS = 16
NINETY_FIVE = 1.959964
"""Normal deviate whose magnitude is exceeded in 5 % of all cases."""
TABLE_2 = [(15, 3.6), (30, 3.6), (15, 4.1), (30, 4.1), (15, 3.1), (30, 3.1), (48, 3.1), (15, 2.6), (30, 2.6), (48, 2.6)]
"""Speeds in mm/s and periods in mm of Oddo et al. 2009, table 2."""
SINE = (1.0,)
RIDGES = (1.0, 0.4, 0.2, 0.1)
"""Relative amplitudes of the simulated finger's harmonics."""


def frames(window_s, rate_hz=RATE_HZ):
    return round(window_s * rate_hz)


# Noise: its mean square is 1 in each channel.


@dataclass(frozen=True)
class Covariance:
    """Covariance of the channels' noise over time and channels.

    Disturbances that are sums of first-order autoregressions (`parts`: factor and variance) reach the channels with `gains`
    (windows, channels, disturbances), or each channel has one of its own where `gains` is None. `white` is the variance of
    white noise next to them.
    """

    parts: tuple[tuple[float, float], ...] = ()
    white: float = 0.0
    gains: np.ndarray | None = None


def autoregression(rng, shape, factor):
    """Returns a stationary first-order autoregression of variance 1 along the second axis."""
    drive = np.sqrt(1 - factor**2) * rng.standard_normal(shape)
    drive[:, 0] /= np.sqrt(1 - factor**2)
    return lfilter([1], [1, -factor], drive, axis=1)


# Pink noise is a sum of relaxations with corners half a decade apart, Hz.
PINK = tuple((float(np.exp(-2 * np.pi * corner / RATE_HZ)), 1 / 7) for corner in (0.1, 0.3, 1, 3, 10, 30, 100))
FLOOR = 0.01
"""Fraction of the power that is white and independent, in addition to a shared disturbance."""


def coloured(rng, shape, parts):
    return sum(np.sqrt(variance) * autoregression(rng, shape, factor) for factor, variance in parts)


def resonance(rng, windows, count):
    """Returns two vibrations per window with the same random centre, 3 to 30 Hz, a tenth of it
    wide."""
    centre = log_uniform(rng, 3, 30, windows) / RATE_HZ
    turn = (np.exp(-np.pi * 0.1 * centre + 2j * np.pi * centre))[:, None]
    kick = np.sqrt(1 - np.abs(turn) ** 2)
    state = rng.standard_normal((windows, 2)) + 1j * rng.standard_normal((windows, 2))
    out = np.empty((windows, count, 2))
    for n in range(count):
        state = turn * state + kick * (rng.standard_normal((windows, 2)) + 1j * rng.standard_normal((windows, 2)))
        out[:, n] = state.real
    return out


def noise(rng, kind, windows, count):
    """Returns noise of a kind, and its covariance if known. Kinds: `white`, `impulses`, `pink`,
    `ar 0.9`, `shared pink`, `shared phases`, `shared walk`, `narrow band`."""
    shape = (windows, count, CHANNELS)
    word, _, factor = kind.partition(" ")
    if word == "white":
        return rng.standard_normal(shape), Covariance(white=1.0)
    if word == "impulses":
        # 1 % of the values are off by 20 standard deviations. The CRB ignores them, because
        # impulses are obvious.
        hits = (rng.random(shape) < 0.01) * np.where(rng.random(shape) < 0.5, 20.0, -20.0)
        return rng.standard_normal(shape) + hits, Covariance(white=1.0)
    if word in ("pink", "ar"):
        parts = PINK if word == "pink" else ((float(factor), 1.0),)
        return coloured(rng, shape, parts), Covariance(parts)
    gain, phase = rng.uniform(0.5, 1.5, (windows, CHANNELS)), rng.uniform(0, 2 * np.pi, (windows, CHANNELS))
    has_phases = factor in ("phases", "band")
    gains = np.stack([gain * np.cos(phase), gain * np.sin(phase)] if has_phases else [gain], axis=2)
    parts = PINK
    match factor:
        case "pink" | "phases":
            both = coloured(rng, (windows, count, gains.shape[2]), PINK)
        case "walk":
            both = np.cumsum(np.sqrt(6 / count) * rng.standard_normal((windows, count, 1)), axis=1)
            parts = None
        case "band":
            both, parts = resonance(rng, windows, count), None
        case _:
            raise ValueError(f"no noise is called {kind}")
    values = np.sqrt(1 - FLOOR) * both @ gains.transpose(0, 2, 1) + np.sqrt(FLOOR) * rng.standard_normal(shape)
    parts = parts and tuple((factor, (1 - FLOOR) * variance) for factor, variance in parts)
    return values, parts and Covariance(parts, FLOOR, gains)


def log_uniform(rng, low, high, count):
    return low * (high / low) ** rng.random(count)


# Cramer-Rao bound.


@lru_cache(maxsize=8)
def modes(parts, count):
    """Returns eigenvectors and eigenvalues of the covariance of autoregressions over time."""
    lag = np.arange(count)
    values, vectors = np.linalg.eigh(toeplitz(sum(variance * factor**lag for factor, variance in parts)))
    return vectors, np.maximum(values, 0)


def waves(t, frequency, harmonics):
    """Returns cosines and sines of harmonics, one per column."""
    angles = 2 * np.pi * frequency * np.outer(t, np.arange(1, harmonics + 1))
    return np.hstack([np.cos(angles), np.sin(angles)])


def bound(nuisance, slope, x, covariance, gains=None):
    """Returns the Cramer-Rao bound of a parameter with the derivative `slope` (frames by
    channels), with unknown multiples of `nuisance` (columns) in each channel, for any
    covariance; and the error of an estimator on the bound for the values `x`. If the covariance
    has `parts`, all arguments are in its `modes`."""
    scales = modes(covariance.parts, len(x))[1] if covariance.parts else np.zeros(len(x))
    directions = [(None, 1.0)]
    if gains is not None:
        # Mixtures of channels in which the disturbances are uncorrelated; all other mixtures have
        # only white noise.
        powers, mixtures = np.linalg.eigh(gains @ gains.T)
        strong = powers > 1e-9
        directions = [(mixtures[:, ~strong], 0.0), *((mixtures[:, [k]], powers[k]) for k in np.flatnonzero(strong))]
    information = score = 0.0
    for mixture, power in directions:
        weights = 1 / np.sqrt(power * scales + covariance.white)[:, None]
        across = [slope, x] if mixture is None else [slope @ mixture, x @ mixture]
        basis = np.linalg.qr(weights * nuisance)[0]
        steep, seen = (weights * columns for columns in across)
        steep = steep - basis @ (basis.T @ steep)
        information += np.square(steep).sum()
        score += (steep * seen).sum()
    return 1 / np.sqrt(information), score / information


# Tones, and the other contents of a window.


@dataclass(frozen=True)
class Tone:
    """A tone: cycles in the window (drawn between two numbers, or up to 40 Hz if the second is
    infinite), amplitudes of the harmonics relative to the strongest, SNR of the strongest, and
    the tone's speed: `steady`, or changing by a fraction of the frequency over the window with
    `wander` (below 2 Hz) or `chirp`."""

    cycles: tuple[float, float] = (1.6, np.inf)
    harmonics: tuple[float, ...] = RIDGES
    snr_db: float = 20.0
    speed: str = "steady"
    change: float = 0.0


@dataclass
class Windows:
    """A batch of windows in standard deviations of the noise, and the truth. Frequencies are in
    cycles per frame."""

    x: np.ndarray
    frequency: np.ndarray | None = None
    """Mean over the window."""
    wander: np.ndarray | None = None
    """RMS deviation of the frequency from its mean, as a fraction of the mean."""
    chirp: np.ndarray | None = None
    """Change of the frequency per frame; NaN if it wanders."""
    second: np.ndarray | None = None
    interferer: float | None = None
    """Frequency of hum as declared to the fit."""
    crb: np.ndarray | None = None
    """Cramer-Rao bound. `luck` is the error on the bound for the window's noise."""
    luck: np.ndarray | None = None
    slope: np.ndarray | None = None
    """Derivative of the tone with respect to the frequency, for windows of the simulated finger."""


def courses(rng, tone, windows, count):
    """Returns the frequency in each frame, windows by frames."""
    low, high = tone.cycles
    high = max(high if np.isfinite(high) else 40 / RATE_HZ * count, low)
    middle = (log_uniform(rng, low, high, windows) / count)[:, None] * np.ones(count)
    match tone.speed:
        case "steady":
            return middle
        case "wander":
            return middle * (1 + tone.change * autoregression(rng, (windows, count), np.exp(-2 * np.pi * 2 / RATE_HZ)))
        case "chirp":
            return middle * (1 + tone.change * ((np.arange(count) + 0.5) / count - 0.5))
    raise ValueError(f"no speed is called {tone.speed}")


def sound(rng, course, amplitudes, gains, envelope=1.0):
    """Returns a tone of harmonics with random phases, and its derivative by a frequency that all
    frames share."""
    windows, count = course.shape
    steps = np.concatenate([course[:, :1] * 0, 0.5 * (course[:, 1:] + course[:, :-1])], axis=1)
    turns = np.cumsum(steps, axis=1)
    order = np.arange(1, len(amplitudes) + 1)
    phases = rng.uniform(0, 2 * np.pi, (windows, len(amplitudes), gains.shape[1]))
    size = np.asarray(amplitudes)[:, None] * gains[:, None, :]
    a, b = size * np.cos(phases), size * np.sin(phases)
    angles = 2 * np.pi * turns[..., None] * order
    cos, sin = np.cos(angles), np.sin(angles)
    ramp = 2 * np.pi * order * np.arange(count)[:, None]
    return envelope * (cos @ a - sin @ b), -(ramp * sin) @ a - (ramp * cos) @ b


def drift(rng, extra, size, windows, count):
    """Returns a baseline of unknown size in each channel: its shapes (windows by frames by
    shapes) and its values."""
    part = ((np.arange(count) + 0.5) / count)[None, :]
    place, width = rng.uniform(0.2, 0.8, (windows, 1)), log_uniform(rng, 0.08, 0.25, (windows, 1))
    decay = rng.uniform(0.02, 0.05, (windows, 1))
    match extra:
        case "relaxation" | "relaxations":
            lengths = [log_uniform(rng, 0.1, 3, (windows, 1)) for _ in range(1 + extra.endswith("s"))]
            shapes = [np.exp(-part / length) for length in lengths]
        case "creep":
            shapes = [np.log1p(part / log_uniform(rng, 0.03, 1, (windows, 1)))]
        case "step":
            shapes = [(part > place) * 1.0]
        case "bump":
            shapes = [np.exp(-0.5 * ((part - place) / width) ** 2)]
        case "spike":
            shapes = [np.where(part < 0.3 * place, 0, np.exp(-np.maximum(part - 0.3 * place, 0) / decay))]
        case _:
            return np.zeros((windows, count, 0)), 0.0
    shapes = np.stack(shapes, axis=2)
    gains = rng.choice([-1, 1], (windows, shapes.shape[2], CHANNELS)) * rng.uniform(
        0.5, 1.5, (windows, shapes.shape[2], CHANNELS)
    )
    return shapes, size * shapes @ gains


BOUNDED = ("", "relaxation", "creep", "gains", "channels", "dead", "rounded")
"""Disturbances for which the bound is valid: linear in unknowns, or affecting only the values."""


def make(rng, windows, count, kind="white", tone=None, extra="", size=0.0):
    """Returns windows of noise of a kind, with a tone if there is one, and the disturbance that
    `extra` names. Sizes are in amplitudes of the tone, or without a tone in standard deviations
    of the noise."""
    x, covariance = noise(rng, kind, windows, count)
    out = Windows(x)
    amplitude = np.sqrt(2) * 10 ** (tone.snr_db / 20) if tone else 1.0
    slope = None
    if tone:
        course = courses(rng, tone, windows, count)
        gains = rng.uniform(0.5, 1.5, (windows, CHANNELS))
        if extra == "dead":
            gains[:, 3:5] = 0
        part = np.arange(count)[:, None] / count
        envelope = {"half": part >= 0.5, "decay": 10.0**-part}.get(extra, 1.0)
        added, slope = sound(rng, course, amplitude * np.asarray(tone.harmonics), gains, envelope)
        x += added
        out.frequency = course.mean(1)
        out.wander = np.sqrt(np.square(course / out.frequency[:, None] - 1).mean(1))
        out.chirp = course[:, 1] - course[:, 0] if tone.speed != "wander" else np.full(windows, np.nan)
        if extra in ("second", "close"):
            times = rng.choice([1.25, 1.4, 1.6, 2.4, 2.6], windows)
            if extra == "close":
                times = 1 + rng.uniform(*size, windows) / (out.frequency * count)
            again = rng.uniform(0.5, 1.5, (windows, CHANNELS))
            x += sound(rng, times[:, None] * course, amplitude * np.asarray(tone.harmonics), again)[0]
            out.second = times * out.frequency
    shapes, added = (
        drift(rng, extra, amplitude * size, windows, count)
        if extra not in ("second", "close")
        else drift(rng, "", 0, windows, count)
    )
    x += added
    if extra == "mains":
        # The declared frequency is 50 Hz, but the hum is at 49.5 Hz.
        out.interferer = 50 / RATE_HZ
        hum = rng.uniform(0.5, 1.5, (windows, CHANNELS)) * size * amplitude
        x += sound(rng, np.full((windows, count), 49.5 / RATE_HZ), (1.0,), hum)[0]
    clean = x.copy() if extra in ("gains", "rounded") else x
    change(rng, out, extra, size, amplitude)
    if tone and tone.speed == "steady" and covariance and extra in BOUNDED:
        silent = np.ptp(out.x, axis=1) == 0
        slope = np.where(silent[:, None, :], 0, slope)
        rounding = (size * amplitude) ** 2 / 12 if extra == "rounded" else 0.0
        covariance = Covariance(covariance.parts, covariance.white + rounding, covariance.gains)
        limits(out, slope, out.x if extra == "rounded" else clean, shapes, covariance, tone)
        if kind == "impulses":
            out.luck = None
    return out


def change(rng, out, extra, size, amplitude):
    """Changes values as in a real channel, and sets their offsets."""
    x, (windows, _, channels) = out.x, out.x.shape
    if extra == "gains":
        x *= 10 ** (4 * np.arange(channels) / (channels - 1) - 2)
    if extra == "rounded":
        x += rng.uniform(0, size * amplitude, (windows, 1, channels))
        np.round(x / (size * amplitude), out=x)
        x *= size * amplitude
    if extra == "clipped":
        np.clip(x, -size * amplitude, size * amplitude, out=x)
    if extra == "saturated":
        np.minimum(x[:, :, :3], 0.3 * amplitude, out=x[:, :, :3])
    flat = {
        "dead": slice(0, 3),
        "saturated": slice(3, 5),
        "channels": slice(int(size), channels) if extra == "channels" else None,
    }.get(extra)
    if flat is not None:
        x[:, :, flat] = 0
    step = size * amplitude if extra == "rounded" else 1.0
    x += np.round(rng.uniform(-200, 200, (windows, 1, channels))) * step


def limits(out, slope, x, shapes, covariance, tone, t=None):
    """Sets the bound of each window, with unknown offset, slope, drift and amplitudes in each
    channel."""
    windows, count, _ = x.shape
    t = np.arange(count) - (count - 1) / 2 if t is None else t
    base = np.column_stack([np.ones(count), t / count])
    harmonics = 1 + np.flatnonzero(tone.harmonics)[-1]
    nuisance = [np.hstack([base, shapes[w], waves(t, out.frequency[w], harmonics)]) for w in range(windows)]
    columns = np.concatenate([nuisance, slope, x - x[:, :1]], axis=2)
    if covariance.parts:
        columns = np.tensordot(columns, modes(covariance.parts, count)[0], (1, 0)).transpose(0, 2, 1)
    ends = np.cumsum([nuisance[0].shape[1], slope.shape[2]])
    gains = covariance.gains if covariance.gains is not None else [None] * windows
    results = [bound(*np.split(one, ends, axis=1), covariance, own) for one, own in zip(columns, gains, strict=True)]
    out.crb, out.luck = np.array(results).T


def finger(rng, windows, count, frequency, harmonics=RIDGES, snr_db=20.0, *, period_mm=3.0, taxels=range(CHANNELS), noise=1.0):
    """Returns windows of the simulated finger with random channels. Piezoresistors of a unit
    differ in strength and sign, and units 2 and 4 are one pitch further along the motion.
    `frequency` is in cycles per frame; the noise is `snr_db` below the mean power of the
    fundamental."""
    unit, piezo = np.divmod(np.arange(CHANNELS), 4)
    spread = 1 + 0.15 * rng.uniform(-1, 1, (windows, CHANNELS))
    size = np.array([6, 2.4, -5.2, 1.9])[piezo] * np.array([1, 0.8, 1.15, 0.9])[unit] * spread
    phase = 0.35 * piezo - 2 * np.pi * 2.3 / period_mm * (unit % 2) + 0.3 * rng.uniform(-1, 1, (windows, CHANNELS))
    phase = phase + 2 * np.pi * rng.random((windows, 1))
    size *= np.sqrt(2) * 10 ** (snr_db / 20) / np.sqrt(np.square(size).mean(1, keepdims=True))
    order = np.arange(1, len(harmonics) + 1)[:, None]
    own = np.where(order > 1, rng.uniform(-np.pi, np.pi, (windows, len(harmonics), CHANNELS)), 0)
    angles = order * phase[:, None, :] + own
    a = np.asarray(harmonics)[:, None] * size[:, None, :] * np.cos(angles)
    b = np.asarray(harmonics)[:, None] * size[:, None, :] * np.sin(angles)
    t = np.arange(count) - (count - 1) / 2
    turns = 2 * np.pi * frequency * np.outer(t, order)
    cos, sin, ramp = np.cos(turns), np.sin(turns), 2 * np.pi * np.outer(t, order)
    x = (
        cos @ a
        - sin @ b
        + noise * rng.standard_normal((windows, count, CHANNELS))
        + rng.uniform(-500, 500, (windows, 1, CHANNELS))
    )
    slope = -(ramp * sin) @ a - (ramp * cos) @ b
    taxels = list(taxels)
    out = Windows(x[:, :, taxels], np.full(windows, frequency), slope=slope[:, :, taxels])
    limits(out, out.slope, out.x, np.zeros((windows, count, 0)), Covariance(white=1.0), Tone(harmonics=tuple(harmonics)))
    return out


def narrowed(batch, channels, harmonics):
    """Returns the first channels of windows of the simulated finger, with their bound."""
    out = replace(batch, x=batch.x[:, :, :channels], slope=batch.slope[:, :, :channels])
    windows, count, _ = out.x.shape
    limits(out, out.slope, out.x, np.zeros((windows, count, 0)), Covariance(white=1.0), Tone(harmonics=tuple(harmonics)))
    return out


def joined(batches):
    names = ("x", "frequency", "crb", "luck", "slope")
    return Windows(**{name: np.concatenate([getattr(batch, name) for batch in batches]) for name in names})


def fits(batch, harmonics=4, **options):
    """Returns Ridgetone's fits of a batch in cycles per frame, from one call of the package."""
    windows, count, width = batch.x.shape
    rows = batch.x.reshape(windows * count, width)
    return ridgetone.fit(rows, 1.0, window_s=count, harmonics=harmonics, mains_hz=batch.interferer, **options)
