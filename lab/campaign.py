"""A run of a campaign: arguments, random numbers, progress, requirements, and the page at the end."""

import argparse
import sys
import time
import zlib

import numpy as np

import judge
import pages


class Run:
    """A run of a campaign. `--short` takes a twentieth of the windows, `--out` selects a
    different folder."""

    def __init__(self, topic, description, windows, seed):
        arguments = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
        arguments.add_argument("--short", action="store_true", help="a twentieth of the windows; nothing is written")
        arguments.add_argument("--seed", type=int, default=seed, help=f"seed of all windows [default: {seed}]")
        arguments.add_argument("--out", default=str(pages.RESULTS), help="folder of the JSON, the page and its picture")
        arguments.add_argument(
            "--again", action="store_true", help="measure nothing: tables, values and picture again from the JSON"
        )
        given = arguments.parse_args()
        self.again = given.again
        self.topic, self.full, self.seed, self.out = topic, not given.short, given.seed, given.out
        self.windows = windows if self.full else max(windows // 20, 1)
        self.begun_s = time.monotonic()

    def rng(self, name):
        """Returns random numbers for a test case. They depend only on the seed and the name."""
        return np.random.default_rng([self.seed, zlib.crc32(name.encode())])

    def cells(self, *parts):
        """Returns the cells of all parts of the campaign, or with `--again` those in the JSON."""
        if self.again:
            before = pages.load(self.topic, self.out)["detail"]
            self.windows, self.seed = before["windows"], before["seed"]
            return before["cells"]
        return {name: cell for part in parts for name, cell in part(self).items()}

    def progress(self, items, what="test cases"):
        """Yields items, and shows the progress on standard error."""
        for number, item in enumerate(items):
            print(
                f"\r{self.topic}: {what} {number + 1} of {len(items)}, {time.monotonic() - self.begun_s:.0f} s ",
                end="",
                file=sys.stderr,
                flush=True,
            )
            yield item
        print(file=sys.stderr)

    def finish(self, cells, tables, draw, values=None, others=None):
        """Judges the requirements, including those on the cells of `others` by topic. After a
        full run, writes the JSON, the page and its picture. Exits with 1 if a requirement is
        missed."""
        if self.full:
            made = tables(cells)
            pages.save(
                self.topic,
                made,
                values(cells) if values else {},
                {"windows": self.windows, "seed": self.seed, "cells": cells},
                self.out,
            )
            draw(cells)
        lines, failures = judge.requirements(self.topic, cells)
        for topic, own in (others or {}).items():
            more = judge.requirements(topic, own)
            lines, failures = lines + more[0], failures + more[1]
        for line in lines:
            print(line)
        for failure in failures:
            print(f"MISSED: {failure}")
        print(
            f"{self.topic}: {self.windows} windows a test case, {time.monotonic() - self.begun_s:.0f} s, {len(failures)} requirements missed"
        )
        sys.exit(1 if failures else 0)
