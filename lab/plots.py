"""Common style for all pictures of the results, with direct labels, legible on light and dark
pages."""

import re

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt

from pages import RESULTS

# Colours on light and on dark pages: text, faint text, grid, card, then curves.
TEXT, FAINT, GRID, CARD = "#222222", "#555555", "#dddddd", "#ffffff"
CURVES = ("#0064a4", "#c4480a", "#00795a", "#a01050", "#6b4fa0", "#7a6a00", "#556677")
DARK = {
    TEXT: "#e4e6ea", FAINT: "#b4b8c0", GRID: "#2c3138", CARD: "#16191e",
    **dict(zip(CURVES, ("#6bb8f0", "#ff9a5c", "#4fd0a4", "#ff7fb0", "#b7a3f0", "#d8c64a", "#a3b3c6"), strict=True)),
}  # fmt: skip

plt.rcParams.update(
    {
        "svg.fonttype": "none", "svg.hashsalt": "ridgetone", "font.family": "DejaVu Sans", "font.size": 9.5,
        "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": GRID, "grid.linewidth": 0.7,
        "axes.edgecolor": FAINT, "axes.labelcolor": TEXT, "text.color": TEXT, "xtick.color": FAINT, "ytick.color": FAINT,
        "axes.titlesize": 11, "axes.titlelocation": "left", "axes.titleweight": "bold", "figure.facecolor": CARD,
        "axes.facecolor": CARD, "savefig.facecolor": CARD, "axes.axisbelow": True, "lines.linewidth": 1.6,
    }
)  # fmt: skip


def panels(count=1, width=9.4, height=4.2):
    """Creates a figure with panels one below the other and room for labels on the right. Returns
    figure and axes."""
    figure, axes = plt.subplots(count, 1, figsize=(width, height * count), squeeze=False)
    figure.subplots_adjust(left=0.08, right=0.74, top=1 - 0.35 / (height * count), bottom=0.5 / (height * count), hspace=0.35)
    return figure, list(axes[:, 0])


def curve(axis, x, y, name, number, marker="o", dashed=False, faint=False):
    """Draws a curve with its name at the right end, in the curve's colour."""
    colour = TEXT if faint else CURVES[number % len(CURVES)]
    style = (0, (2, 3)) if faint else (0, (7, 3)) if dashed else "-"
    axis.plot(x, y, color=colour, linestyle=style, marker=None if faint else marker, markersize=4.5)
    labels = axis.__dict__.setdefault("_labels", [])
    labels.append((x[-1], y[-1], name, colour))


def ticks(axis, values, unit=""):
    """Sets a logarithmic axis with ticks only at these values."""
    axis.set_xscale("log")
    axis.set_xticks(values, [f"{value:g}{unit}" for value in values])
    axis.minorticks_off()


def save(figure, name, title, folder=RESULTS):
    """Places the labels so that they do not overlap, and writes `NAME.svg` with colours for a
    dark page."""
    figure.canvas.draw()
    for axis in figure.axes:
        labels = axis.__dict__.get("_labels", [])
        pixels = [(axis.transData.transform((x, y)), text, colour) for x, y, text, colour in labels]
        right = axis.get_window_extent().x1
        last = -1e9
        for (_, y), text, colour in sorted(pixels, key=lambda one: one[0][1]):
            at = last = max(y, last + 0.19 * figure.dpi)
            spot = axis.transData.inverted().transform((right + 8, at))
            axis.annotate(text, spot, color=colour, va="center", annotation_clip=False)
    path = folder / f"{name}.svg"
    figure.savefig(path, metadata={"Title": title, "Date": None, "Creator": None})
    plt.close(figure)
    rules = "".join(
        f'[style*="{kind}: {light}"]{{{kind}:{dark}!important}}' for light, dark in DARK.items() for kind in ("fill", "stroke")
    )
    svg = path.read_text()
    svg = re.sub(r"(<svg [^>]*>)", rf"\1\n <style>@media(prefers-color-scheme:dark){{{rules}}}</style>", svg, count=1)
    svg = svg.replace("'DejaVu Sans'", "system-ui,'Helvetica Neue',Arial,'DejaVu Sans',sans-serif")
    path.write_text("\n".join(line.rstrip() for line in svg.splitlines()) + "\n")
