"""Repeat what four papers print: a table for each in docs/results/papers.md.

    python lab/papers.py            all of it, four minutes of one core
    python lab/papers.py --short    fewer runs and seeds; writes nothing

Fails if a figure differs that is as printed today.
"""

import argparse
import sys
from pathlib import Path

import pages
import plots

sys.path.insert(0, str(Path(__file__).parent / "papers"))
import oddo
import okamoto
import plates
import teletaction
from steps import Steps

PAPERS = {"oddo": oddo, "okamoto": okamoto, "plates": plates, "teletaction": teletaction}


def draw(found):
    """Draws the errors of Oddo's Table 3 by combination, as printed and ours."""
    figure, [axis] = plots.panels(1, height=3.6)
    names = list(found)
    curves = {"FFT, printed": oddo.FFT["1, 2"], "FFT": [one["fft 1, 2"] for one in found.values()], "least squares, printed": oddo.FIT["1, 2"],
              "least squares": [one["fit 1, 2"] for one in found.values()], "fit, to the true speed": [one["own all"] for one in found.values()]}  # fmt: skip
    for number, (name, errors) in enumerate(curves.items()):
        plots.curve(axis, range(len(names)), errors, name, number // 2, dashed="printed" in name)
    axis.set_yscale("log")
    axis.set_xticks(range(len(names)), names)
    axis.set_title("Error of the frequency over 55 mm, % RMS")
    plots.save(figure, "papers", "Errors by combination: printed and ours near 1 %, those to the true speed far below")


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--short", action="store_true", help="fewer runs and seeds; writes nothing")
    arguments.add_argument("--only", choices=PAPERS, help="one paper; the tables of the others stay")
    arguments.add_argument("--seed", type=int, default=1, help="first seed of what is drawn")
    given = arguments.parse_args()
    there = pages.load("papers")
    tables, detail, failed = there.get("tables", {}), there.get("detail", {}), []
    for name, paper in PAPERS.items():
        if given.only not in (None, name):
            continue
        print(f"papers: {name}", file=sys.stderr)
        steps = Steps()
        detail[name] = paper.run(steps, given.short, given.seed)
        tables[name] = steps.table()
        failed += [f"{name}: {one}" for one in steps.failed]
        print(pages.markdown(tables[name]))
    if not given.short:
        pages.save("papers", tables, detail=detail)
        draw(detail["oddo"]["table_3"])
    return "\n".join(failed) or 0


if __name__ == "__main__":
    sys.exit(main())
