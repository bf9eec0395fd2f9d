"""Okamoto et al.: the spectrum of 32 ms, the law of amplitude, and what the text says of eight people."""

import math

import numpy as np

from checks import span, table
from oddo import fastest_line

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


def power_of_highest_line(wavelength_mm, speed_mm_s):
    """His definition, over the tone's power: the mean over phases of the highest line of 32 ms at 1 kHz."""
    n = np.arange(32)
    tones = [np.sin(2 * np.pi * (speed_mm_s / wavelength_mm / 1000 * n + phase / 32)) for phase in range(32)]
    lines = [np.square(2 / 32 * np.abs(np.fft.rfft(tone - tone.mean()))).max() for tone in tones]
    return np.mean(lines)


def steps(checks, steady, errors, peak_mm):
    add = lambda *row: checks.step("okamoto", *row)
    add("power over period: its maximum", "eq. 2, Figure 11", "1.2 to 1.6 mm, R2 0.94", f"{peak_mm:.2f} mm; our finger 1.4 to 1.6, R2 {table('papers-runs', 'okamoto_polynomials')[1][6]:.2f}", "NumPy; the skin's grooves are guessed")
    volts = [75 / 6000 * np.polyval(POLYNOMIAL, mm) for mm in (0.8, 1.4, 2.0)]
    add("amplitude at 0.8, 1.4, 2 mm", "eq. 2, 3", "-", ", ".join(f"{v:.1f}" for v in volts) + " V", "NumPy; test of the crate")
    add("windows of 16, 32, 64, 128 ms, rms error", "section IV-A", "least at 32 ms", ", ".join(f"{error:.0f}" for error in errors.values()) + " %", "NumPy: 64 ms is near")
    add("error of 32 ms, steady hand, 0.5 to 3 mm", "Figure 8", "larger at 2 to 3 mm and 73.5 mm/s", span(steady, 0), "NumPy within 3 %; [the firmware's](papers-runs.md) are within 1 %")
    hand = [row for row in table("papers-runs", "okamoto_wavelengths") if row[0] == "ridged" and row[1] == "hand, one way"]
    add("the same, hand to and fro", "Figure 9", "right but for 2 to 3 mm", span([row[3] for row in hand], 0), "simulated; from 1.5 cycles on")
    powers = [row for row in table("papers-runs", "okamoto_powers") if row[0] == "ridged" and 0.8 <= row[1] <= 2.0]
    own = [[power_of_highest_line(row[1], v) for v in range(50, 231, 10)] for row in powers]
    flat = max(max(of) / min(of) for of in own)
    checks.true("S2: one tone's power by his definition, 50 to 230 mm/s, most over least", f"{flat:.2f}", 1.2 < flat < 2.6)
    add("power over the speed, most over least", "Figure 10", "flat", f"{max(row[5] for row in powers if row[5]):.2f} from 73.5 to 177.4 mm/s; by his definition {flat:.1f} from 50 to 230", "ours simulated; his of a plain tone, NumPy")
    means = {row[1]: sum(power_of_highest_line(row[1], v) for v in range(50, 231, 10)) / 19 for row in powers}
    by_his = max(powers, key=lambda row: means[row[1]] * row[3])[1]
    checks.true("S2: by his definition our finger's power has its maximum at, mm", f"{by_his}", 1.2 <= by_his <= 1.6)
    add("maximum of our finger's power by his definition", "Figure 11", "1.2 to 1.6 mm", f"{by_his} mm", "NumPy; from 1.7 mm on ours falls, theirs grows")
    add("p of t = 2.70, df = 10.13, one-tailed", "section V-D", "0.027", f"{student_tail(2.70, 10.13):.3f}", f"NumPy; two-tailed {2 * student_tail(2.70, 10.13):.3f}")


def okamoto(checks):
    steady = []
    for row in table("papers-runs", "okamoto_wavelengths"):
        if row[0] != "ridged" or not row[1].endswith("mm/s"):
            continue
        speed_mm_s, wavelength_mm = float(row[1].split()[0]), row[2]
        error = highest_line_error(wavelength_mm, speed_mm_s, 1458.33, 47)
        if row[3] is None:
            continue
        # Overtones and the drift of the skin move some windows by a line.
        what = f"S2: highest line of 32 ms, {wavelength_mm} mm at {speed_mm_s} mm/s, %"
        checks.near(what, row[3], error, 3)
        steady.append(row[3])
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
    steps(checks, steady, errors, lambdas[peaks[0]])
