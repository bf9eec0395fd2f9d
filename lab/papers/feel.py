"""Plates: intensities and scores as the paper computes them, beside `ridgetone.feel`."""

import numpy as np
import ridgetone

RATE_HZ = 10_000
# Equations 1 to 4 and Table 1: two lines of the threshold, um over hertz, and where they begin, meet and end.
THRESHOLDS = {
    "FA I": (499, -0.890, 52.1, 0.0119, 0.5, 12.2, 67.0),
    "FA II": (1690, -1.93, 2.00e-5, 1.39, 20.0, 241.0, 800.0),
    "SA I": (43.5, -0.545, 0.787, 0.683, 0.5, 26.2, 120.0),
    "SA II": (501, -0.783, 17.1, -0.0340, 0.5, 91.2, 400.0),
}
SURFACE = {"ra_um": 0.278, "rsm_mm": 0.121, "speed_mm_s": 10.0}
M = 1.2
WINDOWS_S = (3.0, 1.6384, 0.8192, 0.4096, 0.2048)


def windowed(values):
    """Samples under Hamming's window, less their mean."""
    n = np.arange(len(values))
    return (0.54 - 0.46 * np.cos(2 * np.pi * n / len(values))) * (values - values.mean())


def amplitudes(values):
    return 2 / (0.54 * len(values)) * np.abs(np.fft.rfft(windowed(values)))


def volts_per_um(reference):
    """Equations 5 and 6: the amplitude at a frequency that is between two lines."""
    turns = 2 * np.pi * SURFACE["speed_mm_s"] / SURFACE["rsm_mm"] / RATE_HZ * np.arange(len(reference))
    line = windowed(reference) * np.exp(-1j * turns)
    return 2 / (0.54 * len(reference)) * abs(line.sum()) / (2 * SURFACE["ra_um"])


def threshold_um(receptor, hz):
    a, a_slope, b, b_slope, _, bend, _ = THRESHOLDS[receptor]
    return np.where(hz <= bend, a * hz**a_slope, b * hz**b_slope)


def intensity(receptor, values, per_um, bins=1.0, gain=1.0):
    """Equations 7 to 9. Of another window each bin stands for `bins` of 3 s, whose amplitudes are `gain` times its own."""
    hz = np.arange(len(values) // 2 + 1) * RATE_HZ / len(values)
    is_in = (hz > THRESHOLDS[receptor][4]) & (hz <= THRESHOLDS[receptor][6])
    decades = np.log10(gain * amplitudes(values)[is_in] / per_um / threshold_um(receptor, hz[is_in]))
    return bins * decades.clip(0).sum()


def scores(fa2, sa1):
    """Equations 11 and 12."""
    return 5.59 - 0.002 * sa1, -16.075 + 0.011 * fa2 + 11.633 * M


def recordings():
    """Three seconds of a rough surface without lines, and of a smooth one that is one tone."""
    random = np.random.default_rng(3)
    rows = 3 * RATE_HZ
    hz = np.fft.rfftfreq(rows, 1 / RATE_HZ)
    shape = np.zeros(len(hz))
    shape[1:] = 1 / (1 + (hz[1:] / 150) ** 2)
    noise = np.fft.irfft(np.fft.rfft(random.standard_normal(rows)) * shape, rows)
    tone = 0.313 * np.sin(2 * np.pi * SURFACE["speed_mm_s"] / SURFACE["rsm_mm"] * np.arange(rows) / RATE_HZ + 0.4)
    return 60 * noise, tone + 1e-4 * random.standard_normal(rows)


def chunks(values, rows):
    """Windows that overlap by half or less."""
    steps = (len(values) - rows) // (rows // 2)
    starts = [step * (len(values) - rows) // steps if steps else 0 for step in range(steps + 1)]
    return [values[start : start + rows] for start in starts]


def felt(values, conversion, window_s):
    """Intensities and scores of the package."""
    found = ridgetone.feel(
        values, RATE_HZ, volts_per_um=conversion.volts_per_um, sigma_fraction=conversion.sigma_fraction, m=M, window_s=window_s
    )
    intensities = {one.receptor: one.intensity for one in found.receptors}
    return intensities, {one.name: (one.score, one.score_sigma) for one in found.scores}


def feel(checks):
    rough, smooth = recordings()
    per_um = volts_per_um(smooth)
    own = {receptor: intensity(receptor, rough, per_um) for receptor in THRESHOLDS}
    soft, rough_score = scores(own["FA II"], own["SA I"])
    conversion = ridgetone.volts_per_um(smooth, RATE_HZ, **SURFACE)
    checks.near("S3: frequency of the reference, equation 5, Hz", conversion.frequency_hz, 10 / 0.121, 5e-3)
    checks.near("S3: conversion, equation 6, V/um", conversion.volts_per_um[0], per_um, 1e-5)
    found, found_scores = felt(rough, conversion, 3.0)
    off = max(abs(found[receptor] - own[receptor]) / (1 + own[receptor]) for receptor in own)
    checks.true("S3: 30,000 rows, intensities of the package beside equations 5 to 9", f"within {off:.1e}", off < 1e-4)
    checks.near("S3: the same, Soft", found_scores["soft"][0], soft, 2e-3)
    checks.near("S3: the same, Rough", found_scores["rough"][0], rough_score, 2e-3)
    literal, found_by = [], []
    for window_s in WINDOWS_S:
        pieces = chunks(rough, round(window_s * RATE_HZ))
        many, fainter = 3 / window_s, (window_s / 3) ** 0.5
        # The sum over lines times 3 s over the window; and with noise fainter by the root of it, too.
        as_is, by_law = (scores(np.mean([intensity("FA II", piece, per_um, many, gain) for piece in pieces]), 0)[1] for gain in (1, fainter))
        score, sigma = felt(rough, conversion, window_s)[1]["rough"]
        literal.append(as_is)
        found_by.append(score)
        what = f"S3: Rough from windows of {window_s} s"
        checks.true(f"{what}; {rough_score:.2f} from 3 s", f"{score:.2f} +- {sigma:.2f}", abs(score - rough_score) < sigma)
        checks.near(f"{what}, noise by its own law", score, by_law, 0.05)
    checks.true("S3: the same with lines as they are times 3 s over the window", ", ".join(f"{one:.1f}" for one in literal), literal[-1] > literal[0] + 5)
    checks.step("plates", "frequency of the reference", "eq. 5", "82.8 Hz", f"{conversion.frequency_hz:.1f} Hz", "`ridgetone.volts_per_um`, NumPy; the paper's own figures")
    checks.step("plates", "conversion", "eq. 6", "0.564 V/um", f"{conversion.volts_per_um[0]:.3f} V/um", "`ridgetone.volts_per_um`, NumPy")
    checks.step("plates", "intensities of 30,000 rows", "eq. 1 to 9", "-", "within 0.01 %", "`ridgetone.feel` and NumPy on a made surface")
    checks.step("plates", "*Soft*, *Rough* of the same", "eq. 11, 12", "-", f"{found_scores['soft'][0]:.2f}, {found_scores['rough'][0]:.2f}", "NumPy gives the same")
    windows = ", ".join(f"{window_s:.2g}" for window_s in WINDOWS_S)
    shown = ", ".join(f"{score:.2f}" for score in found_by)
    naive = ", ".join(f"{score:.1f}" for score in literal)
    checks.step("plates", f"*Rough* from windows of {windows} s", "-", "-", shown, f"within a sigma; sums times 3 s over the window give {naive}")
