"""Rows of a paper's table: what it prints, what comes out here, and with which command."""

from pages import table

CHECK = ""
"""No command: a row of NumPy and SciPy alone, which checks the paper and no part of Ridgetone."""
HEADINGS = "step|printed|ours|verdict|command"


class Steps:
    """The rows of one paper, and those whose verdict is a failure of ours."""

    def __init__(self):
        self.rows, self.failed = [], []

    def add(self, step, printed, ours, verdict, command=CHECK, holds=True):
        """A row. `holds` is False where a comparison failed that is no known difference: the campaign then fails."""
        if not holds:
            self.failed.append(f"{step}: printed {printed}, ours {ours}")
            verdict = f"**differs**; {verdict}"
        self.rows.append([step, printed, ours, verdict, command])

    def near(self, step, printed, ours, bar, shown="{:.4g}", command=CHECK, unit=""):
        """A row, or several values of one, that must be within `bar` of what is printed."""
        printed, ours = ([one] if isinstance(one, (int, float)) else list(one) for one in (printed, ours))
        off = max(abs(a - b) for a, b in zip(printed, ours, strict=True))
        texts = [", ".join(form.format(one) for one in values) + unit for form, values in (("{:g}", printed), (shown, ours))]
        self.add(step, *texts, "as printed" if off <= bar else f"off by {off:.3g}{unit}", command, off <= bar)

    def table(self):
        return table(HEADINGS, self.rows)


def span(values, digits=2, unit=" %"):
    """The smallest and the largest of some values."""
    return f"{min(values):.{digits}f} to {max(values):.{digits}f}{unit}"
