"""A phase-locked loop between fits: tried for answers at every frame, next to fits alone. Not in the firmware.

The loop follows one phase that all channels share. Each frame, less the offsets of the latest fit, is projected on that fit's
amplitudes by least squares, which gives the phase; a loop of the second order follows it.
"""

import numpy as np
import ridgetone

import pages
from windows import CHANNELS, RATE_HZ, autoregression, finger, frames

SECONDS = 3.0
FIRST_S, WATCHED_S = 0.4, 1.5
"""End of the first window, and from when on answers count, seconds."""
LOOP_INSTRUCTIONS = 350
"""Of a frame: 16 channels less their offsets, two products each, a sine and a cosine, an arc tangent. Estimated."""
WINDOWS_S = (0.1, 0.2)
SPEEDS = {"steady": 0.0, "10 % a second": 0.1, "wander of 1 %": 0.01}
# Window and stride of the fits, seconds, and the loop's bandwidth between them, Hz; 0 for the latest fit's answer.
TRIED = [(0.1, 0.0, 0), (0.2, 0.0, 0), (0.2, 0.05, 0), (0.2, 0.25, 0), (0.2, 0.25, 2), (0.2, 0.25, 4)]


def tones(rng, many, speed):
    """Pure tones of 15 to 21 Hz, 20 dB above white noise: values (tones, frames, channels), and frequencies, Hz."""
    count = frames(SECONDS)
    hz = rng.uniform(15, 21, (many, 1))
    t = np.arange(count) / RATE_HZ
    match speed:
        case "10 % a second":
            hz = hz * (1 + rng.choice([-0.1, 0.1], (many, 1)) * (t - 0.5 * SECONDS))
        case "wander of 1 %":
            hz = hz * (1 + 0.01 * autoregression(rng, (many, count), np.exp(-2 * np.pi * 2 / RATE_HZ)))
        case _:
            hz = hz * np.ones(count)
    phase = 2 * np.pi * np.cumsum(hz, 1) / RATE_HZ
    size, own = rng.uniform(0.5, 1.5, (many, 1, CHANNELS)), rng.uniform(0, 2 * np.pi, (many, 1, CHANNELS))
    noise = np.sqrt(0.005 * np.mean(size**2, 2, keepdims=True))
    return size * np.cos(phase[..., None] + own) + noise * rng.standard_normal((many, count, CHANNELS)), hz


def fitted(x, window_s, ends):
    """Lean fits of one tone in windows that end before these frames, Hz; NaN where they are not good."""
    count = frames(window_s)
    # Half a row less, so that rounding adds none.
    fits = ridgetone.fit(x, RATE_HZ, window_s=(count - 0.5) / RATE_HZ, stride_s=1 / RATE_HZ, harmonics=1, exclude=["all"])
    hz = np.where(fits.status == "good", fits.frequency_hz, np.nan)
    return hz[np.asarray(ends) - count]


def levels(x, hz):
    """Complex amplitudes at the end of a window, and offsets, for a frequency."""
    t = np.arange(len(x)) - (len(x) - 1)
    angle = 2 * np.pi * hz / RATE_HZ * t
    columns = np.column_stack([np.cos(angle), -np.sin(angle), np.ones(len(x)), t])
    cos, sin, offset, _ = np.linalg.lstsq(columns, x, rcond=None)[0]
    return cos + 1j * sin, offset


def follow(x, fits, ends, window_s, bandwidth_hz):
    """Answers of one tone at each frame from the first fit on, Hz: the loop's, or without a loop the latest fit's."""
    count, natural = frames(window_s), 2 * np.pi * bandwidth_hz / RATE_HZ
    answers, latest = np.full(len(x), np.nan), dict(zip(ends, fits, strict=True))
    phase = step = None
    for at in range(ends[0], len(x)):
        hz = latest.get(at, np.nan)
        if np.isfinite(hz):
            if bandwidth_hz:
                amplitudes, offsets = levels(x[at - count : at], hz)
                step = 2 * np.pi * hz / RATE_HZ if step is None else step
                phase = phase or 0.0
                amplitudes = amplitudes * np.exp(-1j * phase)
                project = np.linalg.pinv(np.column_stack([amplitudes.real, -amplitudes.imag]))
            answers[at] = hz
        elif not bandwidth_hz:
            answers[at] = answers[at - 1]
        if step is not None:
            phase += step
            cos, sin = project @ (x[at] - offsets)
            error = np.angle((cos + 1j * sin) * np.exp(-1j * phase))
            phase, step = phase + 1.4 * natural * error, step + natural**2 * error
            answers[at] = step * RATE_HZ / (2 * np.pi)
    return answers


def name(window_s, stride_s, bandwidth_hz):
    """A row of the table."""
    stride = f"every {stride_s:g} s" if stride_s else "at every frame"
    return f"{window_s:g} s, {stride}" + (f", loop of {bandwidth_hz} Hz between" if bandwidth_hz else "")


def trial(run):
    """Errors at each frame against the frequency at that frame, and instructions a second."""
    found = {}
    first, watched = frames(FIRST_S), frames(WATCHED_S)
    for speed in run.progress(list(SPEEDS), "loop"):
        x, hz = tones(run.rng(f"loop/{speed}"), 2 * run.windows, speed)
        all_ends = range(first, x.shape[1])
        every = {window_s: np.array([fitted(one, window_s, all_ends) for one in x]) for window_s in WINDOWS_S}
        for window_s, stride_s, bandwidth_hz in TRIED:
            stride = max(frames(stride_s), 1)
            fits, ends = every[window_s][:, ::stride], all_ends[::stride]
            off = np.array([follow(*one, ends, window_s, bandwidth_hz) for one in zip(x, fits, strict=True)]) / hz - 1
            off = off[:, watched:]
            own = found.setdefault(f"loop/{name(window_s, stride_s, bandwidth_hz)}", {})
            own[speed] = float(f"{100 * np.sqrt(np.nanmean(off**2)):.2g}")
            own[f"{speed}: unanswered"] = round(float(100 * np.mean(np.isnan(fits))), 1)
            own["strides_per_s"], own["loops_per_s"] = RATE_HZ / stride, RATE_HZ * (bandwidth_hz > 0)
    return found


def table(found, instructions):
    """Rows of what was tried; `instructions` gives those of a lean fit of a window after a good one."""
    rows = []
    for one in TRIED:
        cell = found[f"loop/{name(*one)}"]
        # A fit of 0.1 s is taken to cost what one of 0.2 s does.
        work = cell["strides_per_s"] * instructions(max(one[0], 0.2)) + cell["loops_per_s"] * LOOP_INSTRUCTIONS
        rows.append([name(*one), pages.significant(1e-6 * work, 2), cell["steady: unanswered"], *(cell[speed] for speed in SPEEDS)])
    return pages.table("windows|million instructions a second|unanswered, %|" + "|".join(f"{speed}: RMS, %" for speed in SPEEDS), rows)
