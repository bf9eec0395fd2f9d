"""Compute figures of the four papers a second time, sharing no code with the crates.

What the papers print, what `docs/results` has, and what is computed here are compared; the script fails
if one of them differs by more than its bar. Run it as

    python lab/papers/papers.py

It needs numpy. With `--command target/debug/ridgetone` it also tries the command on signals of its own.
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

RESULTS = Path(__file__).resolve().parents[2] / "docs" / "results"


class Checks:
    """Rows of what is printed, what is computed, and whether they agree."""

    def __init__(self):
        self.failed = 0

    def near(self, what, printed, computed, bar):
        is_near = abs(printed - computed) <= bar
        self.row(what, f"{printed:g}", f"{computed:.4g}", f"within {bar:g}", is_near)

    def within(self, what, printed, least, most):
        self.row(what, f"{printed:g}", f"{least:.3g} to {most:.3g}", "in the range", least <= printed <= most)

    def true(self, what, shown, is_true):
        self.row(what, "", shown, "", is_true)

    def row(self, what, printed, computed, bar, is_met):
        self.failed += not is_met
        print(f"| {what} | {printed} | {computed} | {bar} | {'ok' if is_met else '**differs**'} |")


def table(topic, name):
    """Rows of a table that a page of `docs/results` shows."""
    return json.loads((RESULTS / f"{topic}.json").read_text())["tables"][name]["rows"]


# --- Oddo et al. 2009 -------------------------------------------------------------------------

# Period in mm and speed in mm/s of C1 to C10.
COMBINATIONS = [(p, v) for p in (3.6, 4.1) for v in (15, 30)]
COMBINATIONS += [(p, v) for p in (3.1, 2.6) for v in (15, 30, 48)]
# Least-squares errors of Table 3, units 1 and 2, percent of the frequency.
TABLE_3 = [0.91, 1.26, 0.73, 0.79, 1.08, 1.27, 1.66, 0.93, 1.07, 1.47]
RATE_HZ, LENGTH_MM, RUNS = 241.14, 55, 4


def fastest_line(signal):
    """Number of the highest line of a periodogram without padding."""
    return 1 + np.argmax(np.abs(np.fft.rfft(signal - signal.mean()))[1:])


def least_squares(signals, start):
    """One frequency for all rows of signals, cycles a sample: its linear part is solved at each guess."""
    n = np.arange(signals.shape[1]) - (signals.shape[1] - 1) / 2

    def explained(cycles):
        basis = np.stack([np.cos(2 * np.pi * cycles * n), np.sin(2 * np.pi * cycles * n), np.ones(len(n))])
        q, _ = np.linalg.qr(basis.T)
        return np.square(signals @ q).sum()

    cycles = max(start + np.linspace(-0.75, 0.75, 7) / len(n), key=explained)
    step = 0.15 / len(n)
    for _ in range(5):
        below, here, above = (explained(cycles + d) for d in (-step, 0, step))
        bend = below - 2 * here + above
        if bend < 0:
            cycles += np.clip(0.5 * step * (below - above) / bend, -step, step)
        step *= 0.4
    return cycles


def runs_of_table_3(random, period_mm, speed_mm_s, slope, offset, scatter):
    """Errors of four runs, percent RMS of the nominal frequency: FFT, and least squares."""
    nominal_hz = speed_mm_s / period_mm
    squares = np.zeros(2)
    for _ in range(RUNS):
        # The cut begins anywhere between two frames.
        count = int(LENGTH_MM / speed_mm_s * RATE_HZ + random.uniform())
        percent = offset + slope * speed_mm_s + scatter * random.standard_normal()
        cycles = nominal_hz * (1 + percent / 100) / RATE_HZ
        phases = random.uniform(0, 2 * np.pi, (2, 1))
        signals = np.sin(2 * np.pi * cycles * np.arange(count) + phases)
        signals += 0.1 * random.standard_normal(signals.shape)
        line = np.mean([fastest_line(signal) for signal in signals]) / count
        found = np.array([line, least_squares(signals, cycles)]) * RATE_HZ
        squares += np.square(100 * (found / nominal_hz - 1))
    return np.sqrt(squares / RUNS)


def oddo(checks, seeds):
    """Table 3 over seeds: which figures are the stimulator's speed, and which are chance."""
    speeds = np.array([v for _, v in COMBINATIONS], float)
    slope, offset = np.polyfit(speeds, TABLE_3, 1)
    checks.near("S1: the line through Table 3, % at 0 mm/s", 0.5911, offset, 1e-3)
    checks.near("S1: its slope, % s/mm", 0.01905, slope, 1e-4)
    scatter = 0.166
    ranges = []
    for row, (period_mm, speed_mm_s) in zip(table("papers", "oddo_table_3"), COMBINATIONS):
        random = np.random.default_rng(seeds)
        errors = [runs_of_table_3(random, period_mm, speed_mm_s, slope, offset, scatter) for _ in range(seeds)]
        low, high = np.quantile(errors, [0, 1], axis=0)
        ranges.append((row[0], low, high))
        for pair, first in (("1, 2", 3), ("4, 2", 7)):
            # A little more than the seeds show: the table has two digits, and there are other seeds.
            checks.within(f"S1: {row[0]}, units {pair}, FFT, %", row[first], low[0] - 0.05, high[0] + 0.05)
            checks.within(f"S1: {row[0]}, units {pair}, least squares, %", row[first + 2], low[1] - 0.05, high[1] + 0.05)
    widest = max(high[1] - low[1] for _, low, high in ranges)
    checks.true("S1: least squares from seed to seed, %", f"at most {widest:.2f}", widest < 0.45)
    # Figures of the text.
    page = (RESULTS / "papers.md").read_text()
    for name, low, high in ranges:
        if high[0] - low[0] > 0.7:
            shown = f"{name} ({low[0]:.1f} to {high[0]:.1f} %)"
            checks.true(f"S1: the page says how FFT varies in {name}", shown, shown in page)


def two_gratings(checks):
    """3.6 and 3.1 mm at 30 mm/s, 1.35 Hz apart, in 0.35 s: section 4's example."""
    random, count = np.random.default_rng(1), round(0.35 * RATE_HZ)
    found = []
    for _ in range(200):
        pair = []
        for period_mm in (3.6, 3.1):
            cycles, phases = 30 / period_mm / RATE_HZ, random.uniform(0, 2 * np.pi, (2, 1))
            signals = np.sin(2 * np.pi * cycles * np.arange(count) + phases)
            signals += 0.1 * random.standard_normal(signals.shape)
            line = fastest_line(signals[0]) / count
            pair.append((RATE_HZ * line, RATE_HZ * least_squares(signals, line)))
        found.append(np.subtract(pair[1], pair[0]))
    by_fft, by_fit = np.transpose(found)
    same = 100 * np.mean(by_fft == 0)
    checks.true("S1: 3.6 and 3.1 mm in 0.35 s on one line of the FFT, % of 200", f"{same:.0f}", same > 50)
    checks.true("S1: apart by least squares, where 1.35 is true, Hz", f"{by_fit.min():.2f} to {by_fit.max():.2f}", 1 < by_fit.min() and by_fit.max() < 1.7)


# --- Okamoto et al. ---------------------------------------------------------------------------

WAVELENGTHS_MM = (0.5, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0)
POLYNOMIAL = (30770, -162663, 309743, -248938, 72298)


def highest_line_error(wavelength_mm, speed_mm_s, rate_hz, count):
    """Error of speed over the highest line's frequency, percent RMS over phases of a plain tone."""
    n = np.arange(count)
    cycles = speed_mm_s / wavelength_mm / rate_hz
    tones = [np.sin(2 * np.pi * (cycles * n + phase / 64)) for phase in range(64)]
    lines = np.array([fastest_line(tone) for tone in tones])
    found_mm = speed_mm_s / (lines * rate_hz / count)
    return 100 * np.sqrt(np.mean(np.square(found_mm / wavelength_mm - 1)))


def error_by_window(window_s):
    """Error of the highest line over all scales and a hand to and fro, percent RMS, at 1 kHz."""
    count, squares = round(1000 * window_s), []
    t_s = np.arange(4665) / 1000
    place_mm = 197 / (2 * np.pi * 1.07) * (1 - np.cos(2 * np.pi * 1.07 * t_s))
    for wavelength_mm in WAVELENGTHS_MM:
        tone = np.sin(2 * np.pi * place_mm / wavelength_mm + 1)
        for first in range(0, len(tone) - count, 8):
            middle = first + count / 2
            speed_mm_s = abs(197 * np.sin(2 * np.pi * 1.07 * middle / 1000))
            found_mm = speed_mm_s / (fastest_line(tone[first : first + count]) / count * 1000)
            squares.append((found_mm / wavelength_mm - 1) ** 2)
    return 100 * np.sqrt(np.mean(squares))


def student_tail(t, freedom):
    """Probability above t, by the integral of Student's density."""
    grid = np.linspace(0, t, 20001)
    log_scale = math.lgamma((freedom + 1) / 2) - math.lgamma(freedom / 2) - 0.5 * math.log(freedom * math.pi)
    density = np.exp(log_scale) * (1 + grid**2 / freedom) ** (-(freedom + 1) / 2)
    return 0.5 - np.sum((density[1:] + density[:-1]) / 2) * (grid[1] - grid[0])


def okamoto(checks):
    for row in table("papers", "okamoto_wavelengths"):
        if row[0] != "ridged" or not row[1].endswith("mm/s"):
            continue
        speed_mm_s, wavelength_mm = float(row[1].split()[0]), row[2]
        error = highest_line_error(wavelength_mm, speed_mm_s, 1458.33, 47)
        if row[3] is None:
            continue
        # Overtones and the drift of the skin move some windows by a line.
        what = f"S2: highest line of 32 ms, {wavelength_mm} mm at {speed_mm_s} mm/s, %"
        checks.near(what, row[3], error, 3)
    # Fewer than 1.5 cycles in 32 ms, as the text of the page has them.
    for speed_mm_s, printed in ((73.5, {1.6: 40, 1.8: 32, 2.0: 18, 2.5: 5, 3.0: 21}), (125.4, {3.0: 35})):
        for wavelength_mm, percent in printed.items():
            error = highest_line_error(wavelength_mm, speed_mm_s, 1458.33, 47)
            checks.near(f"S2: highest line of 32 ms, {wavelength_mm} mm at {speed_mm_s} mm/s, %", percent, error, 0.6)
    errors = {ms: error_by_window(ms / 1000) for ms in (16, 32, 64, 128)}
    shown = ", ".join(f"{ms} ms {error:.0f} %" for ms, error in errors.items())
    checks.true("S2: of 16, 32, 64 and 128 ms the extremes are worse than 32 ms", shown, errors[32] < min(errors[16], errors[128]))
    # Equation 6 as it is printed: the phase is v(t - D) t / lambda, and the frequency its derivative.
    t_s = np.linspace(0.12, 5, 100001)
    phase = 197 * np.sin(2 * np.pi * 1.07 * (t_s - 0.12)) * t_s / 1.4
    literal_hz = np.abs(np.gradient(phase, t_s)).max()
    checks.near("S2: equation 6 as printed sweeps within 5 s to, Hz", 4543, literal_hz, 50)
    checks.near("S2: where v / lambda is at most, Hz", 141, 197 / 1.4, 0.5)
    lambdas = np.arange(0.8, 2.001, 0.001)
    power = np.polyval(POLYNOMIAL, lambdas)
    peaks = np.flatnonzero((power[1:-1] > power[:-2]) & (power[1:-1] > power[2:])) + 1
    checks.true("S2: equation 2 has its maximum at 1.2 to 1.6 mm", f"{lambdas[peaks[0]]:.2f} mm", 1.2 < lambdas[peaks[0]] < 1.6)
    checks.near("S2: p of Welch's t = 2.70 with 10.13 degrees, one-tailed", 0.011, student_tail(2.70, 10.13), 5e-4)
    checks.true("S2: the printed p = 0.027 is neither one-tailed nor two-tailed", f"{2 * student_tail(2.70, 10.13):.3f} two-tailed", abs(2 * student_tail(2.70, 10.13) - 0.027) > 2e-3)
    # Welch's degrees of freedom lie between the smaller sample's and those of both together.
    checks.true("S2: 10.13 degrees are possible with eight people, not with four", "7 to 14; 3 to 6", 7 <= 10.13 <= 14 and not 3 <= 10.13 <= 6)


# --- Plates -----------------------------------------------------------------------------------


def f_tail(f, first, second):
    """Probability above f of Fisher's distribution, by the beta integral."""
    x = first * f / (first * f + second)
    # A substitution without the singularities at the ends.
    angle = np.linspace(math.asin(math.sqrt(x)), math.pi / 2, 20001)
    density = np.sin(angle) ** (first - 1) * np.cos(angle) ** (second - 1)
    whole = math.exp(math.lgamma(first / 2) + math.lgamma(second / 2) - math.lgamma((first + second) / 2)) / 2
    return np.sum((density[1:] + density[:-1]) / 2) * (angle[1] - angle[0]) / whole


def plates(checks):
    count = 8
    for what, r2, variables, most in (
        ("Soft by SA I", 0.562, 1, 0.05),
        ("Rough by FA II and M", 0.817, 2, 0.05),
        ("Soft by Ra", 0.586, 1, 0.05),
        ("Rough by Ra", 0.788, 1, 0.01),
    ):
        freedom = count - variables - 1
        p = f_tail(r2 / variables / ((1 - r2) / freedom), variables, freedom)
        checks.true(f"S3: {what}, R2 = {r2} of {count} plates: p < {most}", f"p = {p:.3g}", p < most)
    # With one variable the standardised coefficient is the root of R2, with the coefficient's sign.
    checks.near("S3: standardised coefficient of Soft by SA I", -0.75, -math.sqrt(0.562), 5e-3)
    checks.near("S3: equation 5, Hz", 82.64, 10 / 0.121, 5e-3)
    checks.near("S3: equation 6, V/um", 0.563, 0.313 / (2 * 0.278), 5e-4)
    loadings = np.array([0.893, -0.873, 0.853, -0.06, -0.0711, 0.0419, -0.014, -0.0199])
    others = np.array([[-0.065, 0.0528, -0.0617, 0.874, 0.824, -0.791, -0.0621, -0.127],
                       [0.0141, 0.0976, 0.0413, -0.0498, -0.0597, 0.106, 0.927, 0.918]])
    share = (np.square(loadings).sum() + np.square(others).sum()) / len(loadings)
    checks.near("S3: share of three components, from Table 2's loadings, %", 76.6, 100 * share, 0.1)


# --- Teletaction ------------------------------------------------------------------------------

# Table 7: proportions of types 1, 3, 4 and 5, and both chi-squares; Table 5: A, B, c and both times;
# Table 6.
TABLE_7 = np.array([
    [0.33, 0.20, 1.36, 0.50, 0.50, 0.0],
    [0.13, 0.23, 1.00, 0.83, 0.33, 15.43],
    [0.07, 0.03, 0.35, 0.50, 0.20, 5.93],
    [0.37, 0.10, 5.96, 0.83, 0.63, 3.07],
    [0.40, 0.23, 1.93, 0.70, 0.43, 4.35],
    [0.20, 0.03, 4.05, 0.73, 0.40, 6.77],
])
TABLE_5 = np.array([
    [2.29, 1.15, 0.70, 1.42, 2.14],
    [1.95, 1.10, 0.26, 3.90, 6.11],
    [2.20, 0.89, 0.58, 2.71, 3.82],
    [2.24, 0.67, 0.35, 2.81, 3.65],
    [2.04, 0.85, 0.30, 3.38, 4.78],
    [2.59, 0.34, 0.26, 3.88, 4.39],
])
TABLE_6 = np.array([0.43, 0.74, 0.62, 0.61, 0.69, 0.66])
TRIALS = 30


def chi_square(first, second):
    """Of two proportions of 30 trials each, from counts, with their average as what is expected."""
    counts = np.round(TRIALS * np.array([first, second]))
    expected = counts.mean()
    return np.square(counts - expected).sum() * (1 / expected + 1 / (TRIALS - expected)) if expected else 0.0


def people(checks):
    for subject, row in enumerate(TABLE_7, 1):
        for types, at in (("1 and 3", 0), ("4 and 5", 3)):
            checks.near(f"S4: Table 7, subject {subject}, types {types}", row[at + 2], chi_square(row[at], row[at + 1]), 0.025)
    differ = np.round(TRIALS * TABLE_7[:, 3]) - np.round(TRIALS * TABLE_7[:, 4])
    checks.near("S4: Figure 35, correlation", 0.92, np.corrcoef(differ, TABLE_6)[0, 1], 0.02)
    checks.near("S4: mean of Table 6, %", 62.5, 100 * TABLE_6.mean(), 0.1)
    for subject, (a, b, c, strain_s, stress_s) in enumerate(TABLE_5, 1):
        checks.near(f"S4: Table 6, subject {subject}", TABLE_6[subject - 1], math.exp(-1.8 / stress_s), 6e-3)
        checks.near(f"S4: Table 5, subject {subject}, last column by A and B, s", stress_s, strain_s * (1 + b / a), 0.02)
        is_right = abs(1 / c - strain_s) < 0.06
        shown = f"{1 / c:.2f} s, printed {strain_s} s"
        checks.true(f"S4: Table 5, subject {subject}, 1 / c" + (" contradicts" if subject == 3 else ""), shown, is_right != (subject == 3))


POISSON = 0.5


def normal(x, z):
    """Pressure, shear and strain under a normal line load on thin slices (equations 1 to 3)."""
    r4 = np.square(x * x + z * z)
    sz, sx, sxz = z**3 / r4, x * x * z / r4, x * z * z / r4
    return 2 / np.pi * sz, 2 / np.pi * sxz, 2 / np.pi * (sz - POISSON * sx)


def tangential(x, z):
    """The same under a line load along the surface."""
    r4 = np.square(x * x + z * z)
    sz, sx, sxz = x * z * z / r4, x**3 / r4, x * x * z / r4
    return 2 / np.pi * sz, 2 / np.pi * sxz, 2 / np.pi * (sz - POISSON * sx)


class Grid:
    """Places on a long line, and convolution over it."""

    def __init__(self, step):
        self.step, self.count = step, 1 << 17
        self.x = (np.arange(self.count) - self.count // 2) * step

    def through(self, profile, kernel):
        spectra = np.fft.rfft(profile) * np.fft.rfft(np.fft.ifftshift(kernel))
        return np.fft.irfft(spectra, self.count) * self.step


def decibels(signal, made):
    return 10 * np.log10(np.square(signal).sum() / np.square(made - signal).sum())


def table_1(contact, degrees):
    """Two layers of 2 mm; without shear only the pressure crosses the interface."""
    # Under an oblique load strain fades as 1 / x: the line is 13 m long.
    grid = Grid(0.1)
    sin, cos = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    inside = np.clip(1 - np.square(grid.x / 10), 0, None)
    profile = {"line": grid.x == 0, "block": inside > 0, "cylinder": np.sqrt(inside)}[contact].astype(float)
    profile /= profile.sum() * grid.step
    by = [[grid.through(profile, part) for part in load(grid.x, z)] for load in (normal, tangential) for z in (2, 4)]
    whole = cos * by[1][2] + sin * by[3][2]
    pressure = cos * by[0][0] + sin * by[2][0]
    return decibels(whole, grid.through(pressure, normal(grid.x, 2)[2]))


SHAPES = {
    "line loads": lambda x: x == 0,
    "pins of half the spacing": lambda x: (x >= -0.25) & (x < 0.25),
    "pins of the whole spacing": lambda x: (x >= -0.5) & (x < 0.5),
    "straight lines": lambda x: np.clip(1 - np.abs(x), 0, None),
    "ideal low-pass": np.sinc,
}
PER_SPACING = 32


def figure_16(ratio, name, has_shear):
    """Decibels at the worst phase of sampling between two layers of 1 mm."""
    grid = Grid(ratio / PER_SPACING)
    pressure, shear, _ = normal(grid.x, 1)
    signal = normal(grid.x, 2)[2]
    shape = SHAPES[name](grid.x / ratio).astype(float)
    shape /= shape.sum() * grid.step
    worst = math.inf
    for phase in range(0, PER_SPACING // 2 + 1, 4):
        at = (np.arange(grid.count) - grid.count // 2 - phase) % PER_SPACING == 0
        # A sample stands for a spacing of the profile.
        made = grid.through(grid.through(at * pressure * PER_SPACING, shape), normal(grid.x, 1)[2])
        if has_shear:
            made += grid.through(grid.through(at * shear * PER_SPACING, shape), tangential(grid.x, 1)[2])
        worst = min(worst, decibels(signal, made))
    return worst


def crossing(name):
    """Spacing over thickness from which on shear is of no use."""
    def gain(ratio):
        return figure_16(ratio, name, True) - figure_16(ratio, name, False)

    above = 0.5
    while gain(above) > 0:
        above += 0.25
    below = above - 0.25
    for _ in range(6):
        middle = 0.5 * (below + above)
        below, above = (middle, above) if gain(middle) > 0 else (below, middle)
    return 0.5 * (below + above)


def layers(checks):
    bars = {row[0]: float(row[2]) for row in table("distance", "bars")}
    for contact, name in (("line", "line"), ("block", "block, 20 wide"), ("cylinder", "cylinder, 20 wide")):
        for degrees in (0, 30):
            what = f"Table 1, {name}, {degrees} degrees, dB"
            checks.near(f"S4: {what}", bars[what], table_1(contact, degrees), 0.05)
    for name in SHAPES:
        what = f"Figure 16, limit without shear, {name}, dB"
        checks.near(f"S4: {what}", bars[what], figure_16(0.05, name, False), 0.05)
        what = f"Figure 16, shear is of no use from, {name}"
        checks.near(f"S4: {what}", bars[what], crossing(name), 0.03)


# --- The command ------------------------------------------------------------------------------


def plain_wave(period_mm, speed_mm_s, pitch_mm, path):
    """A touch under a wave that reaches units 2 and 4 `pitch_mm` after 1 and 3, and nothing else."""
    rate_hz, random = 241.14, np.random.default_rng(1)
    t_s = np.arange(int(6 * rate_hz)) / rate_hz
    rows = np.zeros((len(t_s), 16))
    for taxel in range(16):
        # A scan has 21 slots; each input is converted in its own.
        at_s = t_s + taxel / 21 / rate_hz
        late_mm = pitch_mm if taxel // 4 % 2 else 0
        gain, own = [(10, 0), (4, 0.9), (-9, 0.2), (3, -1.3)][taxel % 4]
        place_mm = speed_mm_s * np.clip(at_s - 1.5, 0, 4) - late_mm
        wave = gain * np.cos(2 * np.pi * place_mm / period_mm + own)
        rows[:, taxel] = np.where(at_s > 0.5, 20 + wave, 0) + 0.05 * random.standard_normal(len(t_s))
    header = "time_s," + ",".join(f"ch{n}" for n in range(16))
    np.savetxt(path, np.c_[t_s, rows * 1e-3], delimiter=",", header=header, comments="", fmt="%.7f")


def slide(command, path, *options):
    """The estimate of the whole slide."""
    done = subprocess.run([command, "replay", str(path), "--json", *options], capture_output=True, text=True, check=True)
    events = [json.loads(line) for line in done.stdout.splitlines()]
    return next(e for e in events if e["type"] == "estimate" and e["span"] == "slide")


def lags(checks, command):
    """A finger that is not the simulated one: the defaults say so, and its own calibration is right."""
    with tempfile.TemporaryDirectory() as folder:
        for period_mm in (2.6, 3.1, 3.6, 4.1):
            path = Path(folder, "wave.csv")
            plain_wave(period_mm, 30, 2.3, path)
            for options in ((), ("--pitch", "2.3")):
                found = slide(command, path, *options)
                off = (found["spatial_period_mm"] - period_mm) / found["spatial_period_sigma_mm"]
                what = f"S1: {period_mm} mm by lags, {' '.join(options) or 'defaults'}"
                is_honest = found["travel"] == "uncalibrated" and abs(off) < 2
                checks.true(what, f"{found['spatial_period_mm']:.3f} mm, {off:+.1f} sigma, {found['travel']}", is_honest)
            found = slide(command, path, "--pitch", "2.3", "--edge-phase", "0", "--edge-phase-sigma", "0.001")
            is_right = found["travel"] == "unique" and abs(found["spatial_period_mm"] / period_mm - 1) < 1e-3
            checks.true(f"S1: {period_mm} mm by lags, calibrated", f"{found['spatial_period_mm']:.4f} mm, {found['travel']}", is_right)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--command", help="the command to try, too")
    parser.add_argument("--seeds", type=int, default=100, help="seeds of Table 3")
    arguments = parser.parse_args()
    checks = Checks()
    print("| what | printed | computed here | bar |  |\n|---|---:|---:|---|---|")
    oddo(checks, arguments.seeds)
    two_gratings(checks)
    okamoto(checks)
    plates(checks)
    people(checks)
    layers(checks)
    if arguments.command:
        lags(checks, arguments.command)
    if checks.failed:
        sys.exit(f"{checks.failed} rows differ")


if __name__ == "__main__":
    main()
