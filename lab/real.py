"""Fit recordings of other people's sensors whose frequency is known, and some without a tone: docs/results/real-touch.md.

    python lab/real.py [FOLDER]    default: ../shared/recordings next to this repository; without it nothing is measured

Each fit is by itself, with four harmonics, along the stamps or positions of the rows. Nothing is chosen on these recordings.
"""

import argparse
import math
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import ridgetone as rt

import pages
from windows import NINETY_FIVE

FOLDER = pages.ROOT.parent / "shared" / "recordings"
WINDOW_CYCLES = (1.5, 2, 3, 4, 6)
CLOTH_ROWS = (54, 107)
"""Rows of a stretch of cloth, for 1.5 and 3 s."""
PATTERN_MM, PATTERN_TOLERANCE = 6.9, 0.02


@dataclass
class Recording:
    """Rows by time in seconds, or by position in mm."""

    name: str
    along: np.ndarray
    values: np.ndarray
    by_position: bool = False
    truth: float | None = None
    tolerance: float = 0.01

    @property
    def length(self):
        return self.along[-1] - self.along[0]

    def rows(self, first, count):
        return replace(self, along=self.along[first : first + count], values=self.values[first : first + count])

    def between(self, low, high):
        return self.rows(low_row := int(np.searchsorted(self.along, low)), int(np.searchsorted(self.along, high, "right")) - low_row)

    def half(self, first):
        return replace(self, values=self.values[:, first::2])


@dataclass
class Answer:
    """A fit in cycles per second or per mm."""

    status: str
    value: float = math.nan
    sigma: float = math.nan

    @property
    def good(self):
        return self.status == "good"

    def near(self, truth, tolerance):
        return bool(abs(self.value / truth - 1) <= tolerance)

    def covers(self, recording):
        """True if the 95 % interval covers the truth, allowing for the tolerance of the truth."""
        return bool(abs(self.value - recording.truth) <= NINETY_FIVE * math.hypot(self.sigma, recording.tolerance * recording.truth / 2))

    def __str__(self):
        if math.isnan(self.value):
            return f"- `{self.status}`"
        digits = max(0, 1 - math.floor(math.log10(self.sigma)))
        return f"{self.value:.{digits}f} ± {self.sigma:.{digits}f} `{self.status}`"


def fit(recording):
    by = {"position_mm": recording.along - recording.along[0]} if recording.by_position else {}
    try:
        times = np.arange(len(recording.along)) / 340 if by else recording.along
        found = rt.fit(recording.values, time_s=times, harmonics=4, **by)
    except rt.Error:
        return Answer("too_short")
    value, sigma = (found.frequency_per_mm, found.sigma_per_mm) if by else (found.frequency_hz, found.sigma_hz)
    return Answer(found.status) if value is None else Answer(found.status, value, sigma)


def peak(recording):
    """Returns the highest line of the channels' periodograms, each detrended and divided by its
    power. Lines are one cycle per window apart."""
    rows = len(recording.along)
    u = np.linspace(-1, 1, rows)
    left = recording.values - recording.values.mean(0)
    left = left - u[:, None] * (u @ left) / (u @ u)
    power = (np.square(np.abs(np.fft.rfft(left, axis=0))) / np.maximum(np.square(left).sum(0), 1e-300)).sum(1)
    return (1 + power[1 : rows // 2].argmax()) / recording.length * (rows - 1) / rows


def read(path, column="time_s"):
    """Reads a recording along `column`. All other columns except the time are channels."""
    with path.open() as file:
        names = file.readline().strip().split(",")
        table = np.loadtxt(file, delimiter=",", ndmin=2)
    channels = [at for at, name in enumerate(names) if name not in (column, "time_s")]
    return Recording(path.stem, table[:, names.index(column)], table[:, channels], column != "time_s")


def known(folder):
    """Yields the steady parts of recordings with a known frequency."""
    for path in sorted(folder.glob("*.csv")):
        one, end = read(path), None
        if "_V" in path.stem:
            speed = float(path.stem.split("_V")[1])
            one, end = replace(one, truth=speed / 20), (0.785, 6.785) if speed == 20 else (15.7 / speed, 135.7 / speed)
        elif path.stem.startswith("biotac"):
            truth = {"01": 1.878, "05": 1.867, "10": 1.863}[path.stem[-2:]]
            one, end = replace(one, truth=truth), (0.3, one.along[-1] - 0.01)
        elif path.stem == "gait_late":
            one, end = replace(one, truth=0.9303, tolerance=0.012), (0.283, 7.812)
        elif path.stem == "enso":
            one, end = replace(one, truth=1 / 12), (0, one.along[-1])
        if end:
            yield one.between(*end)


def share(answers):
    return f"{sum(answers)} of {len(answers)}"


def parts_agree(recording, found):
    """Compares halves and thirds with the whole: if all are good, their mean must agree with it."""
    for count in (2, 3):
        rows = len(recording.along) // count
        parts, whole = [fit(recording.rows(at * rows, rows)) for at in range(count)], fit(recording.rows(0, count * rows))
        if whole.good and all(part.good for part in parts):
            off = np.mean([part.value for part in parts]) - whole.value
            found.append(abs(off) <= NINETY_FIVE * math.hypot(whole.sigma, np.linalg.norm([part.sigma for part in parts]) / count))


def channels_agree(recording, found):
    """Compares halves of the channels if both are good, in the whole and in either half of it."""
    rows = len(recording.along) // 2
    for part in (recording, recording.rows(0, rows), recording.rows(rows, rows)) if recording.values.shape[1] >= 4 else ():
        halves = [fit(part.half(first)) for first in (0, 1)]
        if all(half.good for half in halves):
            found.append(abs(halves[0].value - halves[1].value) <= NINETY_FIVE * math.hypot(*(half.sigma for half in halves)))


def by_cycles(recordings):
    """Fits the ridged board in windows of a few cycles."""
    for cycles in WINDOW_CYCLES:
        errors, good, covered = [], [], []
        for one in (one for one in recordings if one.name.startswith("fabric")):
            rows = int(min(cycles / (one.truth * one.length), 1) * len(one.along))
            for first in range(0, len(one.along) - rows + 1, rows):
                part = one.rows(first, rows)
                answer = fit(part)
                good.append(answer.good)
                covered += [answer.covers(one)] if answer.good else []
                errors.append([100 * abs(found / one.truth - 1) for found in (peak(part), answer.value)])
        errors = np.array(errors)
        unanswered = np.isnan(errors[:, 1])
        # A missing answer counts as an infinite error.
        medians = np.median(np.where(np.isnan(errors), np.inf, errors), axis=0)
        yield [cycles, len(errors), *(pages.fixed(one, 1) for one in medians), int(unanswered.sum()), share(good), share(covered) if covered else "-"]


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("folder", nargs="?", type=Path, default=FOLDER)
    arguments.add_argument("--short", action="store_true", help="writes nothing")
    given = arguments.parse_args()
    if not given.folder.is_dir():
        print(f"{given.folder}: no such folder, so nothing is measured: give the folder of the recordings")
        return 0
    recordings, rows = list(known(given.folder)), []
    right, good, covered, parts, channels = [], [], [], [], []
    for one in recordings:
        answer = fit(one)
        rows.append([one.name, f"{one.truth:.4f}", str(answer)])
        right.append(answer.near(one.truth, one.tolerance))
        good += [answer.good] if one.truth * one.length >= 5.9 else []
        covered += [answer.covers(one)] if answer.good else []
        parts_agree(one, parts)
        channels_agree(one, channels)
    cloth = []
    for one in (read(path) for path in sorted((given.folder / "no_grating").glob("*.csv"))):
        for count in (*CLOTH_ROWS, len(one.along)):
            cloth += [fit(one.rows(first, count)).good for first in range(0, len(one.along) + 1 - min(count, len(one.along)), count)]
    sweeps = {kind: [fit(read(path, "x_mm")) for path in sorted((given.folder / "sweeps").glob(f"{kind}*.csv"))] for kind in ("flat", "pattern")}
    pattern = [answer.near(1 / PATTERN_MM, PATTERN_TOLERANCE) for answer in sweeps["pattern"]]
    wrong = [answer.good and not near for answer, near in zip(sweeps["pattern"], pattern, strict=True)]
    summary = {
        "right within the tolerance of the truth": right, "good, of those of six cycles": good, "interval covers, of the good": covered,
        "parts add up to the whole, where all are good": parts, "halves of the channels agree, where both are good": channels,
        "cloth without a grating, whole and in 1.5 and 3 s: good": cloth, "flat sweeps: good": [answer.good for answer in sweeps["flat"]],
        "pattern sweeps by position: right within 2 %": pattern, "pattern sweeps: good and wrong": wrong,
    }  # fmt: skip
    tables = {
        "recordings": pages.table("recording|known, Hz|fit, Hz", rows),
        "summary": pages.table("what|of all", [[what, share(answers)] for what, answers in summary.items()]),
        "windows": pages.table("cycles in the window|windows|FFT peak, median error, %|fit, median error, %|unanswered|good|covers, of the good", by_cycles(recordings)),
    }
    if given.short:
        print("\n".join(pages.markdown(one) for one in tables.values()))
    else:
        values = {"right": str(sum(right)), "right_of": str(len(right)), "covered": str(sum(covered)), "cloth_good_percent": round(100 * sum(cloth) / len(cloth))}
        pages.save("real-touch", tables, values)
    return 0


if __name__ == "__main__":
    sys.exit(main())
