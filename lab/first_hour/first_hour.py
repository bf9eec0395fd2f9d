"""Time the way from nothing to a first result: the command on a table, and Python to a picture.

Each way has a clone, a folder of crates, a target directory and a Python environment of its own, all empty,
in a temporary folder that is removed again. Run it as

    python lab/first_hour/first_hour.py

It needs git, Rust, a network, and 3 GB of room.
"""

import argparse
import json
import math
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

TONE_HZ = 12.34
# What the builds of a checkout that is worked on may be told, and those of a newcomer are not.
BUILD_SETTINGS = ("RUSTC_WRAPPER", "RUSTFLAGS", "CARGO_BUILD_JOBS", "CARGO_TARGET_DIR")

PLOT = """
import numpy as np
import ridgetone as rt

t = np.arange(1000) / 250
array = np.c_[np.sin(50 * t), 3 * np.cos(50 * t) + 1]
found = rt.fit(array, rate_hz=250)
assert found.status == "good" and abs(2 * np.pi * found.frequency_hz - 50) < 1e-3, found
open("fit.svg", "w").write(str(rt.picture(found)))
"""


def foreign_table(path):
    """Writes a table as a logger in a country with decimal commas does."""
    lines = ["Logger;X4", "Start;26.11.2026 09:30", "", "Zeit (ms);Kraft 1 (N);Kraft 2 (N)"]
    for row in range(1000):
        angle = 2 * math.pi * TONE_HZ * row / 250
        values = (4 * row, 1.5 + math.sin(angle), 0.4 * math.cos(angle) - 0.2)
        lines.append(";".join(f"{value:.4f}".replace(".", ",") for value in values))
    path.write_text("\r\n".join(lines), encoding="latin-1")


class Way:
    """Steps that are timed one after the other, in an environment of their own."""

    def __init__(self, name, folder):
        self.name, self.folder = name, Path(folder)
        kept = {key: value for key, value in os.environ.items() if key not in BUILD_SETTINGS}
        self.environment = kept | {"CARGO_HOME": str(self.folder / "cargo")}
        self.wall_s = self.cpu_s = 0.0

    def step(self, shown, command):
        """Runs a command, prints its times, and gives what it printed."""
        before, begin_s = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        done = subprocess.run(
            command, cwd=self.folder, env=self.environment, capture_output=True, text=True
        )
        wall_s, after = time.perf_counter() - begin_s, resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode != 0:
            sys.exit(f"{shown}: status {done.returncode}\n{done.stderr}")
        cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        self.wall_s, self.cpu_s = self.wall_s + wall_s, self.cpu_s + cpu_s
        self.line(f"`{shown}`", wall_s, cpu_s)
        return done.stdout

    def total(self):
        self.line("together", self.wall_s, self.cpu_s)

    def line(self, step, wall_s, cpu_s):
        print(f"| {self.name} | {step} | {wall_s:.1f} s | {cpu_s:.1f} s |", flush=True)


def command_way(source):
    """From `git clone` to the first fit of a table."""
    with tempfile.TemporaryDirectory() as folder:
        way = Way("command", folder)
        way.step("git clone", ["git", "clone", "--quiet", source, "ridgetone"])
        install = ["cargo", "install", "--quiet", "--path", "ridgetone/host", "--root", "installed"]
        way.step("cargo install --path host", install)
        foreign_table(way.folder / "recording.csv")
        fit = ["installed/bin/ridgetone", "fit", "recording.csv", "--json"]
        found = json.loads(way.step("ridgetone fit recording.csv", fit))
        if found["status"] != "good" or abs(found["frequency_hz"] - TONE_HZ) > 1e-3:
            sys.exit(f"the fit is wrong: {found}")
        way.total()


def python_way(source):
    """From `git clone` to the first picture of a fit in Python."""
    with tempfile.TemporaryDirectory() as folder:
        way = Way("Python", folder)
        way.step("git clone", ["git", "clone", "--quiet", source, "ridgetone"])
        way.step("python -m venv", [sys.executable, "-m", "venv", "venv"])
        pip = ["venv/bin/pip", "install", "--quiet", "--no-cache-dir", "./ridgetone/host/python"]
        way.step("pip install ./host/python", pip)
        way.step("rt.picture(rt.fit(array, 250))", ["venv/bin/python", "-c", PLOT])
        if not (way.folder / "fit.svg").read_text().startswith("<svg"):
            sys.exit("fit.svg is no picture")
        way.total()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--source", default=str(Path(__file__).resolve().parents[2]), help="what to clone")
    source = parser.parse_args().source
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    print("| way | step | by the clock | processor time |")
    print("|---|---|---:|---:|")
    command_way(source)
    python_way(source)


if __name__ == "__main__":
    main()
