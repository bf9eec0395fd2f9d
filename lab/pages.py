"""Fill the tables and values of Markdown pages from the JSON of the results.

`docs/results/TOPIC.json` holds `tables` (columns and rows by name), `values` (by name) and `detail` (counts and settings that
no page shows). A page holds a table between the lines `<!-- NAME -->` and `<!-- end -->`; `<!-- NAME: 0 2 3 -->` shows some of
its columns. A value stands in a sentence as `<!-- value: NAME -->3 %<!-- end -->`. `NAME` is of the page's own topic, or
`TOPIC.NAME` of another one.

    python lab/pages.py            fill all pages of the repository
    python lab/pages.py --check    fail if a page differs from what its JSON gives

Only the standard library: CI runs `--check` without NumPy.
"""

import argparse
import json
import math
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "docs" / "results"
END = "<!-- end -->"


def significant(value, digits):
    """Rounds a number to significant digits. Returns None if it is not finite."""
    if value is None or not math.isfinite(value):
        return None
    return whole(float(f"{value:.{digits}g}"))


def fixed(value, decimals):
    """Rounds a number to decimals. Returns None if it is not finite."""
    return None if value is None or not math.isfinite(value) else whole(round(float(value), decimals))


def whole(value):
    """Converts a whole number to an integer."""
    return int(value) if value == int(value) else value


def percent(count, of):
    """Returns a fraction in percent to a tenth, or None if `of` is zero."""
    return fixed(100 * count / of, 1) if of else None


def table(headings, rows):
    """Returns a table; `|` separates the headings."""
    return {"columns": headings.split("|"), "rows": [list(row) for row in rows]}


def load(topic, folder=RESULTS):
    """Returns the figures of a topic; empty if nothing was measured."""
    path = Path(folder) / f"{topic}.json"
    return json.loads(path.read_text()) if path.exists() else {}


def save(topic, tables, values=None, detail=None, folder=RESULTS):
    """Writes the JSON of a topic, one row per line, and fills its page."""
    figures = {"tables": tables, "values": values or {}, "detail": detail or {}}
    Path(folder).mkdir(parents=True, exist_ok=True)
    (Path(folder) / f"{topic}.json").write_text(dumped(figures) + "\n")
    page = Path(folder) / f"{topic}.md"
    if page.exists():
        page.write_text(filled(page.read_text(), topic, folder))


def dumped(value, depth=0):
    """Returns JSON with one entry per line, down to the rows of tables and the entries of
    details."""
    if isinstance(value, dict) and value and depth < 3:
        entries = [f"{json.dumps(str(key))}: {dumped(one, depth + 1)}" for key, one in value.items()]
        return "{\n" + ",\n".join(entries) + "\n}"
    if isinstance(value, list) and value and isinstance(value[0], (list, dict)):
        return "[\n" + ",\n".join(json.dumps(one) for one in value) + "\n]"
    return json.dumps(value)


def shown(cell):
    match cell:
        case None:
            return "-"
        case bool():
            return "met" if cell else "**not met**"
        case str():
            return cell
        case int():
            return f"{cell:,}"
        case _:
            return f"{cell:f}".rstrip("0") if isinstance(cell, float) and 0 < abs(cell) < 1e-4 else str(cell)


def markdown(table, columns=()):
    """Formats a table in Markdown, with numbers right-aligned."""
    columns = columns or range(len(table["columns"]))
    is_text = [any(isinstance(row[at], str) for row in table["rows"]) for at in columns]
    lines = [[table["columns"][at] for at in columns], ["---" if text else "---:" for text in is_text]]
    lines += [[shown(row[at]) for at in columns] for row in table["rows"]]
    head, rule, *body = lines
    return "\n".join([f"| {' | '.join(head)} |", f"|{'|'.join(rule)}|", *(f"| {' | '.join(line)} |" for line in body)]) + "\n"


def find(kind, name, topic, folder=RESULTS):
    """Returns a table or a value by name; `TOPIC.NAME` is of another topic."""
    of, _, own = name.rpartition(".")
    found = load(of or topic, folder).get(kind, {})
    if own not in found:
        raise KeyError(f"{(of or topic)}.json has no {own} among its {kind}")
    return found[own]


def filled(text, topic, folder=RESULTS):
    """Returns a page with its tables and values filled in."""

    def of_table(match):
        name, columns = match[1], [int(at) for at in (match[2] or "").split()]
        begin = match[0].splitlines()[0]
        return f"{begin}\n{markdown(find('tables', name, topic, folder), columns)}{END}"

    def of_value(match):
        return f"<!-- value: {match[1]} -->{shown(find('values', match[1], topic, folder))}{END}"

    text = re.sub(rf"^<!-- (?!value|end)([\w.-]+)(?:: ([\d ]+))? -->\n(?:\|.*\n)*{END}", of_table, text, flags=re.M)
    return re.sub(rf"<!-- value: ([\w.-]+) -->(?:(?!<!--).)*{END}", of_value, text)


def pages():
    """Returns the pages of the repository that have a marker."""
    found = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True, check=True)
    paths = (ROOT / line for line in found.stdout.splitlines())
    return [path for path in paths if path.exists() and END in path.read_text()]


def main():
    arguments = argparse.ArgumentParser(description="Fill the tables and values of pages from docs/results/*.json.")
    arguments.add_argument("--check", action="store_true", help="fail if a page differs")
    check = arguments.parse_args().check
    failed = False
    for path in pages():
        name, text = path.relative_to(ROOT), path.read_text()
        try:
            wanted = filled(text, path.stem if path.parent == RESULTS else "")
        except KeyError as error:
            failed = True
            print(f"{name}: {error.args[0]}", file=sys.stderr)
            continue
        left = len(re.findall(r"<!-- (?!end)", wanted)) - wanted.count(END)
        if left:
            failed = True
            print(f"{name}: a marker without its {END}, or an {END} without a marker", file=sys.stderr)
        if wanted != text and check:
            failed = True
            print(f"{name}: differs from its JSON: run `python lab/pages.py`", file=sys.stderr)
        elif wanted != text:
            path.write_text(wanted)
            print(f"filled {name}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
