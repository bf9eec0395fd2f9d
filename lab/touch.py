"""Contacts, slides and releases in touches with known times: docs/results/touch.md.

    python lab/touch.py            200 touches a case, four minutes of one core
    python lab/touch.py --short    10 touches a case; writes nothing

Each touch is air, contact, hold, slide, hold, release, air, by `ridgetone.simulate` with random channels. Constants of the detector
are chosen on other seeds than the page's.
"""

from dataclasses import dataclass, replace

import numpy as np
import ridgetone as rt

import pages
import windows
from campaign import Run

PERIOD_MM, RATE_HZ, CHANNELS = 3.6, windows.RATE_HZ, 16
CONVERTER_V = 4.5e-6
"""Noise of the converter at the scan's data rate, volts."""
RISE_S, DECAY_S = 0.010, 0.040
"""Time from the touch to the peak of the spike, and its decay to 1/e, as in hal-mock's scenes."""
CONTACT_S, RELEASE_S, NEAR_S = 0.1, (-0.05, 1.0), 0.02
"""Maximum difference of an event from the truth. A release may lag by the time in which the skin
creeps back."""
VISIBLE = 25.0
"""Sum of the squares of the motion's traces, over the variance of the noise, at which someone
who knows the motion would see it: five sigma."""


@dataclass(frozen=True)
class Case:
    """Contents of a case's touches. Pairs are ranges, drawn log-uniformly."""

    group: str
    name: str
    tone_hz: tuple = (1, 100)
    snr_db: float = 20
    slide_s: tuple | None = (0.4, 8)
    ramp_s: tuple = (0.005, 0.02)
    idle_s: tuple = (0.5, 5)
    before_s: tuple = (0.5, 2)
    after_s: tuple = (0.5, 2)
    pink: bool = False
    spike: tuple | None = None  # square of the contact spike over the hold's; otherwise about 2
    creep: float = 0.0  # of the skin, relative to the amplitude of the tone
    drift_v_s: float = 0.0
    hum: bool = False  # 50 Hz as strong as the tone
    mains: bool = False  # the hum is declared to the detector
    load: float = 1.0
    press: float = 0.0  # the load swings by this fraction at 1 to 3 Hz
    loaded: bool = False  # the recording begins under load
    physical: bool = False  # the physical finger, which has its own creep, filter and noise


def still(case, name=None):
    """Returns the same case without a slide."""
    return replace(case, name=name or f"{case.name}, no slide", slide_s=None, before_s=(2, 8))


def cases():
    found = [Case("tones", f"{low} to {high} Hz, {db} dB", (low, high), db)
             for db in (20, 10, 0) for low, high in ((1, 2), (2, 5), (5, 20), (20, 50), (50, 70), (70, 100))]  # fmt: skip
    found += [Case("lengths", f"{low:g} to {high:g} s", slide_s=(low, high)) for low, high in ((0.4, 0.5), (0.5, 1), (1, 2), (2, 4), (7.9, 8))]
    found += [Case("lengths", "7.9 to 8 s, 10 dB", snr_db=10, slide_s=(7.9, 8))]
    found += [Case("lengths", f"ramps of {s} s", slide_s=(2 * s + 0.2, 8), ramp_s=(s, s)) for s in (0.1, 0.2, 0.4, 0.8)]
    found += [Case("early", f"{hz} Hz, {db} dB", (hz, hz), db, idle_s=(0.3, 4.9)) for db in (20, 10) for hz in (60, 70, 100)]
    strong = Case("contact", "spike's square 12 to 40 times the hold's", spike=(12, 40))
    brief = Case("contact", "holds of 0.05 s, no slide", slide_s=None, before_s=(0.025, 0.025), after_s=(0.025, 0.025))
    found += [
        Case("contact", "spike's square 10 to 12 times the hold's", spike=(10, 12)), strong, replace(strong, name=f"{strong.name}, no slide", slide_s=None),
        Case("contact", "holds of 0.05 s, then a slide", slide_s=(0.4, 2), before_s=(0.05, 0.05)), brief,
        replace(brief, name="holds of 0.1 to 0.3 s, no slide", before_s=(0.05, 0.15), after_s=(0.05, 0.15)),
        Case("contact", "starting under load", loaded=True, before_s=(1.5, 3)),
        *(Case("contact", f"half the load, 2 to 10 Hz, {db} dB", (2, 10), db, load=0.5) for db in (20, 10)),
    ]  # fmt: skip
    found += [Case("lift", f"{low} to {high} s after the slide", slide_s=(0.4, 2), after_s=(low, high)) for low, high in ((0.05, 0.1), (0.1, 0.2), (0.2, 0.5), (0.5, 1))]
    found += [Case("lift", "0.05 to 1 s, 10 dB", snr_db=10, slide_s=(0.4, 2), after_s=(0.05, 1)), Case("lift", "while it slides", slide_s=(0.4, 2), after_s=(1e-3, 1e-3))]
    with_still = [
        Case("disturbances", "drift of 100 mV/s", drift_v_s=0.1), Case("disturbances", "hum as strong as the tone", hum=True),
        Case("disturbances", "the same with --mains 50", hum=True, mains=True), Case("disturbances", "presses by 10 % at 1 to 3 Hz", press=0.1),
        Case("disturbances", "pink noise", pink=True), Case("disturbances", "pink noise, 10 dB", snr_db=10, pink=True),
        Case("disturbances", "tone 10 dB below the creep", creep=10**0.5),
    ]  # fmt: skip
    found += [one for case in with_still for one in (case, still(case))]
    found += [Case("disturbances", f"drift of {mv} mV/s", drift_v_s=mv / 1000) for mv in (10, 1)]
    return [*found, Case("disturbances", "physical finger", physical=True), still(Case("disturbances", ""), "white noise, no slide")]


def touch(case, rng):
    """Returns the frames of a touch in volts, and its truth in seconds from the first frame."""
    draw = lambda low, high: low * (high / low) ** rng.random()
    hz, slide_s = draw(*case.tone_hz), case.slide_s and draw(*case.slide_s)
    ramp_s = min(draw(*case.ramp_s), slide_s / 2 if slide_s else 0.5)
    # A slide of a thousandth of a period does not count as one.
    slide_mm = hz * PERIOD_MM * (slide_s - ramp_s) if slide_s else 1e-3 * PERIOD_MM
    scene = {
        "speed_mm_s": hz * PERIOD_MM, "period_mm": PERIOD_MM, "slide_mm": slide_mm, "idle_s": draw(*case.idle_s), "hold_before_s": draw(*case.before_s),
        "hold_after_s": draw(*case.after_s), "release_idle_s": 1.2, "start_mm": draw(1, 1 + PERIOD_MM), "seed": int(rng.integers(1 << 31)),
        "stimulator": {"ramp_s": ramp_s if slide_s else 0.0},
    }  # fmt: skip
    if case.physical:
        scene["finger"] = {"finger_seed": scene["seed"]}
    made = rt.simulate(scene, random_channels=not case.physical, converter=False)
    load_v, tone_v = (np.array([channel[name] for channel in made.channels]) for name in ("load_v", "tone_v"))
    offset_v, tone_rms_v = np.array([channel.offset_v for channel in made.channels]), np.sqrt(np.mean(tone_v**2))
    noise_v = 0.0 if case.physical else tone_rms_v / np.sqrt(2 * 10 ** (case.snr_db / 10))
    truth, clean = made.truth, made.values
    t_s = made.time_s[:, None] + np.arange(CHANNELS) / 21 / RATE_HZ
    step = lambda x: 0.5 - 0.5 * np.cos(np.pi * np.clip(x, 0, 1))
    load = step((t_s - truth.contact_s) / RISE_S + 1) * (1 - step((t_s - truth.release_s) / RISE_S))
    # The spike of a scene is about half as high as its load.
    more = (np.sqrt(draw(*case.spike)) - 1.5) if case.spike else 0.0
    after = t_s - truth.contact_s
    spike = np.where(after < 0, step(after / RISE_S + 1), np.exp(-after.clip(0) / DECAY_S))
    values = clean + load_v * (max(more, 0) * spike - (1 - case.load) * load)
    values += case.drift_v_s * rng.choice([-1, 1], CHANNELS) * t_s
    if case.creep:
        length_s = draw(0.5, 3)
        crept = lambda s: 1 - np.exp(-s.clip(0) / length_s)
        share = crept(np.minimum(after, truth.release_s - truth.contact_s)) * (1 - crept(t_s - truth.release_s))
        values += case.creep * tone_rms_v * share * load_v / np.sqrt(np.mean(load_v**2))
    if case.hum:
        size, phase = tone_rms_v * rng.uniform(0.5, 1.5, CHANNELS), rng.uniform(0, 2 * np.pi, CHANNELS)
        values += size * np.sin(2 * np.pi * rng.uniform(49.75, 50.25) * t_s + phase)
    if case.press:
        edge = (np.minimum(after, truth.release_s - t_s) / 0.1).clip(0, 1)
        values += case.press * edge * np.sin(2 * np.pi * draw(1, 3) * t_s + rng.uniform(0, 2 * np.pi)) * (clean - offset_v)
    shape = (1, *values.shape)
    own = windows.coloured(rng, shape, windows.PINK)[0] if case.pink else rng.standard_normal(values.shape)
    values += noise_v * own + CONVERTER_V * rng.standard_normal(values.shape)
    first = np.searchsorted(made.time_s, truth.contact_s + 1) if case.loaded else 0
    from_s = made.time_s[first]
    seen = None
    if slide_s:
        sigma_v = np.hypot(noise_v, CONVERTER_V)
        is_slide = (made.time_s >= truth.slide_start_s) & (made.time_s <= truth.slide_end_s)
        times_s, moved = made.time_s[is_slide], clean[is_slide]
        ends = [(times_s, moved), (times_s[::-1], moved[::-1])]
        # Search from either end inwards until enough of the motion has passed to show in the noise.
        shows = [times[min(np.searchsorted(np.cumsum(np.square((one - one[0]) / sigma_v).sum(1)), VISIBLE), len(times) - 1)] for times, one in ends]
        seen = truth.slide_start_s - from_s, truth.slide_end_s - from_s, shows[0] - from_s, shows[1] - from_s
    return values[first:], None if case.loaded else truth.contact_s - from_s, seen, truth.release_s - from_s


def overlap(a, b):
    return max(0.0, min(a[1], b[1]) - max(a[0], b[0]))


def judged(case, rng):
    """Compares the report of `replay` on a touch with its truth."""
    values, contact_s, slide, release_s = touch(case, rng)
    # One window a second is enough to judge the detector, and to find `good` windows outside
    # slides.
    settings = {"interferer_hz": 50.0 if case.mains else 0.0, "stride_s": 1.0}
    events = rt.replay(values, rate_hz=RATE_HZ, settings=settings)
    contacts = [one.t_s for one in events.contacts]
    slides = [(one.start_s, one.end_s) for one in events.slides]
    own = next((t for t in contacts if contact_s is not None and abs(t - contact_s) < CONTACT_S), None)
    release = next((one.t_s - release_s for one in events.releases if RELEASE_S[0] <= one.t_s - release_s < RELEASE_S[1]), None)
    good = [(one.t_s - one.window_s, one.t_s) for one in events.estimates if one.status == "good" and one.span == "window"]
    out = {
        "contact": contact_s is not None, "contact found": own is not None, "contact false": len(contacts) > (own is not None), "slide": slide is not None,
        "release found": release is not None, "good outside": any(overlap(one, slide[:2] if slide else (0, 0)) < 0.5 * (one[1] - one[0]) for one in good),
        "contact ms": None if own is None else 1000 * (own - contact_s), "release ms": None if release is None else 1000 * release,
    }  # fmt: skip
    best = max(slides, key=lambda one: overlap(one, slide[:2]), default=None) if slide else None
    is_found = best is not None and all(overlap(best, slide[:2]) > 0.5 * (one[1] - one[0]) for one in (best, slide))
    out["slide false"] = len(slides) > is_found
    # A slide reported in pieces does not count as found.
    out["slide found"] = is_found and len(slides) == 1
    out["near"] = out["near visible"] = False
    if out["slide found"]:
        start, end = best[0] - slide[0], best[1] - slide[1]
        off = max(slide[0] - best[0], best[0] - slide[2], slide[3] - best[1], best[1] - slide[1])
        out |= {"near": max(abs(start), abs(end)) <= NEAR_S, "near visible": off <= NEAR_S, "start ms": 1000 * start, "end ms": 1000 * end}
    return out


COUNTS = ("slide", "slide found", "slide false", "near", "near visible", "contact", "contact found", "contact false", "release found", "good outside")


def cell(found):
    """Returns counts of a case, and quantiles of its errors in ms: 5 %, median, 95 %."""
    counts = {"touches": len(found)} | {name: int(sum(one[name] for one in found)) for name in COUNTS}
    for name in ("contact ms", "start ms", "end ms", "release ms"):
        errors = [one[name] for one in found if one.get(name) is not None]
        counts[name] = [pages.fixed(np.quantile(errors, at), 0) for at in (0.05, 0.5, 0.95)] if errors else None
    return counts


FIGURES = {
    "slide found, %": ("slide found", "slide"), "false slides, %": ("slide false", "touches"), "both ends within 20 ms, %": ("near", "slide"),
    "within 20 ms of what shows, %": ("near visible", "slide"), "contact found, %": ("contact found", "contact"), "release found, %": ("release found", "touches"),
    "false contacts, %": ("contact false", "touches"), "good outside slides, %": ("good outside", "touches"),
}  # fmt: skip


def tables(cells):
    """Returns the worst case of each group, and the cases whose ends are badly located."""
    percents = {name: [pages.percent(of[count], of[all_of]) for count, all_of in FIGURES.values()] for name, of in cells.items()}
    groups = []
    for group in dict.fromkeys(name.split("/")[0] for name in cells):
        own = [row for name, row in percents.items() if name.startswith(f"{group}/")]
        worst = [(max if "false" in name or "outside" in name else min)((row[at] for row in own if row[at] is not None), default=None) for at, name in enumerate(FIGURES)]
        groups.append([group, len(own), *worst])
    median = lambda of: of and of[1]
    hard = [[name.split("/", 1)[1], *row[:4], median(cells[name]["start ms"]), median(cells[name]["end ms"])] for name, row in percents.items() if row[3] is not None and row[3] < 95]
    return {
        "groups": pages.table("|".join(["group", "cases", *FIGURES]), groups),
        "hard": pages.table("|".join(["case", *list(FIGURES)[:4], "start, median error, ms", "end, median error, ms"]), sorted(hard, key=lambda row: row[4])),
    }


def main():
    run = Run("touch", __doc__, 200, 30_000)
    cells = {}
    for case in run.progress(cases()):
        rng = run.rng(f"{case.group}/{case.name}")
        cells[f"{case.group}/{case.name}"] = cell([judged(case, rng) for _ in range(run.windows)])
    if not run.full:
        print("\n".join(pages.markdown(one) for one in tables(cells).values()))
    run.finish(cells, tables, lambda _: None)


if __name__ == "__main__":
    main()
