"""Teletaction: people and skin by the paper's tables, two layers and their samples by kernels."""

import math

import numpy as np

from checks import span

# Table 1: signal over noise without shear, dB, at 0 and 30 degrees.
TABLE_1 = {"line": (16, 11), "block": (19, 7), "cylinder": (19, 8)}
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
# Section 4.2: by period, mm.
CHI_SQUARES_2 = {2.4: 2.41, 3.0: 4.98, 3.6: 7.29, 4.2: 34.3, 4.8: 28.7}


def chi_square(first, second):
    """Of two proportions of 30 trials each, from counts, with their average as what is expected."""
    counts = np.round(TRIALS * np.array([first, second]))
    expected = counts.mean()
    return np.square(counts - expected).sum() * (1 / expected + 1 / (TRIALS - expected)) if expected else 0.0


def retained(strain_s, stress_s, on_s, off_s):
    """Deformation of a Kelvin body after a force of on_s, over that at its end, by superposition of equation 5's creep."""
    creep = lambda t_s: 1 - (1 - strain_s / stress_s) * math.exp(-t_s / stress_s)
    return (creep(on_s + off_s) - creep(off_s)) / creep(on_s)


def people(checks):
    for subject, row in enumerate(TABLE_7, 1):
        for types, at in (("1 and 3", 0), ("4 and 5", 3)):
            checks.near(f"S4: Table 7, subject {subject}, types {types}", row[at + 2], chi_square(row[at], row[at + 1]), 0.025)
    differ = np.round(TRIALS * TABLE_7[:, 3]) - np.round(TRIALS * TABLE_7[:, 4])
    checks.near("S4: Figure 35, correlation", 0.92, np.corrcoef(differ, TABLE_6)[0, 1], 0.02)
    checks.near("S4: mean of Table 6, %", 62.5, 100 * TABLE_6.mean(), 0.1)
    add = lambda *row: checks.step("teletaction", *row)
    for kind, first in (("1 and 3", 0), ("4 and 5", 3)):
        printed, own = TABLE_7[:, first + 2], [chi_square(row[first], row[first + 1]) for row in TABLE_7]
        add(f"chi-squares of types {kind}, six subjects", "Table 7", ", ".join(f"{one:g}" for one in printed), ", ".join(f"{one:.2f}" for one in own), "NumPy, from the printed proportions")
    add("types 4 less 5 against Table 6", "Figure 35", "0.92", f"{np.corrcoef(differ, TABLE_6)[0, 1]:.2f}", "NumPy")
    tails = [math.erfc(math.sqrt(one / 2)) for one in CHI_SQUARES_2.values()]
    is_as_printed = [tail < 0.05 for tail in tails] == [mm >= 3.0 for mm in CHI_SQUARES_2]
    checks.true("S4: experiment 2, p of its five chi-squares", ", ".join(f"{tail:.2g}" for tail in tails), is_as_printed)
    add("experiment 2 at 2.4, 3, 3.6, 4.2, 4.8 mm: p", "section 4.2", "below 0.05 from 3 mm on", ", ".join(f"{tail:.1g}" for tail in tails), "NumPy, from the printed chi-squares")
    own = [math.exp(-1.8 / stress_s) for stress_s in TABLE_5[:, 4]]
    kept = [retained(strain_s, stress_s, 3.0, 1.8) for strain_s, stress_s in TABLE_5[:, 3:]]
    add("finger 1.8 s after a ridge", "Table 6", ", ".join(f"{one:g}" for one in TABLE_6), ", ".join(f"{one:.2f}" for one in own), f"NumPy; the whole Kelvin body keeps {span(kept, unit='')}")
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


def figure_16(ratio, name, has_shear, phases=None):
    """Decibels at the worst phase of sampling between two layers of 1 mm."""
    grid = Grid(ratio / PER_SPACING)
    pressure, shear, _ = normal(grid.x, 1)
    signal = normal(grid.x, 2)[2]
    shape = SHAPES[name](grid.x / ratio).astype(float)
    shape /= shape.sum() * grid.step
    worst = math.inf
    for phase in range(0, PER_SPACING // 2 + 1, 4) if phases is None else phases:
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
    """Rows that stand on shear, and samples between two layers."""
    add = lambda *row: checks.step("teletaction", *row)
    found = {(contact, degrees): table_1(contact, degrees) for contact in TABLE_1 for degrees in (0, 30)}
    for (contact, degrees), decibels_here in found.items():
        printed = TABLE_1[contact][degrees // 30]
        checks.near(f"S4: Table 1, {contact}, {degrees} degrees, dB", printed, decibels_here, 0.5)
    printed = ", ".join(f"{one}" for pair in TABLE_1.values() for one in pair)
    add("signal over noise without shear: line, block, cylinder, each at 0 and 30 degrees", "Table 1", f"{printed} dB", ", ".join(f"{one:.2f}" for one in found.values()) + " dB", "NumPy")
    limits, crossings = [], []
    for name in SHAPES:
        limits.append(figure_16(0.05, name, False))
        checks.near(f"S4: Figure 16, limit without shear, {name}, dB", 16, limits[-1], 0.2)
        crossings.append(crossing(name))
        checks.near(f"S4: Figure 16, shear is of no use from, {name}", 1, crossings[-1], 1.1)
    add("shear is of no use from a spacing over the layer of", "Figure 16", "1", span(crossings, unit="") + " by five ways", f"NumPy; **{sum(abs(one - 1) <= 0.1 for one in crossings)} of five within 10 %**")
    add("worst phase without shear, dense samples", "Figure 16", "16 dB", f"{min(limits):.1f} dB", "NumPy")
    quarter = [[figure_16(2, name, has_shear, [PER_SPACING // 4]) for has_shear in (True, False)] for name in ("straight lines", "line loads")]
    add("samples two layers apart, a quarter off the load: straight lines; line loads", "Figures 13, 14", "pictures", "; ".join(f"{a:.1f} dB, without shear {b:.1f}" for a, b in quarter), "NumPy")
    other_measures(checks)


def other_measures(checks):
    """Table 1's line by the greatest compressive strain and by the energy, which section 2.6 names."""
    grid = Grid(0.1)
    line = (grid.x == 0) / grid.step

    def measures(parts):
        sz, sxz, ez = parts
        sx = (sz - ez) / POISSON
        ex, half = sx - POISSON * sz, (1 + POISSON) * sxz
        greatest = (ez + ex) / 2 + np.hypot((ez - ex) / 2, half)
        return ez, greatest, (sz * ez + sx * ex + 2 * sxz * half) / 2

    whole = measures([grid.through(line, part) for part in normal(grid.x, 4)])
    pressure = grid.through(line, normal(grid.x, 2)[0])
    cut = measures([grid.through(pressure, part) for part in normal(grid.x, 2)])
    found = [decibels(signal, made) for signal, made in zip(whole, cut)]
    checks.near("S4: Table 1, line, by normal strain, dB", 15.9, found[0], 0.1)
    checks.true("S4: by the greatest compressive strain, and the energy, dB", f"{found[1]:.1f}, {found[2]:.1f}", min(found) > 10)
    checks.step("teletaction", "the line by greatest compressive strain; by energy", "section 2.6", "-", f"{found[1]:.1f} dB; {found[2]:.1f} dB", f"NumPy; {found[0]:.1f} dB by normal strain")
