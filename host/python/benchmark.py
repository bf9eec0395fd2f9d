"""Prints how long a fit takes through Python, with the command, and with the library alone."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import ridgetone as rt

ROOT = Path(__file__).parents[2]


def best_ms(work: Callable[[], object]) -> float:
    def once() -> float:
        begun = time.perf_counter()
        work()
        return 1e3 * (time.perf_counter() - begun)

    # Ten runs of 0.25 ms end before the processor's caches and clock have warmed up.
    end, times_ms = time.perf_counter() + 0.5, []
    while len(times_ms) < 10 or time.perf_counter() < end:
        times_ms.append(once())
    return min(times_ms)


def main() -> None:
    command = os.environ.get("RIDGETONE_COMMAND", "ridgetone")
    build = ["cargo", "build", "--quiet", "--release", "-p", "ridgetone-host", "--example", "fit_time"]
    subprocess.run(build, check=True, cwd=ROOT)
    alone = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "examples" / "fit_time"
    random = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as folder:
        for rows in [241, 1000, 8192, 32768]:
            t = np.arange(rows) / 241
            c = np.arange(16)
            values = (1 + c) * np.cos(2 * np.pi * 8 * t[:, None] + c) + 0.1 * random.normal(size=(rows, 16))
            path = Path(folder) / "tone.csv"
            head = ",".join(["time_s", *(f"c{channel}" for channel in c)])
            np.savetxt(path, np.c_[t, values], "%.6f", ",", header=head, comments="")
            file_ms, rows_ms = map(float, subprocess.check_output([alone, path], text=True).split())
            touch = rt.read(path)
            whole = best_ms(lambda path=path: subprocess.check_output([command, "fit", path, "--json"]))
            of_file = best_ms(lambda path=path: rt.fit(path))
            of_array = best_ms(lambda touch=touch: rt.fit(touch.values, time_s=touch.time_s))
            print(
                f"| {rows} | {whole:.1f} ms | {of_file:.1f} ms ({of_file / file_ms:.2f} of {file_ms:.1f} ms) "
                f"| {rows_ms:.1f} ms | {of_array:.1f} ms ({of_array / rows_ms:.2f}) |"
            )


if __name__ == "__main__":
    sys.exit(main())
