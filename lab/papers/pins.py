"""Teletaction: the strains of a display of several rows, beside the command `ridgetone pins`."""

import json
import subprocess

import numpy as np

MODULUS_MPA, POISSON, DEPTH_MM = 1.7, 0.5, 2.0
SENSOR_PITCH_MM, REGULARISATION = 1.15, 0.01


def stress_tensor(x, y, z, poisson):
    """Boussinesq: pressures along x, y and z under 1 N on a half space, with their signs for compression."""
    r2 = x * x + y * y
    big = np.sqrt(r2 + z * z)
    along = 3 * z / big**5
    free = (1 - 2 * poisson) / np.where(r2 == 0, 1, r2)
    across = []
    for own, other in ((x, y), (y, x)):
        side = own * own - other * other
        flat = free * (side / (big * np.where(big + z == 0, 1, big + z)) + other * other * z / big**3)
        flat = np.where(r2 == 0, (1 - 2 * poisson) / (2 * z * z), flat)
        across.append((along * own * own - flat) / (2 * np.pi))
    return across[0], across[1], along * z * z / (2 * np.pi)


def half_space(x, y, z):
    """Strain along z times Young's modulus by Hooke's law."""
    sx, sy, sz = stress_tensor(x, y, z, POISSON)
    return sz - POISSON * (sx + sy)


def slices(x, y, z):
    """Strain of thin slices: what a line of points adds up to is the paper's line load in plane stress.

    Along a line a half space is in plane strain: eps = (1 - n^2) sz - n (1 + n) sx. With n = p / (1 + p) that is
    (1 + 2 p) / (1 + p)^2 (sz - p sx), plane stress with p.
    """
    other = POISSON / (1 + POISSON)
    sx, sy, sz = stress_tensor(x, y, z, other)
    return (sz - other * (sx + sy)) * (1 + POISSON) ** 2 / (1 + 2 * POISSON)


def pressure(x, y, z):
    return stress_tensor(x, y, z, POISSON)[2]


KINDS = {"strain": slices, "half-space": half_space, "stress": pressure}


def grid(columns, rows, spacing_mm):
    """Places row by row around the middle."""
    x, y = (spacing_mm * (np.arange(count) - (count - 1) / 2) for count in (columns, rows))
    return np.tile(x, rows), np.repeat(y, columns)


def responses(kind, sensors, pins):
    (x, y), (a, b) = sensors, pins
    return KINDS[kind](x[:, None] - a, y[:, None] - b, DEPTH_MM)


def under_even_pressure(kind, count):
    """E times the strain under a pin in the middle; each of count x count pins 2 mm apart presses by 1 N."""
    x, y = grid(count, count, 2.0)
    middle = np.argmin(np.hypot(x, y))
    return KINDS[kind](x - x[middle], y - y[middle], DEPTH_MM).sum()


def even(kind):
    """The same over an even pressure, the mean over a pin's place: of 100 x 100 pins, over the pressure."""
    x, y = grid(100, 100, 2.0)
    offsets = (np.arange(8) + 0.5) / 4 - 1
    sums = [KINDS[kind](x - dx, y - dy, DEPTH_MM).sum() for dx in offsets for dy in offsets]
    return 4 * np.mean(sums)


def pressing(a, wanted, constant):
    """Forces of at least 0 with the least |a f - wanted|^2 + constant |f|^2: pins that pull are taken out one by one."""
    free = np.ones(a.shape[1], bool)
    products, along = a.T @ a + constant * np.eye(a.shape[1]), a.T @ wanted
    for _ in range(10 * len(free)):
        forces = np.zeros(len(free))
        forces[free] = np.linalg.solve(products[np.ix_(free, free)], along[free])
        slope = along - products @ forces
        if free.any() and forces.min() < -1e-12:
            free[np.argmin(forces)] = False
        elif (slope[~free] > 1e-12).any():
            free[np.argmax(np.where(free, -np.inf, slope))] = True
        else:
            break
    return forces


def long_columns(kind):
    """Force in the middle of two columns of 50 pins, 1.25 mm apart, that an even strain takes."""
    pins = grid(2, 50, 1.25)
    a = responses(kind, pins, pins)
    wanted = np.full(100, 0.5 / 1.25**2)
    return pressing(a, wanted, 0.001 * np.square(a).sum() / 100)[50]


def by_line_loads():
    """The same by equations 1 and 3: two line loads, each under its own sensor, that share the strain."""
    z, x = DEPTH_MM, np.array([0, 1.25])
    line = 2 * z * (z * z - POISSON * x * x) / (np.pi * (x * x + z * z) ** 2)
    return 0.5 / 1.25**2 / line.sum() * 1.25


def updates(command, kind, columns, spacing_mm):
    words = ["pins", "--emulated", "--once", "--pace", "0", "--json", "--by", kind]
    words += ["--pins", f"{columns}x{columns}", "--spacing-mm", str(spacing_mm)]
    done = subprocess.run([command, *words], capture_output=True, text=True, check=True)
    return [json.loads(line) for line in done.stdout.splitlines()]



def rows(checks, command):
    """What a display of rows and columns does, and the command's own figures."""
    for count, printed in ((1, 0.119), (4, 0.148), (10, 0.084), (40, 0.036)):
        what = f"S4: half space, {count} x {count} pins of 1 N, E times the strain under one, N/mm^2"
        checks.near(what, printed, under_even_pressure("half-space", count), 6e-4)
    evens = {kind: even(kind) for kind in KINDS}
    checks.near("S4: an even pressure strains slices by 1 - 0.5 of it", 0.5, evens["strain"], 0.02)
    checks.near("S4: and a half space by nothing", 0, evens["half-space"], 0.03)
    checks.near("S4: and the pressure itself is", 1, evens["stress"], 0.02)
    line_n, slices_n, half_space_n = by_line_loads(), long_columns("strain"), long_columns("half-space")
    checks.near("S4: an even touch on two columns, slices over the paper's line loads", 1, slices_n / line_n, 0.01)
    checks.true("S4: the same, a half space", f"{half_space_n / line_n:.2f}", half_space_n > 1.3 * line_n)
    for kind, columns, spacing_mm in (("strain", 4, 2.0), ("half-space", 4, 2.0), ("strain", 8, 1.0)):
        beside(checks, command, kind, columns, spacing_mm)
    checks.step("teletaction", "rows of pins: strain under an even pressure, slices; half space", "eq. 3", "0.5; -", f"{evens['strain']:.2f}; {evens['half-space']:.2f}", "NumPy, 200 mm wide; `pins --by` gives its strains and forces")
    checks.step("teletaction", "force of an even touch on two columns of pins, over that of line loads", "eq. 9 to 11", "1", f"{slices_n / line_n:.2f}; half space {half_space_n / line_n:.1f}", "test, NumPy")


def beside(checks, command, kind, columns, spacing_mm):
    """The command's update at the end of the hold: its strains, and the best forces for the sensor's."""
    update = next(one for one in updates(command, kind, columns, spacing_mm) if one["t_s"] > 1.4)
    forces = np.array(update["forces_n"])
    a = responses(kind, grid(4, 4, SENSOR_PITCH_MM), grid(columns, columns, spacing_mm))
    felt, sensor = (np.array(update[name]) for name in ("felt_strain", "sensor_strain"))
    off = np.abs(a @ forces / MODULUS_MPA - felt).max() / felt.max()
    checks.true(f"S4: `pins --by {kind}`, {columns} x {columns}: felt strain by its forces", f"within {off:.0e}", off < 1e-5)
    best = pressing(a, MODULUS_MPA * sensor, REGULARISATION * np.square(a).sum() / a.shape[1])
    worst = np.abs(best - forces).max()
    checks.true(f"S4: the same, its forces are the best that press, {forces.sum():.2f} N in all", f"within {worst:.4f} N", worst <= update["level_n"])
