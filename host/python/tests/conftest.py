"""The command to compare the package with, and recordings of every kind."""

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).parents[3]
COMMAND = os.environ.get("RIDGETONE_COMMAND", "ridgetone")
SCENES = sorted(path.stem for path in (ROOT / "hal-mock/scenes").glob("*.toml"))

Run = Callable[..., list[dict[str, Any]]]
Refusal = Callable[..., str]


def command(*arguments: object) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True, cwd=ROOT)


@pytest.fixture
def run() -> Run:
    """Runs the command and returns its lines of JSON. A replay without an estimate exits with status 3."""

    def run(*arguments: object) -> list[dict[str, Any]]:
        done = command(*arguments)
        assert done.returncode == 0 or (done.returncode, arguments[0]) == (3, "replay"), done.stderr
        return [json.loads(line) for line in done.stdout.splitlines()]

    return run


@pytest.fixture
def refusal() -> Refusal:
    """Runs a command that must fail, and returns its error without the command's name."""

    def refusal(*arguments: object) -> str:
        done = command(*arguments)
        assert done.returncode != 0, done.stdout
        return done.stderr.strip().removeprefix("ridgetone: ")

    return refusal


def tone(channels: int, rows: int, rate_hz: float, tone_hz: float, decimals: int = 6) -> str:
    """Returns a table of a tone with an overtone and a little noise."""
    random = np.random.default_rng(7)
    t = np.arange(rows) / rate_hz
    c = np.arange(channels)
    phase = 2 * np.pi * tone_hz * t[:, None] + c
    values = 100 + 10 * c + (1 + 0.1 * c) * (np.cos(phase) + 0.4 * np.sin(2 * phase))
    values += 0.2 * (random.random(values.shape) - 0.5)
    head = ",".join(["time_s", *(f"c{channel}" for channel in c)])
    lines = (",".join([f"{at:.{decimals}f}", *(f"{v:.6f}" for v in row)]) for at, row in zip(t, values, strict=True))
    return "\n".join([head, *lines]) + "\n"


def tables() -> dict[str, str]:
    """Returns tables like those of the command's own tests."""
    plain = tone(4, 600, 100, 4)
    rows = plain.splitlines()
    blank = [row if at % 7 else row.rsplit(",", 1)[0] + "," for at, row in enumerate(rows[1:], 1)]
    return {
        "tone": tone(16, 1000, 241, 8),
        "milliseconds": tone(16, 900, 35.6, 0.5, decimals=3),
        "gap": "\n".join(rows[:301] + rows[304:]),
        "blank": "\n".join([rows[0], *blank]),
        "single": tone(1, 400, 100, 5),
        "fast": tone(3, 4000, 1000, 20),
        "noise": tone(3, 400, 100, 0),
    }


@pytest.fixture(scope="session")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Makes a recording of every scene of the repository and of every table."""
    folder = tmp_path_factory.mktemp("recordings")
    found = {}
    for name in SCENES:
        found[name] = folder / f"{name}.csv"
        done = command("emulate", f"hal-mock/scenes/{name}.toml", "--print-scene", found[name])
        assert done.returncode == 0, done.stderr
    for name, text in tables().items():
        found[name] = folder / f"{name}.csv"
        found[name].write_text(text)
    return found


@pytest.fixture(scope="session")
def telemetry(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Records a touch of the emulated board with its raw frames, and exports it in each format."""
    folder = tmp_path_factory.mktemp("telemetry")
    found = {"rec": folder / "touch.rec"}
    done = command("record", "--emulated", "--raw", "-o", found["rec"])
    assert done.returncode == 0, done.stderr
    for name, options in {"mcap": ["--format", "mcap"], "ndjson": ["--format", "ndjson"],
                          "csv": ["--format", "csv", "--table", "frames"]}.items():  # fmt: skip
        found[name] = folder / f"touch.{name}"
        done = command("export", found["rec"], *options, "-o", found[name])
        assert done.returncode == 0, done.stderr
    return found
