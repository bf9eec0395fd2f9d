"""Compute figures of the four papers a second time, sharing no code with the crates.

What the papers print, what `docs/results` has, and what is computed here are compared; the script fails
if one of them differs by more than its bar. Run it as

    cargo xtask papers

which gives it the command to try. With --write it fills in docs/results/papers.md, a table a paper.
"""

import argparse
import json
import sys

import feel
import oddo
import okamoto
import pins
import plates
import teletaction
from checks import RESULTS, Checks


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--command", help="the command to try, too")
    parser.add_argument("--seeds", type=int, default=100, help="seeds of Table 3")
    parser.add_argument("--write", action="store_true", help="write docs/results/papers.json")
    arguments = parser.parse_args()
    checks, command = Checks(), arguments.command
    print("| what | printed | computed here | bar |  |\n|---|---:|---:|---|---|")
    oddo.oddo(checks, arguments.seeds)
    oddo.runs(checks)
    oddo.two_gratings(checks)
    oddo.oblique(checks)
    oddo.aperiodic(checks)
    okamoto.okamoto(checks)
    plates.plates(checks)
    teletaction.people(checks)
    teletaction.layers(checks)
    if command:
        oddo.lags(checks, command)
        feel.feel(checks)
        pins.rows(checks, command)
        compare_or_write(checks, arguments.write)
    if checks.failed:
        sys.exit(f"{checks.failed} rows differ")


def compare_or_write(checks, is_written):
    """The tables of docs/results/papers.md."""
    path, tables = RESULTS / "papers.json", checks.tables()
    if is_written:
        text = json.dumps(tables, separators=(",", ":"), ensure_ascii=False)
        path.write_text(text.replace("],[", "],\n[").replace("},{", "},\n{") + "\n")
        return
    for paper, table in tables["tables"].items():
        there = json.loads(path.read_text())["tables"][paper]["rows"]
        for old, new in zip(there, table["rows"], strict=True):
            checks.true(f"{paper}: {new[0]}: as docs/results/papers.json has it", new[3], old == new)


if __name__ == "__main__":
    main()
