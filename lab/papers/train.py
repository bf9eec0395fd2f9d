"""Fit scores that people gave to surfaces with firing intensities of mechanoreceptors, by stepwise regression.

    python lab/papers/train.py plates.csv --volts-per-um 0.5

`plates.csv` has a row for each surface: `file`, a recording; `score`; and, if it is known, `m`, tangential over normal force.
"""

import argparse
import csv
import sys
from pathlib import Path

import numpy as np
import ridgetone as rt
import statsmodels.api as sm

ENTER, LEAVE = 0.10, 0.10


def stepwise(columns, score):
    """Returns the columns that explain the score, and the regression. The most significant
    column enters if its p is below 0.10, and a column whose p no longer is leaves."""
    chosen, seen = [], set()
    while frozenset(chosen) not in seen:
        seen.add(frozenset(chosen))
        others = {name: regression(columns, [*chosen, name], score).pvalues[-1] for name in columns if name not in chosen}
        # With as many unknowns as surfaces, anything could be explained.
        if others and len(chosen) + 3 <= len(score) and min(others.values()) < ENTER:
            chosen.append(min(others, key=others.get))
        if chosen:
            p = regression(columns, chosen, score).pvalues[1:]
            if p.max() >= LEAVE:
                chosen.pop(int(p.argmax()))
    return chosen, regression(columns, chosen, score)


def regression(columns, names, score):
    """Fits the score by a constant and some columns, by least squares."""
    return sm.OLS(np.asarray(score, float), np.column_stack([np.ones(len(score)), *(columns[name] for name in names)])).fit()


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("table", type=Path)
    arguments.add_argument("--volts-per-um", type=float, required=True, help="amplitude for one micrometre from peak to peak")
    given = arguments.parse_args()
    with given.table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    if len(rows) < 4 or not {"file", "score"} <= set(rows[0]):
        return f"{given.table}: {len(rows)} rows; at least 4 with the columns file and score are needed"
    felt = [rt.feel(given.table.parent / row["file"], volts_per_um=given.volts_per_um) for row in rows]
    columns = {one.receptor: np.array([of.receptors[at].intensity for of in felt], float) for at, one in enumerate(felt[0].receptors)}
    if "m" in rows[0]:
        columns["M"] = np.array([float(row["m"]) for row in rows])
    columns = {name: column for name, column in columns.items() if np.isfinite(column).all() and np.ptp(column) > 0}
    chosen, found = stepwise(columns, [float(row["score"]) for row in rows])
    for name, value, sigma, p in zip(["constant", *chosen], found.params, found.bse, found.pvalues, strict=True):
        print(f"{name:10} {value:12.5g} +- {sigma:.2g}   p = {p:.2g}")
    print(f"R2 {found.rsquared:.3f} of {len(rows)} surfaces")
    return 0


if __name__ == "__main__":
    sys.exit(main())
