"""Error, coverage and cost of each choice, and of other methods: docs/results/trade.md and comparison.md.

    python lab/trade.py             all windows, and the pages: some minutes
    python lab/trade.py --short     a twentieth of the windows, against the requirements alone

`cargo xtask counts` counts the instructions and measures the scan plans on the emulator: docs/results/counts.json.
"""

import numpy as np

import campaign
import judge
import methods
import noise
import pages
from windows import CHANNELS, RATE_HZ, RIDGES, SINE, TABLE_2, Tone, fits, finger, frames, joined, make, narrowed

WINDOWS_S = (0.2, 0.3, 0.4, 0.6, 1.0, 3.9)
SHOWN_S = (0.2, 0.4, 1.0, 3.9)
"""Window lengths for the other methods, and for the instructions."""
PERCENTS = (10, 1, 0.1, 0.01, 0.001)
"""Ticks in the picture of errors."""
WINDOWS = 60
"""Windows per combination of speed and period in Table 2."""
SEED = 50_000
SNR_DB = 20.0
CLOCK_HZ = 168e6
SCENES = {"pure tone": SINE, "three overtones": RIDGES}
EVERY = 10
"""Slow methods get every tenth window."""
TONES_UV = (1000, 100, 20, 5)
CONVERTERS = [("ADS1258", None), ("gain of 20", 20), ("bare bridges", 3.3 / 5)]
"""Converters with the gain between bridge and pin. A bare bridge at 3.3 V has less than one."""
LEAN = {"harmonics": 1, "exclude": ["all"]}
WHITE = {"harmonics": 4, "exclude": ["curved_baseline", "coloured_noise", "shared_noise", "impulses"]}
# Declared scenes: name, options of the fit, and windows that contain what the scene excludes.
DECLARED = [
    ("default: four harmonics", {}, None),
    ("harmonics = 1", {"harmonics": 1}, ("white", Tone(), "", 0)),
    ("scene.curved_baseline = false", {"exclude": ["curved_baseline"]}, ("white", Tone(), "creep", 30)),
    ("scene.coloured_noise = false", {"exclude": ["coloured_noise"]}, ("ar 0.9", Tone(), "", 0)),
    ("scene.shared_noise = false", {"exclude": ["shared_noise"]}, ("shared pink", Tone(), "", 0)),
    ("scene.impulses = false", {"exclude": ["impulses"]}, ("impulses", Tone(), "", 0)),
    ("scene.moving_speed = true", {"moving_speed": True}, ("white", Tone(speed="wander", change=0.005), "", 0)),
    ("four harmonics, all four false", WHITE, ("white", Tone(), "", 0)),
    ("lean: one harmonic, all four false", LEAN, ("white", Tone(harmonics=SINE), "", 0)),
]
# Windows that contain something that both white-noise scenes exclude: noise, disturbance and its
# size in amplitudes, and the tone's speed.
EXCLUDED = [
    ("nothing", "white", "", 0, {}),
    ("logarithmic creep of 30 amplitudes", "white", "creep", 30, {}),
    ("pink noise", "pink", "", 0, {}),
    ("AR(1) of 0.9", "ar 0.9", "", 0, {}),
    ("pink noise, the same in all channels", "shared pink", "", 0, {}),
    ("impulses: 1 % of 20 sigma", "impulses", "", 0, {}),
    ("a wander of 0.5 %", "white", "", 0, {"speed": "wander", "change": 0.005}),
]
CONTENTS = [
    "",
    "three overtones",
    "logarithmic creep of 30 amplitudes",
    "AR(1) of 0.9",
    "pink, the same in all channels",
    "impulses: 1 % of 20 sigma",
    "a wander of 0.5 %",
    "three overtones",
    "a pure tone",
]


def batch_of(run, scene, window_s):
    """Returns windows of those combinations in Table 2 that have at least one cycle."""
    rng, count = run.rng(f"{scene}/{window_s:g}"), frames(window_s)
    combinations = [(speed / period, period) for speed, period in TABLE_2 if speed / period * window_s >= 1]
    return joined(
        [finger(rng, run.windows, count, hz / RATE_HZ, SCENES[scene], SNR_DB, period_mm=period) for hz, period in combinations]
    )


def others(run, batch, harmonics):
    found = {}
    for name, method in {"highest line of the FFT": methods.highest_line, **methods.METHODS}.items():
        every = 1 if method in (methods.highest_line, methods.honest_fft) else EVERY
        part = noise.some(batch, every if run.full else 1)
        options = (harmonics,) if method is methods.nls else ()
        found[name] = judge.count(part, judge.Answers(*np.array([method(x, *options) for x in part.x]).T))
    return found


def ours(batch, options, channels, harmonics):
    part = narrowed(batch, channels, harmonics) if channels < CHANNELS else batch
    return judge.count(part, judge.of_fits(fits(part, **{"harmonics": 4, **options})))


def measure(run):
    """Returns the counts of every choice, method and window."""
    found = {}
    for scene, window_s in run.progress([(scene, window_s) for scene in SCENES for window_s in WINDOWS_S]):
        batch, path = batch_of(run, scene, window_s), f"{scene}/{window_s:g} s"
        choices = [("default", {}, CHANNELS), ("one harmonic", {"harmonics": 1}, CHANNELS), ("lean", LEAN, CHANNELS)]
        choices += [(f"{channels} channels", {}, channels) for channels in (8, 4, 2, 1)]
        if scene == "three overtones":
            choices = [choice for choice in choices if choice[0] != "lean"]
        for name, options, channels in choices:
            found[f"{path}/{name}"] = ours(batch, options, channels, SCENES[scene])
        if window_s in SHOWN_S:
            found |= {f"{path}/{name}": counts for name, counts in others(run, batch, len(SCENES[scene])).items()}
    return found


def declared(run):
    """Returns the answers of a scene and of the default in windows of 1 s that contain what it
    excludes."""
    found = {}
    many = 4 * run.windows
    for name, options, content in run.progress(DECLARED, "scenes"):
        if content is None:
            continue
        kind, tone, extra, size = content
        batch = make(run.rng(name), many, frames(1.0), kind, tone, extra, size)
        for who, chosen in (("declared", options), ("default", {})):
            found[f"scene/{name}/{who}"] = judge.count(batch, judge.of_fits(fits(batch, **{"harmonics": 4, **chosen})))
    return found


def false_declarations(run):
    """Returns the answers of the two white-noise scenes in windows of 1 s that contain what they
    exclude, each with its own tone."""
    found = {}
    for name, kind, extra, size, speed in run.progress(EXCLUDED, "false declarations"):
        for scene, options, harmonics in (("lean", LEAN, SINE), ("four harmonics", WHITE, RIDGES)):
            path = f"false/{scene}/{name}"
            batch = make(run.rng(path), 4 * run.windows, frames(1.0), kind, Tone(harmonics=harmonics, **speed), extra, size)
            found[path] = judge.count(batch, judge.of_fits(fits(batch, **options)))
    return found


def plans(run):
    """Compares the scan plans' errors on the same pure tones of 70 to 100 Hz, with the
    converter's own noise."""
    found = {}
    for row in run.progress(counts("plans"), "scan plans"):
        channels, rate_hz, window_s = row["channels"], row["frame_rate_hz"], row["window_s"]
        rng, count = run.rng(f"{row['plan']} {window_s}"), round(window_s * rate_hz)
        # Noise of a conversion (SBAS297G): 12 uV at the fast plans' data rate, and 4.5 uV at that
        # of `paper`.
        snr_db = SNR_DB + (20 * np.log10(12 / 4.5) if row["plan"] == "paper" else 0)
        taxels = {4: (0, 4, 8, 12), 2: (0, 4), 1: (0,)}.get(channels, range(channels))
        batch = joined(
            [
                finger(rng, run.windows, count, hz / rate_hz, SINE, snr_db, period_mm=1.0, taxels=taxels)
                for hz in (70, 80, 90, 100)
            ]
        )
        answers = judge.of_fits(fits(batch, 4))
        off_hz = rate_hz * (answers.frequency - batch.frequency)[answers.status == "good"]
        name = f"plan/{row['plan']}/{1e3 * window_s:.0f} ms"
        found[name] = judge.count(batch, answers) | {
            "late_ms": 1e3 * (row["latency_s"] - window_s),
            "load_percent": 100 * row["load"],
        }
        found[name] |= {"rms_hz": float(f"{np.sqrt(np.mean(np.square(off_hz))):.3g}")}
    return found


def converters(run):
    """Compares the STM32's own 12-bit ADC with the ADS1258 on the same tones of 10 Hz: 14
    channels, 1 s, each with its own noise."""
    found = {}
    count, scans, step_v = frames(1.0), 93, 3.3 / 4096
    for tone_uv in run.progress(TONES_UV, "converters"):
        for name, gain in CONVERTERS:
            path = f"converter/{name}/{tone_uv:g} uV"
            rng = run.rng(path)
            # Without noise, and scaled to volts: `finger` returns values in units of the noise's
            # standard deviation.
            batch = finger(rng, run.windows, count, 10 / RATE_HZ, RIDGES, 0.0, period_mm=3.0, taxels=range(14), noise=0.0)
            volts = 1e-6 * tone_uv * (batch.x - batch.x.mean(1, keepdims=True))
            if gain is None:
                batch.x = volts + 4.5e-6 * rng.standard_normal(volts.shape)
            else:
                # A frame is the mean of 93 samples, each with noise of one step.
                sums = np.zeros(volts.shape)
                pins = 0.5 * 4096 + gain * volts / step_v + rng.uniform(0, 1, (run.windows, 1, 14))
                for _ in range(scans):
                    sums += np.clip(np.floor(pins + rng.standard_normal(volts.shape)), 0, 4095)
                batch.x = sums / scans
            batch.crb = batch.luck = None
            answers = judge.of_fits(fits(batch, 4))
            off_hz = RATE_HZ * (answers.frequency - batch.frequency)[answers.status == "good"]
            rms_mhz = float(f"{1e3 * np.sqrt(np.mean(np.square(off_hz))):.3g}") if len(off_hz) else None
            found[path] = judge.count(batch, answers) | {"rms_mhz": rms_mhz}
    return found


def converters_table(found):
    rows = []
    for tone_uv in TONES_UV:
        cells = [found[f"converter/{name}/{tone_uv:g} uV"] for name, _ in CONVERTERS]
        rows.append(
            [tone_uv, *(figure for cell in cells for figure in (unanswered(cell), pages.significant(cell["rms_mhz"], 2)))]
        )
    return pages.table(
        "tone, uV rms|ADS1258: unanswered, %|RMS, mHz|12 bits, gain of 20: unanswered, %|RMS, mHz|12 bits, bare: unanswered, %|RMS, mHz",
        rows,
    )


def counts(kind):
    """Returns instructions by cell, or rows of the plans, as counted by the emulator."""
    return pages.load("counts").get("detail", {}).get(kind, {} if kind == "cells" else [])


def instructions(scene, window_s, tracked=False):
    """Returns the instructions for a window, or None if they were not counted."""
    return counts("cells").get(f"{scene}/{frames(window_s)} frames", {}).get("tracked" if tracked else "untracked")


def unanswered(cell):
    """Returns the fraction of windows without a good answer, percent."""
    return pages.percent(cell["windows"] - cell["good"], cell["windows"])


def error(cell):
    """Returns the RMS error of the good answers, percent."""
    return pages.significant(cell.get("rms_percent"), 2)


def coverage(cell):
    """Returns the percentage of good answers whose intervals cover, or None without intervals."""
    return pages.percent(cell["covered"], cell["good"]) if cell["covered"] else None


def choices_table(found):
    """Returns the effect of other choices at 0.4 and 1 s."""
    rows = []
    names = {
        "default": "16 channels, four harmonics",
        **{f"{few} channels": f"{few} channel{'s' if few > 1 else ''}" for few in (8, 4, 2, 1)},
    }
    for scene, name, shown in [
        *(("three overtones", name, shown) for name, shown in names.items()),
        ("three overtones", "one harmonic", "`harmonics = 1`"),
        ("pure tone", "default", "four harmonics"),
        ("pure tone", "one harmonic", "`harmonics = 1`"),
        ("pure tone", "lean", "lean scene"),
    ]:
        cells = [found[f"{scene}/{window_s:g} s/{name}"] for window_s in (0.4, 1.0)]
        rows.append(
            [
                scene,
                shown,
                *(figure for cell in cells for figure in (error(cell), pages.fixed(cell.get("over_crb"), 2), unanswered(cell))),
            ]
        )
    return pages.table("scene|choice|0.4 s: RMS, %|RMS over CRB|unanswered, %|1 s: RMS, %|RMS over CRB|unanswered, %", rows)


def false_table(found):
    """Returns the results of false declarations that the tests accept."""
    rows = []
    for name, *_ in EXCLUDED:
        cells = [found[f"false/{scene}/{name}"] for scene in ("lean", "four harmonics")]
        good = [(pages.percent(cell["good"], cell["windows"]), cell["wrong"], coverage(cell)) for cell in cells]
        rows.append([name, *(figure for figures in good for figure in figures)])
    return pages.table("windows with|lean: good, %|outliers called `good`|coverage, %|four harmonics: good, %|outliers called `good`|coverage, %", rows)


def scenes_table(found):
    """Returns the instructions that declarations save, and the errors of false declarations."""
    rows = []
    for (name, _, _), contained in zip(DECLARED, CONTENTS, strict=True):
        work = [instructions(name, window_s) for window_s in SHOWN_S] + [instructions(name, 1.0, True)]
        both = [found.get(f"scene/{name}/{who}") for who in ("declared", "default")]
        figures = [
            figure
            for cell in both
            for figure in (
                [pages.percent(cell["good"], cell["windows"]), pages.percent(cell["wrong"], cell["windows"]), coverage(cell)]
                if cell
                else [None] * 3
            )
        ]
        rows.append([name if ":" in name else f"`{name}`", *work, contained, *figures])
    return pages.table(
        "scene|0.2 s|0.4 s|1 s|3.9 s|1 s, after a good window|windows with|good, %|outliers called `good`, %|coverage, %|"
        "default: good, %|outliers called `good`, %|coverage, %",
        rows,
    )  # fmt: skip


def plans_table(found):
    """Returns error, latency and load of the scan plans, by window."""
    rows = []
    for row in sorted(counts("plans"), key=lambda row: row["window_s"]):
        cell = found[f"plan/{row['plan']}/{1e3 * row['window_s']:.0f} ms"]
        rows.append([
            pages.fixed(1e3 * row["window_s"], 0), f"`{row['plan']}`", row["channels"], pages.significant(row["frame_rate_hz"], 5),
            pages.significant(cell["rms_hz"], 2), pages.fixed(cell.get("over_crb"), 2), unanswered(cell),
            pages.fixed(1e3 * row["latency_s"], 0), pages.fixed(100 * row["load"], 1),
        ])  # fmt: skip
    return pages.table("window, ms|plan|channels|frames a second|RMS, Hz|RMS over CRB|unanswered, %|latency, ms|load, %", rows)


COMPARED = [
    ("default", "Ridgetone", lambda s: instructions(DECLARED[0][0], s)),
    ("one harmonic", "Ridgetone, `harmonics = 1`", lambda s: instructions("harmonics = 1", s)),
    ("lean", "Ridgetone, lean scene", lambda s: instructions(DECLARED[-1][0], s)),
    ("harmonic NLS, BIC", "harmonic NLS, order by BIC", lambda s: None),
    ("curve_fit per channel", "`scipy.optimize.curve_fit` per channel", lambda s: None),
    ("IEEE 1057 per channel", "IEEE 1057 per channel", lambda s: instructions("IEEE 1057", s)),
    ("Oddo 2009, two channels", "Oddo 2009, two channels", lambda s: None),
    ("honest FFT", "Hann, padded by 8, parabola", lambda s: instructions("Hann FFT", s)),
    ("highest line of the FFT", "highest line of the FFT", lambda s: None),
]
"""Methods: name of the cells, name on the page, and instructions."""


def methods_table(found, scene):
    rows = []
    for name, shown, work in COMPARED:
        cells = [found.get(f"{scene}/{window_s:g} s/{name}") for window_s in SHOWN_S]
        if None not in cells:
            rows.append(
                [shown, *(figure for cell in cells for figure in (error(cell), unanswered(cell))), coverage(cells[2]), work(1.0)]
            )
    head = "|".join(f"{window_s:g} s: RMS, %|unanswered, %" for window_s in SHOWN_S)
    crb = [found[f"{scene}/{window_s:g} s/honest FFT"]["crb_percent"] for window_s in SHOWN_S]
    rows.append(["Cramer-Rao bound", *(figure for one in crb for figure in (pages.significant(one, 2), None)), None, None])
    return pages.table(f"method|{head}|1 s: coverage, %|1 s: instructions", rows)


def summary(found, choices):
    """Returns a few choices as shown in the README and the guide."""
    rows = []
    for scene, name, option, window_s, counted in choices:
        work = instructions(counted, window_s)
        percents = f"{error(found[f'{scene}/{window_s:g} s/{name}']):g} %"
        latency = None if work is None else f"{window_s + work / CLOCK_HZ:.3g} s"
        rows.append(
            [
                *option,
                f"{window_s:g} s",
                percents,
                latency,
                None if work is None else f"{pages.significant(work / 1e6, 2):g} million",
            ]
        )
    return rows


def tables(found):
    """Returns the tables of both pages, and of the README and the guide."""
    default = DECLARED[0][0]
    readme = summary(found, [
        ("pure tone", "lean", ("pure tone", "`--harmonics 1 --exclude all`"), 1.0, DECLARED[-1][0]),
        ("three overtones", "default", ("tone with three overtones", "the default"), 1.0, default),
        ("three overtones", "default", ("tone with three overtones", "`--window 0.4`"), 0.4, default),
    ])  # fmt: skip
    guide = summary(found, [("three overtones", "default", (), window_s, default) for window_s in SHOWN_S])
    head = "window|RMS error|latency|instructions"
    made = {
        "channels": choices_table(found), "scenes": scenes_table(found), "false": false_table(found), "plans": plans_table(found), "converters": converters_table(found),
        "readme": pages.table(f"scene|set|{head}", readme), "guide": pages.table(head, guide),
    }  # fmt: skip
    return made


def values(found):

    def most(scene, over, under):
        ratios = [
            found[f"{scene}/{s:g} s/{over}"]["rms_percent"] / found[f"{scene}/{s:g} s/{under}"]["rms_percent"] for s in WINDOWS_S
        ]
        return max(ratios)

    work = [(instructions(DECLARED[0][0], s), instructions("harmonics = 1", s)) for s in SHOWN_S]
    rows = counts("plans")
    more = [1e3 * (row["latency_s"] - row["window_s"]) for row in rows if row["plan"] == "paper"]
    fast = [row["latency_s"] for row in rows if row["plan"] != "paper"]
    load = {row["plan"]: row["load"] for row in rows if abs(row["window_s"] - 0.128) < 1e-3}
    made = {
        "harmonics_error": f"{most('three overtones', 'one harmonic', 'default'):.1f}",
        "harmonics_accuracy": f"{100 * (most('pure tone', 'default', 'one harmonic') - 1):.0f}",
    }
    if all(None not in pair for pair in work):
        made["harmonics_instructions"] = f"{max(default / one for default, one in work):.1f}"
    if rows:
        made |= {
            "latency_default_ms": f"{min(more):.0f} to {max(more):.0f}",
            "latency_fast_s": f"{min(fast):.2g} to {max(fast):.2g}",
            "plans_load": f"{100 * load['paper'] / load['hand']:.0f}",
        }  # fmt: skip
    return made


def draw(found, folder=pages.RESULTS):
    """Draws the RMS error of the methods by window, with three overtones."""
    import plots

    figure, (axis,) = plots.panels()
    plots.ticks(axis, SHOWN_S, " s")
    axis.set_yscale("log")
    axis.set_yticks(PERCENTS, [f"{value:g} %" for value in PERCENTS])
    axis.minorticks_off()
    axis.set_title("RMS error of the frequency, by length of window")
    axis.set_xlabel("tone with three overtones, 16 channels, noise 20 dB below it")
    names = [("default", "Ridgetone"), ("harmonic NLS, BIC", "harmonic NLS"), ("curve_fit per channel", "curve_fit per channel"),
             ("honest FFT", "Hann, padded, parabola"), ("highest line of the FFT", "highest line of the FFT"), ("Oddo 2009, two channels", "Oddo 2009")]  # fmt: skip
    # Draws Ridgetone last, on top of the others.
    for number, (name, shown) in reversed(list(enumerate(names))):
        errors = [found[f"three overtones/{s:g} s/{name}"].get("rms_percent", np.nan) for s in SHOWN_S]
        plots.curve(axis, SHOWN_S, errors, shown, number)
    bound = [found[f"three overtones/{s:g} s/honest FFT"]["crb_percent"] for s in SHOWN_S]
    plots.curve(axis, SHOWN_S, bound, "Cramer-Rao bound", 0, faint=True)
    plots.save(figure, "comparison", "RMS error of each method by length of window", folder)


def main():
    run = campaign.Run("trade", __doc__, WINDOWS, SEED)
    found = run.cells(measure, declared, false_declarations, plans, converters)
    if run.full:
        compared = {name.replace(" ", "_"): methods_table(found, name) for name in SCENES}
        pages.save("comparison", compared, folder=run.out)
    run.finish(found, tables, draw, values, {"counts": counts("cells")})


if __name__ == "__main__":
    main()
