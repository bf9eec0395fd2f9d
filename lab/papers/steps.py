"""Rows of a paper's table: what it prints, what comes out here, and with which command."""

from pages import table

CHECK = ""
"""No command: the row uses only NumPy and SciPy, and tests the paper but no part of Ridgetone."""
HEADINGS = "step|printed|ours|verdict|command"


class Steps:
    """The rows of one paper, and those in which our result failed."""

    def __init__(self):
        self.rows, self.failed = [], []

    def add(self, step, printed, ours, verdict, command=CHECK, holds=True):
        """Adds a row. If `holds` is False, a comparison failed that is not a known difference,
        and the campaign fails."""
        if not holds:
            self.failed.append(f"{step}: printed {printed}, ours {ours}")
            verdict = f"**differs**; {verdict}"
        self.rows.append([step, printed, ours, verdict, command])

    def near(self, step, printed, ours, bar, shown="{:.4g}", command=CHECK, unit=""):
        """Adds a row with one or several values that must be within `bar` of the printed ones."""
        printed, ours = ([one] if isinstance(one, (int, float)) else list(one) for one in (printed, ours))
        off = max(abs(a - b) for a, b in zip(printed, ours, strict=True))
        texts = [", ".join(form.format(one) for one in values) + unit for form, values in (("{:g}", printed), (shown, ours))]
        self.add(step, *texts, "as printed" if off <= bar else f"off by {off:.3g}{unit}", command, off <= bar)

    def table(self):
        return table(HEADINGS, self.rows)


def span(values, digits=2, unit=" %"):
    """Formats the smallest and the largest of some values."""
    return f"{min(values):.{digits}f} to {max(values):.{digits}f}{unit}"
