"""Measure eight choices of window, stride and scene on the image that gets flashed: the first table and the picture of
docs/results/trade.md.

    python lab/choices.py            builds the command and the Feather's image, and emulates twelve touches a choice
    python lab/choices.py --short    a touch a choice, against the requirements alone
    python lab/pages.py              fills the page from the first one's JSON

The windows of the padded FFT and of IEEE 1057 are those of the same scenes, `ridgetone emulate --print-scene`.
"""

import json
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

import boards
import campaign
import judge
import methods
import pages
from latency import Touch, quantile
from trade import CLOCK_HZ, DECLARED, instructions
from windows import NINETY_FIVE, RATE_HZ, frames

TOUCHES = 12
"""Touches per choice, each with a different tone."""
SEED = 70_000
TONES_HZ = (15, 21)
SLIDE_S = 5.0
SLIDE_MM = 60
"""Distance of the slide in the plain scene."""
FITTING_S = 4.0
"""Time in which windows end within a slide, if that makes the slide longer."""
SETTLED_S = 1.0
"""Time from the first fit of a slide until a `health` covers only fits."""
LEAN = [f"scene.{name}=false" for name in ("overtones", "curved_baseline", "coloured_noise", "shared_noise", "impulses")]
PURE, RIDGED = "pure tone", "three overtones"
CHOICES = {
    "lean, at every frame": (0.2, 0.0041, PURE),
    **{f"lean, {window_s:g} s": (window_s, 0.05, PURE) for window_s in (0.1, 0.2, 0.4, 1.0)},
    **{f"default, {window_s:g} s": (window_s, 0.25, RIDGED) for window_s in (0.4, 1.0, 3.9)},
}
"""Window and stride in seconds, and the scene. If the tone is pure, the lean scene is set."""
OTHERS = {"Hann FFT": methods.honest_fft, "IEEE 1057": methods.ieee1057}
LABELS = {"Hann FFT": "padded FFT", "IEEE 1057": "IEEE 1057"}
OTHER_WINDOWS_S = (0.2, 0.4, 1.0, 3.9)
NOT_IN_THE_SCENE = {PURE: "overtones, coloured or shared noise, impulses, curved levels, a speed that changes", RIDGED: "a band of noise that shakes the finger"}
BOARD = boards.BOARDS[0]


def built():
    """Builds the image and the command, and returns the command."""
    boards.image(BOARD)
    subprocess.run(["cargo", "build", "--quiet", "--release", "-p", "ridgetone-host"], cwd=pages.ROOT, check=True)
    return pages.ROOT / "target" / "release" / "ridgetone"


def scene(run, number, kind, slide_s=SLIDE_S):
    """Returns options for a touch's scene. All choices get the same tones."""
    rng = run.rng(f"touch {number}")
    hz = rng.uniform(*TONES_HZ)
    speed = SLIDE_MM / slide_s
    options = ["--scene-speed", f"{speed}", "--period", f"{speed / hz}", "--snr", "20", "--seed", str(rng.integers(2**31))]
    return options + ["--pure-tone"] * (kind == PURE)


def emulated(command, options):
    """Returns a touch on the emulator, and the number of bytes of each message on the line."""
    with tempfile.TemporaryDirectory() as folder:
        serial = Path(folder) / "serial.bin"
        words = [command, "emulate", "--json", "--serial-out", serial, *options]
        done = subprocess.run(words, cwd=pages.ROOT, check=True, capture_output=True, text=True)
        touch = Touch(done.stdout.splitlines(), "ridgetone emulate")
        # Each message ends with a zero, and contains no other.
        sizes = [len(part) + 1 for part in serial.read_bytes().split(b"\0") if part]
    if len(sizes) != len(touch.messages):
        raise ValueError(f"{len(sizes)} messages on the line, {len(touch.messages)} lines of JSON")
    return touch, sizes


def watched(touch, sizes, window_s):
    """Returns figures of a touch's answers whose windows are within the slide."""
    truth, answers = touch.truth, touch.answers(window_s)
    start_s, end_s = truth["slide_start_s"], truth["slide_end_s"]
    good = [one for _, one in answers if one["status"] == "good"]
    off = np.array([one["frequency_hz"] - truth["frequency_hz"] for one in good])
    sigma = np.array([one["sigma_hz"] for one in good])
    lefts = [one["left_s"] for _, one in answers]
    busy = [one["load"] for one in touch.of("health") if start_s + max(window_s, 0.2) + SETTLED_S <= one["t_s"] <= end_s]
    sent = [size for size, one in zip(sizes, touch.messages, strict=True) if lefts[0] < one["left_s"] <= lefts[-1]]
    health = touch.of("health")[-1]
    return {
        "off": off / truth["frequency_hz"], "covered": np.abs(off) < NINETY_FIVE * sigma, "windows": len(answers),
        "ages": [one["left_s"] - begin_s for begin_s, one in answers],
        "rate": (len(lefts) - 1) / (lefts[-1] - lefts[0]), "bytes": sum(sent) / (lefts[-1] - lefts[0]), "load": np.mean(busy),
        "stack": health["stack_used_bytes"], "lost": health["conversions_lost"] + health["messages_dropped"],
    }  # fmt: skip


def cell(touches):
    """Returns counts and figures over all touches of a choice."""
    off = np.concatenate([one["off"] for one in touches])
    ages = [age for one in touches for age in one["ages"]]
    return {
        "touches": len(touches), "windows": sum(one["windows"] for one in touches), "good": len(off),
        "covered": int(sum(one["covered"].sum() for one in touches)), "wrong": int((np.abs(off) > judge.WRONG).sum()),
        "lost": sum(one["lost"] for one in touches),
        "rms_percent": float(f"{100 * np.sqrt(np.mean(off**2)):.3g}"),
        "age_ms": round(1e3 * quantile(ages, 0.5), 1), "age_95_ms": round(1e3 * quantile(ages, 0.95), 1),
        "answers_per_s": round(float(np.mean([one["rate"] for one in touches])), 1),
        "load_percent": round(float(100 * np.mean([one["load"] for one in touches])), 1),
        "stack_bytes": max(one["stack"] for one in touches),
        "bytes_per_s": round(float(np.mean([one["bytes"] for one in touches]))),
    }  # fmt: skip


def choices(run):
    """Runs each choice on the emulator."""
    command, found = built(), {}
    for name, (window_s, stride_s, kind) in run.progress(list(CHOICES.items()), "choices"):
        own = [f"window_s={window_s}", f"stride_s={stride_s}", *(LEAN if kind == PURE else [])]
        slide_s = max(SLIDE_S, window_s + FITTING_S)
        options = [word for one in own for word in ("--set", one)]
        with ThreadPoolExecutor(4) as pool:
            touches = list(pool.map(lambda number: emulated(command, [*scene(run, number, kind, slide_s), *options]), range(run.windows)))
        found[f"choice/{name}"] = cell([watched(touch, sizes, window_s) for touch, sizes in touches])
    found["ram"] = {"statics_kib": round(boards.memory(pages.ROOT / "target" / "firmware" / BOARD / "ridgetone-firmware.elf")[1], 1)}
    return found


def others(run):
    """Returns errors of other methods in consecutive windows of the same slides."""
    command, found = built(), {}
    for kind in (PURE, RIDGED):
        off = {}
        for number in run.progress(range(run.windows), kind):
            with tempfile.TemporaryDirectory() as folder:
                table = Path(folder) / "scene.csv"
                words = [command, "emulate", "--json", "--print-scene", table, *scene(run, number, kind)]
                truth = json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout)
                t_s, *volts = np.loadtxt(table, delimiter=",", skiprows=1).T
            volts = np.array(volts).T[(t_s >= truth["slide_start_s"]) & (t_s < truth["slide_end_s"])]
            for window_s in OTHER_WINDOWS_S:
                count = frames(window_s)
                for at in range(0, len(volts) - count + 1, count):
                    for name, method in OTHERS.items():
                        hz = RATE_HZ * method(volts[at : at + count])[0]
                        off.setdefault(f"other/{name}/{kind}/{window_s:g} s", []).append(hz / truth["frequency_hz"] - 1)
        for name, values in off.items():
            found[name] = {"windows": len(values), "rms_percent": float(f"{100 * np.sqrt(np.mean(np.square(values))):.3g}")}
    return found


def tables(found):
    rows = []
    for name, (window_s, stride_s, kind) in CHOICES.items():
        one = found[f"choice/{name}"]
        rows.append([
            name, pages.significant(one["rms_percent"], 2), pages.percent(one["covered"], one["good"]),
            pages.percent(one["windows"] - one["good"], one["windows"]), pages.fixed(one["age_ms"], 0), pages.fixed(one["age_95_ms"], 0),
            pages.fixed(one["answers_per_s"], 0), pages.fixed(one["load_percent"], 0),
            pages.fixed(found["ram"]["statics_kib"] + one["stack_bytes"] / 1024, 0), one["bytes_per_s"], NOT_IN_THE_SCENE[kind],
        ])  # fmt: skip
    head = "choice|RMS error, %|coverage, %|unanswered, %|age, ms|95 % within, ms|answers a second|load, %|RAM, KiB|bytes a second|the scene must not contain"
    return {"choices": pages.table(head, rows)}


def values(found):
    return {
        "touches": min(found[f"choice/{name}"]["touches"] for name in CHOICES),
        "every_load": pages.fixed(found["choice/lean, at every frame"]["load_percent"], 0),
    }


def draw(found):
    """Draws error against the age of an answer."""
    import plots

    figure, (axis,) = plots.panels(height=4.6)
    figure.subplots_adjust(right=0.97)
    plots.ticks(axis, (0.1, 0.2, 0.5, 1, 2, 4), " s")
    axis.set_xlim(right=7)
    axis.set_yscale("log")
    axis.set_yticks(decades := (10, 1, 0.1, 0.01, 0.001), [f"{percent:g} %" for percent in decades])
    axis.set_title("RMS error of the frequency by age of the answer")
    axis.set_xlabel("age; solid: a pure tone, dashed: a tone with three overtones")

    def curve(number, kind, ages_s, errors, label="", offset=(0, 0), at=0):
        axis.plot(ages_s, errors, "o", linestyle=(0, (7, 3)) if kind == RIDGED else "-", color=plots.CURVES[number], markersize=4.5)
        axis.annotate(label, (ages_s[at], errors[at]), offset, textcoords="offset points", color=plots.CURVES[number])

    ours = {PURE: ("Ridgetone, lean scene", [f"lean, {window_s:g} s" for window_s in (0.1, 0.2, 0.4, 1)], (-40, -66), 0),
            RIDGED: ("Ridgetone, default scene", [f"default, {window_s:g} s" for window_s in (0.4, 1, 3.9)], (-145, -4), 0)}  # fmt: skip
    for number, (kind, (label, names, offset, at)) in enumerate(ours.items()):
        own = [found[f"choice/{name}"] for name in names]
        curve(number, kind, [1e-3 * one["age_ms"] for one in own], [one["rms_percent"] for one in own], label, offset, at)
    for number, name in enumerate(OTHERS, 2):
        for kind in (PURE, RIDGED):
            ages = [window_s + instructions(name, window_s) / CLOCK_HZ for window_s in OTHER_WINDOWS_S]
            errors = [found[f"other/{name}/{kind}/{window_s:g} s"]["rms_percent"] for window_s in OTHER_WINDOWS_S]
            curve(number, kind, ages, errors, LABELS[name] if kind == PURE else "", (9, 1), -1)
    plots.save(figure, "choices", "RMS error of each choice and method against the age of its answers")


def main():
    run = campaign.Run("choices", __doc__, TOUCHES, SEED)
    found = run.cells(*((choices, others) if run.full else (choices,)))
    run.finish(found, tables, draw, values)


if __name__ == "__main__":
    sys.exit(main())
