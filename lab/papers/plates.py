"""Plates: firing of mechanoreceptors by a finger sliding over eight plates, and the scores soft and rough.

The crate `ridgetone-feel` has the equations; here they are written once more, in NumPy, as a check of it.
"""

import math

import numpy as np
import ridgetone as rt
from scipy.stats import f as fisher

from train import stepwise

RATE_HZ, M = 10_000, 1.2
# Equations 1 to 4 and Table 1: the two lines of each threshold, um over hertz, and the frequencies
# at which they begin, meet and end.
THRESHOLDS = {
    "FA I": (499, -0.890, 52.1, 0.0119, 0.5, 12.2, 67.0),
    "FA II": (1690, -1.93, 2.00e-5, 1.39, 20.0, 241.0, 800.0),
    "SA I": (43.5, -0.545, 0.787, 0.683, 0.5, 26.2, 120.0),
    "SA II": (501, -0.783, 17.1, -0.0340, 0.5, 91.2, 400.0),
}
SURFACE = {"ra_um": 0.278, "rsm_mm": 0.121, "speed_mm_s": 10.0}
WINDOWS_S = (3.0, 1.6384, 0.8192, 0.4096, 0.2048)
# Table 2: loadings of eight words on three components.
LOADINGS = np.array([
    [0.893, -0.065, 0.0141], [-0.873, 0.0528, 0.0976], [0.853, -0.0617, 0.0413], [-0.06, 0.874, -0.0498],
    [-0.0711, 0.824, -0.0597], [0.0419, -0.791, 0.106], [-0.014, -0.0621, 0.927], [-0.0199, -0.127, 0.918],
])  # fmt: skip
SHARES, EIGENVALUES = [28.7, 26.2, 21.6], [2.55, 2.11, 1.47]


def windowed(values):
    """Subtracts the mean and applies Hamming's window."""
    n = np.arange(len(values))
    return (0.54 - 0.46 * np.cos(2 * np.pi * n / len(values))) * (values - values.mean())


def intensity(receptor, values, per_um, bins=1.0, gain=1.0):
    """Equations 1 to 4 and 7 to 9. In a shorter window each bin represents `bins` bins of 3 s,
    with `gain` times its amplitude."""
    a, a_slope, b, b_slope, first, bend, last = THRESHOLDS[receptor]
    hz = np.fft.rfftfreq(len(values), 1 / RATE_HZ)
    is_in = (hz > first) & (hz <= last)
    hz, amplitudes = hz[is_in], 2 / (0.54 * len(values)) * np.abs(np.fft.rfft(windowed(values)))[is_in]
    threshold_um = np.where(hz <= bend, a * hz**a_slope, b * hz**b_slope)
    return bins * np.log10(gain * amplitudes / per_um / threshold_um).clip(0).sum()


def scores(fa2, sa1):
    """Returns the scores of equations 11 and 12."""
    return 5.59 - 0.002 * sa1, -16.075 + 0.011 * fa2 + 11.633 * M


def recordings():
    """Returns three seconds of a rough surface without lines, and of a smooth surface that is a
    single tone."""
    rng, rows = np.random.default_rng(3), 3 * RATE_HZ
    hz = np.fft.rfftfreq(rows, 1 / RATE_HZ)
    shape = np.where(hz > 0, 1 / (1 + (hz / 150) ** 2), 0)
    tone = 0.313 * np.sin(2 * np.pi * SURFACE["speed_mm_s"] / SURFACE["rsm_mm"] * np.arange(rows) / RATE_HZ + 0.4)
    return 60 * np.fft.irfft(np.fft.rfft(rng.standard_normal(rows)) * shape, rows), tone + 1e-4 * rng.standard_normal(rows)


def chunks(values, rows):
    """Returns windows that overlap by half or less."""
    count = (len(values) - rows) // (rows // 2)
    starts = [step * (len(values) - rows) // count if count else 0 for step in range(count + 1)]
    return [values[start : start + rows] for start in starts]


def run(steps, short, seed):
    regressions(steps)
    components(steps, 500 if short else 4000)
    intensities(steps)
    # A short run makes all 200 too: 19 of 20 could be below the limit by chance, and 200 take only
    # a second.
    selection(steps, 200, seed)
    return {}


def regressions(steps):
    """Tests section 3.3: the significance of the printed R2 for eight plates."""
    count = 8
    for what, r2, variables, most in (("Soft by SA I", 0.562, 1, 0.05), ("Rough by FA II and M", 0.817, 2, 0.05),
                                      ("Soft by Ra", 0.586, 1, 0.05), ("Rough by Ra", 0.788, 1, 0.01)):  # fmt: skip
        freedom = count - variables - 1
        p = fisher.sf(r2 / variables / ((1 - r2) / freedom), variables, freedom)
        steps.add(f"p of {what}, R2 = {r2} (section 3.3)", f"below {most}", f"{p:.2g}", "as printed", holds=p < most)
    # With one variable, the standardised coefficient is the root of R2 with the coefficient's sign.
    steps.add("standardised coefficient of Soft by SA I (Figure 6)", "a picture, negative", f"{-math.sqrt(0.562):.2f}", "the root of R2")


def varimax(loadings):
    """Rotates the components so that each word loads on few of them."""
    turn = np.eye(loadings.shape[1])
    for _ in range(100):
        turned = loadings @ turn
        u, _, v = np.linalg.svd(loadings.T @ (turned**3 - turned * np.square(turned).mean(0)))
        turn = u @ v
    return loadings @ turn


def components(steps, people):
    """Tests Table 2 and the deletion rule of section 2.2."""
    own = 100 * np.square(LOADINGS).mean(0)
    steps.near("share of three components, from the printed loadings (Table 2)", [*SHARES, 76.6], [*own, own.sum()], 0.1, "{:.1f}", unit=" %")
    before = ", ".join(f"{100 * one / 8:.1f}" for one in EIGENVALUES)
    steps.add("the same from the printed eigenvalues of 8 words (Table 2)", "28.7, 26.2, 21.6; 76.6 %", f"{before}; {100 * sum(EIGENVALUES) / 8:.1f} %", "eigenvalues before the rotation, shares after it")
    # Scores with Table 2's loadings, and five words with small loadings. The rule must find the
    # eight words again.
    rng = np.random.default_rng(4)
    all_loadings = np.vstack([LOADINGS, rng.uniform(-0.35, 0.35, (5, 3))])
    drawn = rng.standard_normal((people, 3)) @ all_loadings.T
    drawn += np.sqrt(1 - np.square(all_loadings).sum(1)) * rng.standard_normal((people, 13))
    words = list(range(13))
    while True:
        values, vectors = np.linalg.eigh(np.corrcoef(drawn[:, words].T))
        kept = values > 1
        share = values[kept].sum() / len(words)
        if share > 0.75:
            break
        words.pop(np.abs(varimax(vectors[:, kept] * np.sqrt(values[kept]))).max(1).argmin())
    steps.add("deletion rule, from 13 words (section 2.2)", "8 words, 3 components, 76.6 %", f"{len(words)} words, {kept.sum()} components, {100 * share:.0f} %",
              "finds the eight, on made scores", holds=set(range(8)) <= set(words) and len(words) < 10 and kept.sum() == 3)  # fmt: skip


def intensities(steps):
    """Compares the package with the equations, on a synthetic surface."""
    rough, smooth = recordings()
    known = rt.volts_per_um(smooth, RATE_HZ, **SURFACE)
    turns = 2 * np.pi * SURFACE["speed_mm_s"] / SURFACE["rsm_mm"] / RATE_HZ * np.arange(len(smooth))
    per_um = 2 / (0.54 * len(smooth)) * abs((windowed(smooth) * np.exp(-1j * turns)).sum()) / (2 * SURFACE["ra_um"])
    steps.near("frequency of the reference (eq. 5)", 82.8, known.frequency_hz, 0.2, "{:.1f}", "`ridgetone.volts_per_um`", " Hz")
    steps.add("conversion (eq. 6)", "0.564 V/um", f"{known.volts_per_um[0]:.3f} V/um", f"as printed; NumPy {per_um:.3f}", "`ridgetone.volts_per_um`", abs(known.volts_per_um[0] - per_um) < 1e-5)

    def felt(window_s):
        found = rt.feel(rough, RATE_HZ, volts_per_um=known.volts_per_um, sigma_fraction=known.sigma_fraction, m=M, window_s=window_s)
        return {one.receptor: one.intensity for one in found.receptors}, {one.name: (one.score, one.score_sigma) for one in found.scores}

    own = {receptor: intensity(receptor, rough, per_um) for receptor in THRESHOLDS}
    found, by_name = felt(3.0)
    off = max(abs(found[receptor] - own[receptor]) / (1 + own[receptor]) for receptor in own)
    steps.add("intensities of 30,000 rows (eq. 1 to 9)", "-", f"within {100 * off:.0e} % of NumPy", "the same", "`ridgetone.feel`", off < 1e-4)
    soft, rough_score = scores(own["FA II"], own["SA I"])
    is_same = abs(by_name["soft"][0] - soft) < 2e-3 and abs(by_name["rough"][0] - rough_score) < 2e-3
    steps.add("Soft, Rough of the same (eq. 11, 12)", "-", f"{by_name['soft'][0]:.2f}, {by_name['rough'][0]:.2f}", "NumPy gives the same", "`ridgetone.feel`", is_same)
    literal, by_law, holds = [], [], True
    for window_s in WINDOWS_S:
        pieces, many = chunks(rough, round(window_s * RATE_HZ)), 3 / window_s
        as_is, law = (scores(np.mean([intensity("FA II", piece, per_um, many, gain) for piece in pieces]), 0)[1] for gain in (1, many**-0.5))
        score, sigma = felt(window_s)[1]["rough"]
        literal.append(as_is)
        by_law.append(score)
        holds &= abs(score - rough_score) < sigma and abs(score - law) < 0.05
    steps.add(f"Rough from windows of {', '.join(f'{one:.2g}' for one in WINDOWS_S)} s", "-", ", ".join(f"{one:.2f}" for one in by_law),
              f"within a sigma; sums times 3 s over the window give {', '.join(f'{one:.1f}' for one in literal)}", "`ridgetone.feel`", holds)  # fmt: skip


def selection(steps, runs, seed):
    """Tests section 3.3's stepwise regression with p < 0.10, on plates that follow equation 12."""
    rng, found = np.random.default_rng(seed), 0
    for _ in range(runs):
        fa2, sa1, m, other = rng.normal(300, 80, 8), rng.normal(100, 30, 8), rng.normal(1.2, 0.15, 8), rng.normal(0, 1, 8)
        rough = -16.075 + 0.011 * fa2 + 11.633 * m + rng.normal(0, 0.15, 8)
        found += set(stepwise({"FA II": fa2, "SA I": sa1, "M": m, "other": other}, rough)[0]) >= {"FA II", "M"}
    steps.add(f"stepwise regression of eight plates that follow equation 12, {runs} times (section 3.3)", "FA II and M", f"both taken in {100 * found / runs:.0f} %",
              "as printed, on made scores", "`lab/papers/train.py`", found > 0.95 * runs)  # fmt: skip
