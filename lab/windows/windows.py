"""Time `ridgetone fit --window` on a long recording beside the same fits in SciPy and NumPy.

The recording is made in a temporary folder, which is removed again. Run it as

    python lab/windows/windows.py --command target/release/ridgetone

It needs numpy and scipy, and 1.4 GB of room for ten million rows.
"""

import argparse
import os
import platform
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

# One thread for each process: the processes share the cores.
for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np
from scipy.optimize import curve_fit

CHANNELS = 16
TONE_HZ = 12.34
NOISE = 0.1
WINDOW_S, STRIDE_S = 1.0, 0.25
# A block that is repeated holds whole cycles of the tone.
BLOCK_S = 100


def block(rate_hz, seed=1):
    """Readings of a block: row by channel, each channel with its phase, amplitude and level."""
    random = np.random.default_rng(seed)
    t_s = np.arange(int(BLOCK_S * rate_hz)) / rate_hz
    turns = TONE_HZ * t_s[:, None] + random.uniform(0, 1, CHANNELS)
    tone = random.uniform(0.5, 1.5, CHANNELS) * np.sin(2 * np.pi * turns)
    level = random.uniform(-2, 2, CHANNELS)
    return level + tone + NOISE * random.standard_normal(tone.shape)


def write(path, rate_hz, rows):
    """Writes a recording with a stamp for each row."""
    lines = ["," + ",".join(f"{value:.4f}" for value in row) + "\n" for row in block(rate_hz)]
    with open(path, "w") as file:
        file.write("time_s," + ",".join(f"ch{n}" for n in range(CHANNELS)) + "\n")
        for first in range(0, rows, len(lines)):
            numbers = range(first, min(first + len(lines), rows))
            file.write("".join(f"{n / rate_hz:.6f}{line}" for n, line in zip(numbers, lines)))


def run_fit(command, path, table):
    """Runs the command. Gives its wall time, processor time and most memory."""
    options = ["--window", str(WINDOW_S), "--stride", str(STRIDE_S), "-o", str(table), "--force"]
    begin_s = time.perf_counter()
    child = subprocess.Popen([command, "fit", str(path), *options], stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    wall_s = time.perf_counter() - begin_s
    if status != 0:
        sys.exit(f"{command} fit {path}: status {status}")
    # Kilobytes on Linux, bytes on macOS.
    memory_mb = usage.ru_maxrss / (1e6 if platform.system() == "Darwin" else 1e3)
    return wall_s, usage.ru_utime + usage.ru_stime, memory_mb


def errors(table):
    """Windows of a table, the share that is good, and the rms of error over sigma of these."""
    with open(table) as file:
        names = file.readline().strip().split(",")
        status, hz, sigma = (names.index(name) for name in ("status", "frequency_hz", "sigma_hz"))
        cells = [line.rstrip("\n").split(",") for line in file]
    good = [(float(row[hz]), float(row[sigma])) for row in cells if row[status] == "good"]
    scaled = [(found - TONE_HZ) / sigma for found, sigma in good]
    return len(cells), len(good) / len(cells), np.sqrt(np.mean(np.square(scaled)))


def peak_hz(readings, rate_hz):
    """The strongest line of the channels' spectra, four times padded."""
    centred = readings - readings.mean(axis=0)
    size = 4 * len(readings)
    power = (np.abs(np.fft.rfft(centred, size, axis=0)) ** 2).sum(axis=1)
    return (1 + np.argmax(power[1:])) * rate_hz / size


def by_curve_fit(readings, rate_hz):
    """One frequency, and sine, cosine and level of each channel, by `curve_fit`."""
    t_s = np.arange(len(readings)) / rate_hz

    def model(_, hz, *linear):
        angle = 2 * np.pi * hz * t_s
        basis = np.stack([np.sin(angle), np.cos(angle), np.ones_like(angle)])
        return (np.reshape(linear, (CHANNELS, 3)) @ basis).ravel()

    first = np.stack([np.ones(CHANNELS), np.ones(CHANNELS), readings.mean(axis=0)], axis=1)
    start = [peak_hz(readings, rate_hz), *first.ravel()]
    found, _ = curve_fit(model, None, readings.T.ravel(), start)
    return found[0]


def by_nls(readings, rate_hz):
    """Nonlinear least squares: the linear part solved at each frequency, which is refined."""
    t_s = (np.arange(len(readings)) - (len(readings) - 1) / 2) / rate_hz

    def left(hz):
        angle = 2 * np.pi * hz * t_s
        basis = np.stack([np.sin(angle), np.cos(angle), np.ones_like(angle)], axis=1)
        q, _ = np.linalg.qr(basis)
        return -np.square(q.T @ readings).sum()

    # Parabolas through three frequencies, ever closer.
    hz, step_hz = peak_hz(readings, rate_hz), 0.1 / WINDOW_S
    for _ in range(4):
        below, here, above = left(hz - step_hz), left(hz), left(hz + step_hz)
        bend = below - 2 * here + above
        if bend > 0:
            hz += np.clip(0.5 * step_hz * (below - above) / bend, -step_hz, step_hz)
        step_hz *= 0.3
    return hz


def fit_some(method, rate_hz, first, windows):
    """Fits windows of the block, beginning with one of them."""
    readings = block(rate_hz)
    length, stride = round(WINDOW_S * rate_hz), STRIDE_S * rate_hz
    starts = [round((first + n) * stride) % (len(readings) - length) for n in range(windows)]
    begin_s, begin_cpu_s = time.perf_counter(), time.process_time()
    found = [method(readings[start : start + length], rate_hz) for start in starts]
    wall_s, cpu_s = time.perf_counter() - begin_s, time.process_time() - begin_cpu_s
    return wall_s, cpu_s, np.square(np.subtract(found, TONE_HZ)).tolist()


def compare(method, rate_hz, windows, cores):
    """Times a method, a process for each core."""
    share = windows // cores
    with ProcessPoolExecutor(cores) as pool:
        jobs = [pool.submit(fit_some, method, rate_hz, n * share, share) for n in range(cores)]
        done = [job.result() for job in jobs]
    wall_s = max(wall_s for wall_s, _, _ in done)
    cpu_s = sum(cpu_s for _, cpu_s, _ in done)
    squares = np.concatenate([squares for _, _, squares in done])
    return wall_s, cpu_s, cores * share, np.sqrt(squares.mean())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--command", default="ridgetone", help="the command to time")
    parser.add_argument("--rows", type=int, default=10_000_000)
    parser.add_argument("--windows", type=int, default=200, help="windows of the other methods")
    arguments = parser.parse_args()
    cores = os.cpu_count() or 1
    print(f"{arguments.rows} rows of {CHANNELS} channels, {cores} cores, load {os.getloadavg()[0]:.1f}")
    print("| rows a second | method | windows | by the clock | by processor time | check |")
    print("|---:|---|---:|---:|---:|---|")
    for rate_hz in (241, 1000):
        def line(method, windows, wall_s, cpu_s, check):
            fitted_s = STRIDE_S * windows
            print(
                f"| {rate_hz} | {method} | {windows} | {fitted_s / wall_s:.0f} x "
                f"| {cores * fitted_s / cpu_s:.0f} x | {check} |",
                flush=True,
            )

        for rows in (arguments.rows // 10, arguments.rows):
            with tempfile.TemporaryDirectory() as folder:
                path, table = Path(folder, "recording.csv"), Path(folder, "table.csv")
                write(path, rate_hz, rows)
                wall_s, cpu_s, memory_mb = run_fit(arguments.command, path, table)
                windows, good, scaled = errors(table)
            check = f"{memory_mb:.0f} MB at most, {100 * good:.1f} % good, error {scaled:.2f} sigma"
            line(f"`fit`, {rows:,} rows", windows, wall_s, cpu_s, check)
        for name, method in (("SciPy `curve_fit`", by_curve_fit), ("NumPy, harmonic NLS", by_nls)):
            wall_s, cpu_s, windows, rms_hz = compare(method, rate_hz, arguments.windows, cores)
            line(name, windows, wall_s, cpu_s, f"error {1e3 * rms_hz:.2f} mHz rms")


if __name__ == "__main__":
    main()
