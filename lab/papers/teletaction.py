"""Moy et al., "Human Psychophysics for Teletaction System Design": strains under a layer, displays of pins, people's skin."""

import json
import math
import os
import subprocess

import numpy as np
import ridgetone as rt
from scipy.linalg import solve
from scipy.optimize import brentq, curve_fit, nnls
from scipy.stats import chi2

from pages import ROOT
from steps import span

POISSON = 0.5
# Table 1: signal-to-noise ratio without shear, dB, at 0 and 30 degrees.
TABLE_1 = {"line": (16, 11), "block": (19, 7), "cylinder": (19, 8)}
# Table 7: proportions of types 1 and 3, then of 4 and 5, each followed by its chi-square.
TABLE_7 = np.array([
    [0.33, 0.20, 1.36, 0.50, 0.50, 0.0], [0.13, 0.23, 1.00, 0.83, 0.33, 15.43], [0.07, 0.03, 0.35, 0.50, 0.20, 5.93],
    [0.37, 0.10, 5.96, 0.83, 0.63, 3.07], [0.40, 0.23, 1.93, 0.70, 0.43, 4.35], [0.20, 0.03, 4.05, 0.73, 0.40, 6.77],
])  # fmt: skip
# Table 5: A, B, c, and the relaxation times for constant strain and for constant stress, s.
TABLE_5 = np.array([
    [2.29, 1.15, 0.70, 1.42, 2.14], [1.95, 1.10, 0.26, 3.90, 6.11], [2.20, 0.89, 0.58, 2.71, 3.82],
    [2.24, 0.67, 0.35, 2.81, 3.65], [2.04, 0.85, 0.30, 3.38, 4.78], [2.59, 0.34, 0.26, 3.88, 4.39],
])  # fmt: skip
TABLE_6 = np.array([0.43, 0.74, 0.62, 0.61, 0.69, 0.66])
CHI_SQUARES_2 = {2.4: 2.41, 3.0: 4.98, 3.6: 7.29, 4.2: 34.3, 4.8: 28.7}
"""Chi-squares of section 4.2, by period in mm."""


def run(steps, short, seed):
    people(steps)
    skin(steps, seed)
    layers(steps, short)
    gratings(steps)
    block(steps)
    rows_of_pins(steps, short)
    textures(steps)
    return {}


def people(steps):
    """Tests the experiments, from the printed proportions of 30 trials each."""
    for kind, first in (("1 and 3", 0), ("4 and 5", 3)):
        counts = np.round(30 * TABLE_7[:, first : first + 2])
        expected = counts.mean(1, keepdims=True)
        own = (np.square(counts - expected) * (1 / expected + 1 / (30 - expected))).sum(1)
        steps.near(f"chi-squares of types {kind}, six subjects (Table 7)", TABLE_7[:, first + 2], own, 0.025, "{:.2f}")
    differ = np.round(30 * TABLE_7[:, 3]) - np.round(30 * TABLE_7[:, 4])
    steps.near("correlation of types 4 less 5 with Table 6 (Figure 35)", 0.92, float(np.corrcoef(differ, TABLE_6)[0, 1]), 0.02, "{:.2f}")
    tails = chi2.sf(list(CHI_SQUARES_2.values()), 1)
    steps.add("p of experiment 2 at 2.4, 3, 3.6, 4.2, 4.8 mm (section 4.2)", "below 0.05 from 3 mm on", ", ".join(f"{one:.1g}" for one in tails),
              "as printed", holds=[one < 0.05 for one in tails] == [mm >= 3 for mm in CHI_SQUARES_2])  # fmt: skip


def skin(steps, seed):
    """Tests equations 5, 15 and 16: how a finger relaxes, and how much of a ridge remains."""
    steps.near("finger 1.8 s after a ridge (Table 6)", TABLE_6, np.exp(-1.8 / TABLE_5[:, 4]), 6e-3, "{:.2f}")
    creep = lambda t_s, strain_s, stress_s: 1 - (1 - strain_s / stress_s) * np.exp(-t_s / stress_s)
    kept = [(creep(4.8, *both) - creep(1.8, *both)) / creep(3.0, *both) for both in TABLE_5[:, 3:]]
    steps.add("the same by a whole Kelvin body (eq. 5)", "Table 6", span(kept, unit=""), "Table 6 keeps the slow part of the creep alone")
    steps.near("last column by A and B (Table 5)", TABLE_5[:, 4], TABLE_5[:, 3] * (1 + TABLE_5[:, 1] / TABLE_5[:, 0]), 0.02, "{:.2f}", unit=" s")
    wrong = [n + 1 for n, row in enumerate(TABLE_5) if abs(1 / row[2] - row[3]) > 0.06]
    steps.add("1 / c is the relaxation time (Table 5)", "six subjects", f"not of subject {wrong}", "**contradicts itself**; Table 6 bears out the time", holds=wrong == [3])
    rng, t_s, worst = np.random.default_rng(seed), np.arange(1500) / 100, 0.0
    relaxing = lambda t, a, b, c: a + b * np.exp(-c * t)
    for truth in TABLE_5[:, :3]:
        force = relaxing(t_s, *truth) + 0.02 * rng.standard_normal(len(t_s))
        found, covariance = curve_fit(relaxing, t_s, force, [force[-1], force[0] - force[-1], 0.3])
        worst = max(worst, np.max(np.abs(found - truth) / np.sqrt(np.diag(covariance))))
    steps.add("A, B, c from forces made of them, 15 s (eq. 15, 16)", "six subjects", f"within {worst:.1f} sigma", "SciPy `curve_fit`", holds=worst < 4)


# Half plane. Compression is positive, stresses are per newton per millimetre of the line, strains
# times Young's modulus.


def normal(x, z):
    """Returns pressure, shear and strain under a normal line load on thin slices (eq. 1 to 3)."""
    r4 = np.square(x * x + z * z)
    sz, sx, sxz = z**3 / r4, x * x * z / r4, x * z * z / r4
    return 2 / np.pi * sz, 2 / np.pi * sxz, 2 / np.pi * (sz - POISSON * sx)


def tangential(x, z):
    """Returns pressure, shear and strain under a line load along the surface."""
    r4 = np.square(x * x + z * z)
    sz, sx, sxz = x * z * z / r4, x**3 / r4, x * x * z / r4
    return 2 / np.pi * sz, 2 / np.pi * sxz, 2 / np.pi * (sz - POISSON * sx)


class Grid:
    """Positions on a long line, and convolution along it."""

    def __init__(self, step, count=1 << 17):
        self.step, self.count = step, count
        self.x = (np.arange(count) - count // 2) * step

    def through(self, profile, kernel):
        return np.fft.irfft(np.fft.rfft(profile) * np.fft.rfft(np.fft.ifftshift(kernel)), self.count) * self.step


def decibels(signal, made):
    return 10 * np.log10(np.square(signal).sum() / np.square(made - signal).sum())


def table_1(contact, degrees):
    """Simulates two layers of 2 mm. Without shear, only the pressure crosses the interface."""
    # Under an oblique load, strain decays as 1 / x, so the line is 13 m long.
    grid, angle = Grid(0.1), math.radians(degrees)
    inside = np.clip(1 - np.square(grid.x / 10), 0, None)
    profile = {"line": grid.x == 0, "block": inside > 0, "cylinder": np.sqrt(inside)}[contact].astype(float)
    profile /= profile.sum() * grid.step
    deep, mid = ([math.cos(angle) * grid.through(profile, n) + math.sin(angle) * grid.through(profile, t)
                  for n, t in zip(normal(grid.x, z), tangential(grid.x, z), strict=True)] for z in (4, 2))  # fmt: skip
    return decibels(deep[2], grid.through(mid[0], normal(grid.x, 2)[2]))


SHAPES = {
    "line loads": lambda x: x == 0,
    "pins of half the spacing": lambda x: (x >= -0.25) & (x < 0.25),
    "pins of the whole spacing": lambda x: (x >= -0.5) & (x < 0.5),
    "straight lines": lambda x: np.clip(1 - np.abs(x), 0, None),
    "ideal low-pass": np.sinc,
}
PER_SPACING = 32


def figure_16(ratio, name, has_shear, phases=range(0, PER_SPACING // 2 + 1, 4)):
    """Returns decibels at the worst phase of sampling between two layers of 1 mm."""
    grid = Grid(ratio / PER_SPACING)
    pressure, shear, _ = normal(grid.x, 1)
    signal, by_pressure, by_shear = normal(grid.x, 2)[2], normal(grid.x, 1)[2], tangential(grid.x, 1)[2]
    shape = SHAPES[name](grid.x / ratio).astype(float)
    shape /= shape.sum() * grid.step
    worst = math.inf
    for phase in phases:
        # Each sample represents one spacing of the profile.
        at = ((np.arange(grid.count) - grid.count // 2 - phase) % PER_SPACING == 0) * PER_SPACING
        made = grid.through(grid.through(at * pressure, shape), by_pressure)
        if has_shear:
            made = made + grid.through(grid.through(at * shear, shape), by_shear)
        worst = min(worst, decibels(signal, made))
    return worst


def crossing(name):
    """Returns the ratio of spacing to thickness from which shear does not help."""
    gain = lambda ratio: figure_16(ratio, name, True) - figure_16(ratio, name, False)
    above = 0.5
    while gain(above) > 0:
        above += 0.25
    return brentq(gain, above - 0.25, above, xtol=5e-3)


def layers(steps, short):
    """Adds the rows that depend on shear and on samples between two layers."""
    found = [table_1(contact, degrees) for contact in TABLE_1 for degrees in (0, 30)]
    printed = [one for pair in TABLE_1.values() for one in pair]
    steps.near("signal over noise without shear: line, block, cylinder at 0 and 30 degrees (Table 1)", printed, found, 0.5, "{:.2f}", unit=" dB")
    names = list(SHAPES)[:2] if short else SHAPES
    limits, crossings = [figure_16(0.05, name, False) for name in names], [crossing(name) for name in names]
    steps.near("worst phase without shear, dense samples (Figure 16)", [16], [min(limits)], 0.2, "{:.1f}", unit=" dB")
    close = sum(abs(one - 1) <= 0.1 for one in crossings)
    steps.add("shear is of no use from a spacing over the layer of (Figure 16)", "1", span(crossings, unit="") + f" by {len(crossings)} ways", f"**{close} of {len(crossings)} within 10 %**; the paper does not say by which")
    quarter = [[figure_16(2, name, has_shear, [PER_SPACING // 4]) for has_shear in (True, False)] for name in ("straight lines", "line loads")]
    steps.add("samples two layers apart, a quarter off the load: straight lines; line loads (Figures 13, 14)", "pictures", "; ".join(f"{a:.1f} dB, without shear {b:.1f}" for a, b in quarter), "shear does harm")
    grid = Grid(0.1)
    line = (grid.x == 0) / grid.step

    def measures(parts):
        sz, sxz, ez = parts
        sx = (sz - ez) / POISSON
        ex, half = sx - POISSON * sz, (1 + POISSON) * sxz
        return ez, (ez + ex) / 2 + np.hypot((ez - ex) / 2, half), (sz * ez + sx * ex + 2 * sxz * half) / 2

    whole = measures([grid.through(line, part) for part in normal(grid.x, 4)])
    pressure = grid.through(line, normal(grid.x, 2)[0])
    own = [decibels(*pair) for pair in zip(whole, measures([grid.through(pressure, part) for part in normal(grid.x, 2)]), strict=True)]
    steps.add("the line by normal strain, greatest compressive strain, energy (section 2.6)", "16 dB; -; -", "; ".join(f"{one:.1f} dB" for one in own), "as printed", holds=abs(own[0] - 15.9) < 0.1)


# Gratings: appendix, equations 17 to 21. Where there is contact, the deflection is given; elsewhere
# there is no pressure, and pressures that would pull are set to 0. The paper's order, inverting
# everywhere and then clipping, would depend on the grid.

CELL_MM, REACH_MM = 0.05, 3.0


def pressure_under(height_mm):
    """Returns pressure over Young's modulus in the cells of a period. A height of NaN means no
    contact."""
    count = len(height_mm)
    times = int(REACH_MM / (count * CELL_MM)) + 1
    x_mm = np.abs((np.arange(count) + count * np.arange(-times, times + 1)[:, None]) * CELL_MM).clip(CELL_MM / 2)
    deflection = np.where(x_mm < REACH_MM, 2 / np.pi * np.log(REACH_MM / x_mm), 0).sum(0)
    touched = np.flatnonzero(np.isfinite(height_mm))
    pressure = np.zeros(count)
    pressure[touched] = solve(deflection[np.abs(touched[:, None] - touched)], height_mm[touched]) / CELL_MM
    return pressure.clip(0)


def ridges(period_mm):
    """Returns a grating of half ridges that indents by 2 mm."""
    count = round(period_mm / CELL_MM)
    return np.where(np.arange(count) < count // 2, 2.0, np.nan)


def pins(spacing_mm, number, error):
    """Returns pins half as wide as their spacing and 1 mm high, off by a cosine over `number`
    pins: the worst case of a resolution."""
    count = round(spacing_mm / CELL_MM)
    n = np.arange(number * count)
    return np.where(n % count < count // 2, 1 + error * np.cos(2 * np.pi * (n // count) / number), np.nan)


def index(pressure, transfer):
    """Equations 13 and 14: returns the amplitude of the fundamental at a depth over the mean."""
    first = 2 / len(pressure) * abs(np.fft.rfft(pressure)[1])
    return first * abs(transfer(2 * np.pi / (len(pressure) * CELL_MM))) / (pressure.mean() * transfer(0.0))


def stress(z_mm):
    return lambda k: (1 + k * z_mm) * np.exp(-k * z_mm)


def strain(z_mm):
    return lambda k: (1 + k * z_mm - POISSON * (1 - k * z_mm)) * np.exp(-k * z_mm)


def gratings(steps):
    """Tests figures 17 to 19 and 22, and the rule of section 5."""
    of = {mm: pressure_under(ridges(mm)) for mm in (2.4, 3.4, 3.6, 4.0, 4.8)}
    at_4 = of[4.0].mean() * strain(2.7)(0.0), index(of[4.0], strain(2.7))
    steps.near("grating of 4 mm: mean strain, index (Figure 17)", [0.22, 0.18], at_4, 0.02, "{:.3f}")
    felt = [index(of[mm], strain(2.7)) for mm in (3.4, 3.6)]
    steps.add("index where people just notice, 3.4 to 3.6 mm (Figure 18, Table 8)", "0.10 to 0.15", span(felt, 3, ""), "as printed", holds=0.10 <= felt[0] <= felt[1] <= 0.15)
    pairs = [(index(p, strain(2.7)) / index(p, lambda k: stress(1.0)(k) * strain(1.7)(k)), index(p, stress(2.0)) / index(p, lambda k: stress(1.0)(k) ** 2)) for p in of.values()]
    ratios = np.array(pairs)
    steps.add("index with shear over without: strain; stress (Figures 18, 19)", "below 1", f"{span(ratios[:, 0], unit='')}; {span(ratios[:, 1], unit='')}", "as printed", holds=ratios.max() < 1)
    by = {number: index(pressure_under(pins(2.0, number, 0.1)), stress(2.0)) for number in (2, 3, 4, 5)}
    worst = max(by.values())
    steps.add("error of 10 % from pin to pin, 2 mm apart under 2 mm: index at 4 mm; worst to 10 mm (Figure 22)", "about 0.06; below 0.1", f"{by[2]:.3f}; {worst:.3f}", "as printed", holds=abs(by[2] - 0.06) < 0.01 and worst < 0.1)
    steps.add("coarsest resolution that is not noticed (section 5)", "10 %", f"{10 * 0.1 / worst:.1f} %", "10 % has room", holds=10 * 0.1 / worst > 10)


def block(steps):
    """Tests figure 8: strains under a block 4 mm wide and 1.5 mm deep, by 11 pins 1 mm apart."""
    sensors, at = np.linspace(-5, 5, 101), np.linspace(-5, 5, 11)
    loads = (np.arange(200) + 0.5) / 50 - 2
    wanted = normal(sensors[:, None] - loads, 1.5)[2].sum(1) / 50
    a = normal(sensors[:, None] - at, 1.5)[2]
    error = lambda forces: 100 * np.linalg.norm(a @ forces - wanted) / np.linalg.norm(wanted)
    free, pressing = np.linalg.lstsq(a, wanted, rcond=None)[0], nnls(a, wanted)[0]
    steps.add("rms error of matched strain: any sign; pressing (eq. 9 to 11, Figure 8)", "good", f"{error(free):.2f} %; {error(pressing):.2f} %", "as printed", holds=error(pressing) < 5 and abs(free.sum() - 4) < 0.1)


# Displays of rows and columns.


def half_space(x, y, z, poisson=POISSON):
    """Boussinesq: returns pressures along x, y and z under 1 N on a half space, and the strain
    along z times Young's modulus."""
    r2 = x * x + y * y
    big = np.sqrt(r2 + z * z)
    along, across = 3 * z / big**5, []
    for own, other in ((x, y), (y, x)):
        flat = (1 - 2 * poisson) / np.where(r2 == 0, 1, r2) * ((own * own - other * other) / (big * (big + z)) + other * other * z / big**3)
        flat = np.where(r2 == 0, (1 - 2 * poisson) / (2 * z * z), flat)
        across.append((along * own * own - flat) / (2 * np.pi))
    sz = along * z * z / (2 * np.pi)
    return sz, sz - poisson * (across[0] + across[1])


def slices(x, y, z):
    """Returns the strain of thin slices. Along a line, a half space is in plane strain;
    replacing p by p / (1 + p) makes it plane stress with p."""
    return half_space(x, y, z, POISSON / (1 + POISSON))[1] * (1 + POISSON) ** 2 / (1 + 2 * POISSON)


KINDS = {"strain": slices, "half-space": lambda *at: half_space(*at)[1], "stress": lambda *at: half_space(*at)[0]}
DEPTH_MM, MODULUS_MPA, SENSOR_PITCH_MM, REGULARISATION = 2.0, 1.7, 1.15, 0.01


def grid(columns, rows, spacing_mm):
    """Returns positions row by row, around the middle."""
    x, y = (spacing_mm * (np.arange(count) - (count - 1) / 2) for count in (columns, rows))
    return np.tile(x, rows), np.repeat(y, columns)


def responses(kind, sensors, loads):
    (x, y), (a, b) = sensors, loads
    return KINDS[kind](x[:, None] - a, y[:, None] - b, DEPTH_MM)


def forces(a, wanted, regularisation):
    """Returns forces of at least 0 whose strains are nearest to the wanted ones, with a penalty
    on their squares."""
    penalty = math.sqrt(regularisation * np.square(a).sum() / a.shape[1])
    return nnls(np.vstack([a, penalty * np.eye(a.shape[1])]), np.concatenate([wanted, np.zeros(a.shape[1])]))[0]


def rows_of_pins(steps, short):
    """Tests a display of rows and columns, and the command's results for it."""
    x, y = grid(100, 100, 2.0)
    offsets = (np.arange(8) + 0.5) / 4 - 1
    evens = {kind: 4 * np.mean([of(x - dx, y - dy, DEPTH_MM).sum() for dx in offsets for dy in offsets]) for kind, of in KINDS.items()}
    steps.add("strain under an even pressure: slices; half space; pressure (eq. 3)", "0.5; -; 1", "; ".join(f"{one:.2f}" for one in evens.values()), "as printed, 200 mm wide",
              holds=np.allclose(list(evens.values()), [0.5, 0, 1], atol=0.03))  # fmt: skip
    columns = grid(2, 50, 1.25)
    middle = {kind: forces(responses(kind, columns, columns), np.full(100, 0.5 / 1.25**2), 0.001)[50] for kind in ("strain", "half-space")}
    z, apart = DEPTH_MM, np.array([0, 1.25])
    line = (2 * z * (z * z - POISSON * apart * apart) / (np.pi * (apart * apart + z * z) ** 2)).sum()
    by_line = 0.5 / 1.25**2 / line * 1.25
    steps.add("force of an even touch on two columns of pins, over that of line loads: slices; half space (eq. 9 to 11)", "1; -", "; ".join(f"{one / by_line:.2f}" for one in middle.values()), "as printed", holds=abs(middle["strain"] / by_line - 1) < 0.01)
    built = os.environ.get("RIDGETONE_TELETACTION")
    command = [built] if built else ["cargo", "run", "--quiet", "--release", "-p", "ridgetone-teletaction", "--"]
    worst, off = 0.0, 0.0
    for kind, count, spacing_mm in (("strain", 4, 2.0), ("half-space", 4, 2.0), ("strain", 8, 1.0))[: 1 if short else 3]:
        words = [*command, "pins", "--emulated", "--once", "--pace", "0", "--json", "--by", kind, "--pins", f"{count}x{count}", "--spacing-mm", str(spacing_mm)]
        done = subprocess.run(words, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
        update = next(one for line in done.stdout.splitlines() if (one := json.loads(line))["t_s"] > 1.4)
        own, felt, sensor = (np.array(update[name]) for name in ("forces_n", "felt_strain", "sensor_strain"))
        a = responses(kind, grid(4, 4, SENSOR_PITCH_MM), grid(count, count, spacing_mm))
        off = max(off, np.abs(a @ own / MODULUS_MPA - felt).max() / felt.max())
        worst = max(worst, np.abs(forces(a, MODULUS_MPA * sensor, REGULARISATION) - own).max() / update["level_n"])
    steps.add("strains under the forces of `pins`; its forces beside the best that press (eq. 9 to 11)", "-", f"within {off:.0e}; {worst:.2f} of a step of force", "the same", "`ridgetone-teletaction pins`", off < 1e-5 and worst <= 1)


def textures(steps):
    """Computes a texture from a recording at a known speed, as played by a stylus."""
    rng, rate_hz, speed_mm_s = np.random.default_rng(2), 500, (30.0, 0.03)
    turns = 20 * np.arange(1000)[:, None] / rate_hz + 0.07 * np.arange(16)
    gain = 1 + 0.1 * np.arange(16)
    values = gain * (np.sin(2 * np.pi * turns) + 0.3 * np.sin(2 * np.pi * (2 * turns + 0.1))) + 3e-4 * rng.standard_normal((1000, 16))
    found = rt.fit(values, rate_hz)
    period_mm = speed_mm_s[0] / found.frequency_hz
    sigma_mm = period_mm * math.hypot(speed_mm_s[1] / speed_mm_s[0], found.sigma_hz / found.frequency_hz)
    # Ratio of the second harmonic's amplitude to the first's, by least squares at the frequency
    # found.
    angles = 2 * np.pi * found.frequency_hz * np.arange(1000)[:, None] / rate_hz * np.arange(1, 5)
    basis = np.hstack([np.cos(angles), np.sin(angles), np.ones((1000, 1))])
    parts = np.linalg.lstsq(basis, values, rcond=None)[0]
    first, second = (parts[h] - 1j * parts[4 + h] for h in (0, 1))
    # Phase of the harmonic relative to twice that of the fundamental, both as sines.
    overtone = (np.abs(first) * second * np.exp(-2j * np.angle(first)) * -1j).sum() / np.square(np.abs(first)).sum()
    power = np.square(np.abs(first)).mean() / 2
    steps.add("texture from a recording at 30.00 +- 0.03 mm/s: period; overtone; power", "1.5 mm; 0.3 at 0.1 turns; -",
              f"{period_mm:.4f} +- {sigma_mm:.4f} mm; {abs(overtone):.3f} at {np.angle(overtone) / (2 * np.pi) % 1:.3f} turns; {power:.3f}", "put in; the period is no surer than the speed", "`fit`",
              abs(period_mm - 1.5) < 3 * sigma_mm and abs(abs(overtone) - 0.3) < 2e-3 and abs(power / (np.square(gain).mean() / 2) - 1) < 2e-3)  # fmt: skip
