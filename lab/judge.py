"""Counts of the answers to a batch of windows, and requirements on them."""

import fnmatch
import tomllib
from pathlib import Path

import numpy as np
import ridgetone
from scipy import stats

from windows import NINETY_FIVE, Covariance

WHITE = Covariance(white=1.0)

WRONG = 0.05
"""Good answers that are off by more than this fraction are outliers."""
TAIL = 1e-4
"""Probability of a count below which a requirement counts as missed."""


class Answers:
    """A method's answers to windows: frequency and sigma in cycles per frame (NaN without an
    answer), and status."""

    def __init__(self, frequency, sigma, status=None):
        self.frequency, self.sigma = np.asarray(frequency, float), np.asarray(sigma, float)
        answered = np.isfinite(self.frequency)
        self.status = np.where(answered, "good", "no_tone") if status is None else status


def of_fits(fits):
    return Answers(fits.frequency_hz, fits.sigma_hz, fits.status)


def single(x, t, harmonics):
    """Returns the package's fit of one window whose rows have these times."""
    return ridgetone.fit(x, time_s=t, harmonics=harmonics)


def squares(error, unit, batch, good, controls):
    """Returns the mean of squared errors in units, and its standard error. If nearly all windows
    are answered, the squared error of an estimator on the bound, whose mean is known, serves as
    a control variate."""
    values = np.square(error / unit)[good]
    if controls and batch.luck is not None and good.sum() >= 10:
        control = (np.square(batch.luck / unit) - np.square(batch.crb / unit))[good]
        around = control - control.mean()
        slope = (around @ values) / (around @ around) if around @ around > 0 else 0.0
        if values.mean() > slope * control.mean():
            values = values - slope * control
    return values.mean(), values.std(ddof=1) / np.sqrt(len(values)) if len(values) > 1 else np.inf


def count(batch, answers):
    """Returns counts and figures of a batch. RMS errors include only good answers; windows
    without one are `windows - good`."""
    good = answers.status == "good"
    found = {"windows": len(good), "good": int(good.sum())}
    for status in ("ambiguous", "unsteady", "doubtful"):
        found[status] = int((answers.status == status).sum())
    if batch.frequency is None:
        return found | {"wrong": found["good"], "covered": 0}
    error = answers.frequency - batch.frequency
    near = np.abs(error / batch.frequency) <= WRONG
    if batch.second is not None:
        # The two tones may be less than 5 % apart, so an outlier is more than five of its own
        # sigmas from both.
        near = np.minimum(np.abs(error), np.abs(answers.frequency - batch.second)) <= 5 * answers.sigma
    covered = np.abs(error) <= NINETY_FIVE * answers.sigma
    found |= {"wrong": int((good & ~near).sum()), "covered": int((good & covered).sum())}
    times = answers.frequency / batch.frequency
    octaves = [np.abs(ratio / multiple - 1) <= 0.1 for multiple in (2, 3, 4, 5) for ratio in (times, 1 / times)]
    found["octaves"] = int((good & np.any(octaves, axis=0)).sum())
    if good.any():
        controls = good.mean() >= 0.99
        square, spread = squares(error, batch.frequency, batch, good, controls)
        found["rms_percent"], found["rms_sigma"] = 100 * np.sqrt(square), 50 * spread / np.sqrt(square)
        if batch.crb is not None:
            square, spread = squares(error, batch.crb, batch, good, controls)
            found["over_crb"], found["over_crb_sigma"] = np.sqrt(square), 0.5 * spread / np.sqrt(square)
            found["crb_percent"] = 100 * np.sqrt(np.mean(np.square(batch.crb / batch.frequency)[good]))
            ratios = (answers.sigma / batch.crb)[good]
            found["sigma_over_crb"], found["sigma_spread"] = ratios.mean(), ratios.std() / np.sqrt(len(ratios))
    return {name: float(f"{value:.4g}") if isinstance(value, float) else value for name, value in found.items()}


def missed(requirement, cell):
    """Returns a cell's figure and verdict: None within the limit, "luck" if beyond it by no more
    than chance, otherwise "missed"."""
    low, high = requirement.get("min", -np.inf), requirement.get("max", np.inf)
    if "count" in requirement:
        hits, of = sum(cell.get(name, 0) for name in requirement["count"].split("+")), cell.get(requirement["of"], 0)
        if not of:
            return None, None
        value = 100 * hits / of
        # Probability of a count at least as far beyond the limit, which is in percent.
        above = stats.binom.sf(hits - 1, of, min(high, 100) / 100)
        below = stats.binom.cdf(hits, of, max(low, 0) / 100)
        beyond = (value > high, above) if value > high else (value < low, below)
        return value, ("missed" if beyond[1] < TAIL else "luck") if beyond[0] else None
    value = cell.get(requirement["value"])
    if value is None:
        return None, None
    error = stats.norm.isf(TAIL) * cell.get(requirement.get("sigma", ""), 0.0)
    beyond = max(low - value, value - high)
    return value, None if beyond <= 0 else "luck" if beyond <= error else "missed"


def requirements(topic, cells, folder=Path(__file__).parent):
    """Judges the cells of a topic. Returns lines for people, and the missed requirements that are
    not known to be missed.

    An entry's `known` lists cells that miss it, each with a level that must not get worse.
    """
    lines, failures = [], []
    for entry in tomllib.loads((folder / "requirements.toml").read_text()).get("requirement", []):
        if entry["topic"] != topic:
            continue
        known = entry.get("known", {})
        for name, cell in cells.items():
            if not any(fnmatch.fnmatchcase(name, pattern) for pattern in entry["cells"]):
                continue
            level = next((level for pattern, level in known.items() if fnmatch.fnmatchcase(name, pattern)), None)
            value, verdict = missed(entry, cell)
            if level is not None:
                side = "max" if "max" in entry and level > entry["max"] else "min"
                value, verdict = missed(entry | {side: level}, cell)
            if verdict:
                limit = " to ".join(f"{entry[side]:g}" for side in ("min", "max") if side in entry)
                text = f"{entry['name']}: {name}: {value:.4g}, required {limit}" + (f", known to be {level:g}" if level else "")
                (failures if verdict == "missed" else lines).append(text + (" (within its error)" if verdict == "luck" else ""))
    return lines, failures
