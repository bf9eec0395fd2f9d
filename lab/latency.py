"""Print when each event of an emulated touch left the board, next to when it happened.

    ridgetone emulate --json > touch.jsonl
    python lab/latency.py touch.jsonl

The last line of the recording has the true times: the slide of the plain scene starts a second after the contact. A stride
below 0.05 s adds tracks, and `--pure-tone` is the scene in which the lean settings are right:

    ridgetone emulate --json --pure-tone --set window_s=0.2 --set stride_s=0.0041 \\
        --set scene.overtones=false --set scene.curved_baseline=false --set scene.coloured_noise=false \\
        --set scene.shared_noise=false --set scene.impulses=false | python lab/latency.py -

Only the standard library.
"""

import argparse
import json
import sys


class Touch:
    """Messages of one touch, and its true values, by the device's clock."""

    def __init__(self, lines, name):
        objects = [json.loads(line) for line in lines]
        truths = [one for one in objects if one["type"] == "truth"]
        if len(truths) != 1 or any("left_s" not in one for one in objects if one["type"] != "truth"):
            raise ValueError(f"{name}: not the whole output of `ridgetone emulate --json`, whose last line has the type `truth`")
        self.truth = truths[0]
        self.messages = [one for one in objects if one["type"] != "truth"]

    def of(self, kind, **fields):
        """Returns the messages of a kind whose fields have these values."""
        return [one for one in self.messages if one["type"] == kind and all(one[name] == value for name, value in fields.items())]

    def answers(self, window_s):
        """Returns tracks, or estimates of windows if there are no tracks, with the windows'
        starts. Includes only windows within the slide."""
        answers = self.of("track") or self.of("estimate", span="window")
        begins = [(one["t_s"] - one.get("window_s", window_s), one) for one in answers]
        return [(at, one) for at, one in begins if at >= self.truth["slide_start_s"] and one["t_s"] <= self.truth["slide_end_s"]]


def quantile(values, part):
    """Returns the value below which this fraction of the values lies."""
    return sorted(values)[round(part * (len(values) - 1))]


ROWS = [
    ("contact", "contact_s", "contact", {}),
    ("moving", "slide_start_s", "moving", {}),
    ("slide, start", "slide_start_s", "slide", {"state": "start"}),
    ("first track", "slide_start_s", "track", {}),
    ("first good track", "slide_start_s", "track", {"status": "good"}),
    ("first estimate", "slide_start_s", "estimate", {"span": "window"}),
    ("first good estimate", "slide_start_s", "estimate", {"span": "window", "status": "good"}),
    ("slide, end", "slide_end_s", "slide", {"state": "end"}),
    ("estimate of the slide", "slide_end_s", "estimate", {"span": "slide"}),
    ("release", "release_s", "release", {}),
]
"""Label to print, true time to measure from, and fields of the first message that matches."""


def report(touch):
    """Yields the lines of the table, then the ages of all answers."""
    yield f"{'event':<22}{'happened, s':>12}{'dated, s':>10}{'left, s':>10}{'later, ms':>11}"
    for name, of, kind, fields in ROWS:
        happened_s, found = touch.truth[of], touch.of(kind, **fields)
        if found:
            dated_s, left_s = found[0]["t_s"], found[0]["left_s"]
            yield f"{name:<22}{happened_s:>12.3f}{dated_s:>10.3f}{left_s:>10.3f}{1e3 * (left_s - happened_s):>11.1f}"
        else:
            yield f"{name:<22}{happened_s:>12.3f}{'none':>10}"
    for kind, fields in (("track", {}), ("estimate", {"span": "window"})):
        late_ms = [1e3 * (one["left_s"] - one["t_s"]) for one in touch.of(kind, **fields)]
        if late_ms:
            half, most = (quantile(late_ms, part) for part in (0.5, 0.95))
            yield f"{len(late_ms)} {kind}s left {half:.1f} ms after the end of their windows at the median, 95 % of them within {most:.1f} ms"


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("file", metavar="FILE.jsonl", help="output of `ridgetone emulate --json`; `-` is standard input")
    file = arguments.parse_args().file
    try:
        if file == "-":
            touch = Touch(sys.stdin, "standard input")
        else:
            with open(file) as lines:
                touch = Touch(lines, file)
    except (OSError, ValueError, KeyError, TypeError) as error:
        return f"latency.py: {error}"
    print("\n".join(report(touch)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
