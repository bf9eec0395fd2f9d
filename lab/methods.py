"""Other methods for a frequency that all channels share, as an engineer would write them from their sources.

Each takes a window, frames by channels, and gives the frequency in cycles per frame and its standard deviation; NaN where the
method has none.
"""

import warnings

import numpy as np
from scipy import optimize, stats

from windows import waves


def detrended(x):
    """Subtracts offset and slope from each channel."""
    base = np.linalg.qr(np.column_stack([np.ones(len(x)), np.arange(len(x))]))[0]
    return x - base @ (base.T @ x)


def highest_line(x):
    """Returns the highest line of the power spectrum summed over channels: no window or padding,
    and bins a cycle apart."""
    power = np.square(np.abs(np.fft.rfft(x - x.mean(0), axis=0))).sum(1)
    return (1 + np.argmax(power[1:])) / len(x), np.nan


def honest_fft(x, pad=8):
    """The usual first attempt: detrends, applies a Hann window, zero-pads by 8, sums the power
    over the channels, and fits a parabola to the logarithm at the peak, searched from one cycle
    on."""
    size = pad * 2 ** int(np.ceil(np.log2(len(x))))
    spectrum = np.fft.rfft(detrended(x) * np.hanning(len(x))[:, None], size, axis=0)
    power = np.square(np.abs(spectrum)).sum(1)
    first = max(2, round(size / len(x)))
    peak = min(first + np.argmax(power[first:]), len(power) - 2)
    a, b, c = np.log(power[peak - 1 : peak + 2])
    return (peak + 0.5 * (a - c) / (a - 2 * b + c)) / size, np.nan


def mean_of(frequencies, sigmas):
    weights = 1 / np.square(sigmas)
    return np.sum(weights * frequencies) / weights.sum(), 1 / np.sqrt(weights.sum())


def ieee1057(x, steps=8):
    """Fits the four-parameter sine of IEEE Std 1057-2017, 4.1.4, to each channel, starting at
    the peak of the padded spectrum. Averages by the fits' own sigmas."""
    n = len(x)
    t = np.arange(n) - (n - 1) / 2
    answers = []
    for y in x.T - x.mean(0)[:, None]:
        f = honest_fft(y[:, None])[0]
        a = b = 0.0
        for _ in range(steps):
            cos, sin = np.cos(2 * np.pi * f * t), np.sin(2 * np.pi * f * t)
            columns = np.column_stack([cos, sin, np.ones(n), t * (b * cos - a * sin)])
            columns = columns if a or b else columns[:, :3]
            solved = np.linalg.lstsq(columns, y, rcond=None)[0]
            a, b = solved[:2]
            if len(solved) == 4:
                f += np.clip(solved[3] / (2 * np.pi), -0.2 / n, 0.2 / n)
        left = y - columns @ solved
        inverse = np.linalg.pinv(columns.T @ columns)[3, 3]
        answers.append((f, np.sqrt(np.square(left).sum() / (n - 4) * inverse) / (2 * np.pi)))
    return mean_of(*np.array(answers).T)


def curve_fit(x):
    """Fits a sine with an offset to each channel with `scipy.optimize.curve_fit`. Averages by
    the sigmas of its covariances."""
    t = np.arange(len(x))

    def sine(t, f, a, b, c):
        return a * np.cos(2 * np.pi * f * t) + b * np.sin(2 * np.pi * f * t) + c

    def jacobian(t, f, a, b, c):
        cos, sin = np.cos(2 * np.pi * f * t), np.sin(2 * np.pi * f * t)
        return np.column_stack([2 * np.pi * t * (b * cos - a * sin), cos, sin, np.ones(len(t))])

    answers = []
    start = honest_fft(x)[0]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for y in x.T:
            try:
                found, covariance = optimize.curve_fit(sine, t, y, [start, y.std(), y.std(), y.mean()], jac=jacobian)
            except RuntimeError:
                continue
            answers.append((found[0], np.sqrt(covariance[0, 0])))
    answers = np.array(answers).reshape(-1, 2)
    answers = answers[np.isfinite(answers[:, 1]) & (answers[:, 1] > 0)]
    return mean_of(*answers.T) if len(answers) else (np.nan, np.nan)


def oddo2009(x, pair=(0, 4)):
    """Oddo et al. 2009, equations 7 to 9: fits one frequency, and amplitude, phase and offset of
    two channels, by descent from the highest line."""
    t, two = np.arange(len(x))[:, None], x[:, pair]
    two = two - two.mean(0)
    scale = two.std()
    two = two / scale

    def left(p):
        return (two - p[1:3] * np.sin(2 * np.pi * p[0] * t + p[3:5]) - p[5:7]).ravel()

    f = highest_line(two)[0]
    phases = np.angle(np.exp(-2j * np.pi * f * t).T @ two)[0] + np.pi / 2
    first = np.r_[f, two.std(0) * np.sqrt(2), phases, 0, 0]
    return optimize.least_squares(left, first, method="lm").x[0], np.nan


class Harmonic:
    """Harmonic least squares, with offset and slope in each channel. Channels are scaled to
    variance one."""

    def __init__(self, x):
        self.n, self.channels = x.shape
        self.t = np.arange(self.n) - (self.n - 1) / 2
        self.base = np.column_stack([np.ones(self.n), self.t / self.n])
        x = detrended(x)
        scale = np.sqrt(np.square(x).mean(0))
        self.x = x[:, scale > 0] / scale[scale > 0]

    def solve(self, f, harmonics):
        """Returns BIC, residuals, Gauss-Newton step, information, and each channel's part of the
        score."""
        columns = np.hstack([self.base, waves(self.t, f, harmonics)])
        q, r = np.linalg.qr(columns)
        seen = q.T @ self.x
        left = self.x - q @ seen
        amplitudes = np.linalg.solve(r, seen)[2:]
        order = 2 * np.pi * np.arange(1, harmonics + 1)[:, None]
        cos, sin = columns[:, 2 : 2 + harmonics], columns[:, 2 + harmonics :]
        slope = self.t[:, None] * (cos @ (order * amplitudes[harmonics:]) - sin @ (order * amplitudes[:harmonics]))
        slope -= q @ (q.T @ slope)
        weights = self.n / np.square(left).sum(0)
        scores = weights * (slope * left).sum(0)
        information = (weights * np.square(slope)).sum()
        unknowns = (2 * harmonics + 2) * self.x.shape[1] + 1
        criterion = self.n * np.log(np.square(left).mean(0)).sum() + unknowns * np.log(self.n)
        return criterion, scores.sum() / information, information, scores

    def best(self, power, pad, harmonics, tries=3, steps=6):
        """Returns the best criterion and frequency for this number of harmonics, from the
        highest sums over a comb."""
        last = (len(power) - 1) // harmonics
        sums = sum(power[: h * last + 1 : h] for h in range(1, harmonics + 1))
        peaks = 1 + np.flatnonzero((sums[1:-1] >= sums[:-2]) & (sums[1:-1] > sums[2:]))
        starts = [*peaks[np.argsort(-sums[peaks])[:tries]] / (pad * self.n), 0.7 / self.n, 1.1 / self.n]
        found = []
        for f in starts:
            for _ in range(steps):
                step = np.clip(self.solve(f, harmonics)[1], -0.2 / self.n, 0.2 / self.n)
                f = min(max(f + step, 0.3 / self.n), 0.49 / harmonics)
                if abs(step) < 1e-5 / self.n:
                    break
            found.append((self.solve(f, harmonics)[0], f))
        return min(found)


def nls(x, most=4, pad=4):
    """Harmonic least squares over all channels, with the order chosen by BIC (fast NLS: Nielsen,
    Christensen et al. 2017) and sigma from the scatter of the channels. NaN if BIC prefers no
    tone."""
    window = Harmonic(x)
    power = np.square(np.abs(np.fft.rfft(window.x, pad * window.n, axis=0))).sum(1)
    criterion, f, harmonics = min((*window.best(power, pad, h), h) for h in range(1, most + 1))
    if criterion > (2 * window.x.shape[1]) * np.log(window.n):
        return np.nan, np.nan
    _, _, information, scores = window.solve(f, harmonics)
    count = len(scores)
    sigma = np.sqrt(np.square(scores).sum() * count / (count - 1)) / information if count > 1 else information**-0.5
    return f, sigma * stats.t.ppf(0.975, max(count - 1, 1)) / stats.norm.ppf(0.975)


METHODS = {
    "honest FFT": honest_fft,
    "curve_fit per channel": curve_fit,
    "IEEE 1057 per channel": ieee1057,
    "Oddo 2009, two channels": oddo2009,
    "harmonic NLS, BIC": nls,
}
