"""Rows of what is printed and what is computed, and the tables of docs/results/papers.md."""

import json
from pathlib import Path

RESULTS = Path(__file__).resolve().parents[2] / "docs" / "results"
COLUMNS = ["step", "where", "printed", "ours", "how sure"]


def table(topic, name):
    """Rows of a table that a page of `docs/results` shows."""
    return json.loads((RESULTS / f"{topic}.json").read_text())["tables"][name]["rows"]


def span(values, digits=2, unit=" %"):
    """The least and the greatest."""
    return f"{min(values):.{digits}f} to {max(values):.{digits}f}{unit}"


class Checks:
    """Checks that print themselves, and the steps of each paper."""

    def __init__(self):
        self.failed = 0
        self.steps = {}

    def near(self, what, printed, computed, bar):
        is_near = abs(printed - computed) <= bar
        self.row(what, f"{printed:g}", f"{computed:.4g}", f"within {bar:g}", is_near)

    def within(self, what, printed, least, most):
        self.row(what, f"{printed:g}", f"{least:.3g} to {most:.3g}", "in the range", least <= printed <= most)

    def true(self, what, shown, is_true):
        self.row(what, "", shown, "", is_true)

    def row(self, what, printed, computed, bar, is_met):
        self.failed += not is_met
        print(f"| {what} | {printed} | {computed} | {bar} | {'ok' if is_met else '**differs**'} |")

    def step(self, paper, step, where, printed, ours, sure):
        """A row of a paper's table."""
        self.steps.setdefault(paper, []).append([step, where, printed, ours, sure])

    def tables(self):
        """What docs/results/papers.json has."""
        return {"tables": {paper: {"columns": COLUMNS, "rows": rows} for paper, rows in sorted(self.steps.items())}, "detail": {}}
