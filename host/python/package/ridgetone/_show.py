"""Formats objects for people: values with their uncertainty to two digits, as text and as HTML; pictures in a notebook."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from html import escape
from typing import Any


class Picture(str):
    """SVG that a notebook displays as a picture."""

    def _repr_svg_(self) -> str:
        return str(self)


def uncertain(value: float, sigma: float) -> str:
    """Formats a value with its standard deviation to two digits; an exact value (sigma 0) without."""
    if sigma == 0:
        return number(value)
    if not (math.isfinite(sigma) and sigma > 0):
        return f"{number(value)} ± {number(sigma)}"
    # Use the exponent after rounding, since 0.0996 becomes 0.10.
    decimals = max(0, 1 - int(f"{sigma:.1e}".partition("e")[2]))
    return f"{value:.{decimals}f} ± {sigma:.{decimals}f}"


def number(value: object) -> str:
    return f"{value:.7g}" if isinstance(value, float) else str(value)


def _value_of(name: str, fields: Mapping[str, Any]) -> str | None:
    """Returns the field that a standard deviation belongs to: `period_mm` for `period_sigma_mm`, `frequency_hz` for
    `sigma_hz`."""
    if "sigma" not in name.split("_"):
        return None
    owner = name.replace("sigma_", "", 1)
    owner = owner if owner in fields else f"frequency_{owner}"
    is_pair = isinstance(fields.get(owner), float) and isinstance(fields[name], float)
    return owner if owner != name and is_pair else None


def lines(fields: Mapping[str, Any], under: str = "") -> Iterator[tuple[str, str]]:
    """Yields names and values of all known fields except tables."""
    sigmas = {owner: name for name in fields if (owner := _value_of(name, fields))}
    for name, value in fields.items():
        if value is None or name in sigmas.values() or name == "type" or _is_table(value):
            continue
        if isinstance(value, Mapping):
            yield from lines(value, f"{under}{name}.")
        elif name in sigmas:
            yield under + name, uncertain(value, fields[sigmas[name]])
        elif isinstance(value, list):
            shown = ", ".join(map(number, value[:_MOST]))
            yield under + name, shown + (f", ... ({len(value)})" if len(value) > _MOST else "")
        else:
            yield under + name, number(value)


# Maximum number of list items shown.
_MOST = 8


def _is_table(value: object) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(row, Mapping) for row in value)


def tables(fields: Mapping[str, Any]) -> Iterator[tuple[str, list[list[str]]]]:
    """Yields each list of objects as a table: its name, a row of field names, and a row for each object."""
    for name, value in fields.items():
        if _is_table(value):
            # Omits nested fields; the object itself has them.
            heads = [head for head in value[0] if not any(isinstance(row.get(head), (Mapping, list)) for row in value)]
            cells = [["-" if (cell := row.get(head)) is None else _cell(cell) for head in heads] for row in value]
            yield name, [heads, *cells]


def _cell(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def text(kind: str, fields: Mapping[str, Any]) -> str:
    shown = list(lines(fields))
    width = max((len(name) for name, _ in shown), default=0)
    out = [kind, *(f"  {name:<{width}}  {value}" for name, value in shown)]
    for name, rows in tables(fields):
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        out.append(f"  {name}")
        out += ["    " + "  ".join(f"{cell:>{w}}" for cell, w in zip(row, widths, strict=True)) for row in rows]
    return "\n".join(out)


def html(kind: str, fields: Mapping[str, Any]) -> str:
    def row(cells: list[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    out = [f"<b>{escape(kind)}</b><table>", *(row([name, value], "td") for name, value in lines(fields)), "</table>"]
    for name, (heads, *rows) in tables(fields):
        out += [f"<i>{escape(name)}</i><table>", row(heads, "th"), *(row(cells, "td") for cells in rows), "</table>"]
    return "".join(out)
