"""Noise that is not white, windows without a tone, a tone and something else, and extremes: docs/results/noise.md.

python lab/noise.py             all windows, and the page: some minutes
python lab/noise.py --short     a twentieth of the windows, against the requirements alone
"""

import fnmatch

import numpy as np

import campaign
import judge
import methods
import pages
from windows import CHANNELS, RIDGES, SINE, Tone, Windows, fits, frames, limits, make

WINDOWS_S = (0.2, 0.4, 1.0, 3.9)
WINDOWS = 200
SEED = 40_000
"""Seed of the page. Constants of the estimator are chosen with seeds up to 10,000."""
HARMONICS = 4

# Name, noise, disturbance and its size, in standard deviations of the noise because there is no
# tone.
NO_TONE = [
    ("white", "white", "", 0),
    ("impulses: 1 % of 20 sigma", "impulses", "", 0),
    ("one relaxation of 100 sigma", "white", "relaxation", 100),
    ("two relaxations of 100 sigma", "white", "relaxations", 100),
    ("logarithmic creep of 30 sigma", "white", "creep", 30),
    ("one step of 10 sigma", "white", "step", 10),
    ("one bump of 10 sigma", "white", "bump", 10),
    ("a contact spike's tail of 30 sigma", "white", "spike", 30),
    ("pink", "pink", "", 0),
    ("AR(1) of 0.9", "ar 0.9", "", 0),
    ("pink, the same in all channels", "shared pink", "", 0),
    ("pink, shared with random phases", "shared phases", "", 0),
    ("random walk, the same in all channels", "shared walk", "", 0),
    ("narrow band, shared with random phases", "narrow band", "", 0),
    ("mains of 30 sigma at 49.5 Hz, 50 Hz declared", "white", "mains", 30),
]
# Name, harmonics, disturbance and its size, in amplitudes of the tone.
SOMETHING = [
    ("nothing else", RIDGES, "", 0),
    ("a step of 3 amplitudes", RIDGES, "step", 3),
    ("a bump of 3 amplitudes", RIDGES, "bump", 3),
    ("a contact spike of 3 amplitudes", RIDGES, "spike", 3),
    ("a relaxation of 10 amplitudes", RIDGES, "relaxation", 10),
    ("the tone begins halfway", RIDGES, "half", 0),
    ("the tone falls tenfold", RIDGES, "decay", 0),
    ("a second tone as strong", SINE, "second", 0),
    ("mains of 3 amplitudes at 49.5 Hz, 50 Hz declared", RIDGES, "mains", 3),
    ("harmonics 1, 3, 5 of 0.3, 1, 0.4", (0.3, 0, 1, 0, 0.4), "", 0),
    ("two tones as strong, 0.4 to 0.8 cycles a window apart", SINE, "close", (0.4, 0.8)),
    ("a fundamental of 0.05 of the second", (0.05, 1, 0.2, 0.1), "", 0),
    ("harmonics 1, 2, 4 of 0.03, 1, 0.4", (0.03, 1, 0, 0.4), "", 0),
    ("harmonics 1, 2, 4 of 0.02, 1, 0.4", (0.02, 1, 0, 0.4), "", 0),
]
# Name, noise, disturbance and its size, in amplitudes of the tone.
SIGMA = [
    ("white", "white", "", 0),
    ("white, logarithmic creep of 30 amplitudes", "white", "creep", 30),
    ("impulses: 1 % of 20 sigma", "impulses", "", 0),
    ("pink", "pink", "", 0),
    ("AR(1) of 0.6", "ar 0.6", "", 0),
    ("AR(1) of 0.9", "ar 0.9", "", 0),
    ("pink, the same in all channels", "shared pink", "", 0),
    ("pink, shared with random phases", "shared phases", "", 0),
    ("rounded to a third of the amplitude", "white", "rounded", 0.33),
    ("gains over four decades", "white", "gains", 0),
    ("three dead channels, two without a tone", "white", "dead", 0),
    ("three channels clipped at a rail, two that stay there", "white", "saturated", 0),
]
KINDS = [
    "white",
    "impulses: 1 % of 20 sigma",
    "pink",
    "AR(1) of 0.9",
    "pink, the same in all channels",
    "pink, shared with random phases",
]
"""Noises in the first table."""
FEW = [
    *((cycles, 16) for cycles in (0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.25, 1.5)),
    *((cycles, few) for few in (4, 1) for cycles in (0.4, 0.5, 0.7, 0.9, 2)),
]
UNSTEADY = [("wander", 0.005), ("wander", 0.02), ("wander", 0.05), ("chirp", 0.05), ("chirp", 0.15)]
SNRS_DB = range(20, -17, -4)
HIDDEN_DB = (16, 8)
HIDDEN_EXTREMES = ("uniform, +-0.1 of a spacing", "uniform, +-0.2 of a spacing", "uniform, +-0.3 of a spacing", "normal, 0.1 of a spacing")
"""Rows that are not on the page, but in `noise.json`."""
FRACTIONS = [(1, 7), (1, 5), (1, 4), (1, 3), (2, 5)]


def cells():
    """Yields every test case: path, noise, tone, disturbance and its size."""
    few, drift = (1.0, 1.5), ("relaxation", 2 / 3)
    for name, kind, extra, size in NO_TONE:
        yield f"no_tone/{name}", kind, None, extra, size
    for name, harmonics, extra, size in SOMETHING:
        yield f"something/{name}", "white", Tone(harmonics=harmonics), extra, size
    for name, kind, extra, size in SIGMA:
        for snr_db in (20, 10):
            yield f"sigma/{name}/{snr_db} dB", kind, Tone(snr_db=snr_db), extra, size
    for name, cycles in (("1 to 1.5 cycles", few), ("from 1.5 cycles on", (1.5, np.inf))):
        for what, extra in (("", ("", 0)), (", a relaxation of up to one amplitude", drift)):
            for snr_db in (20, 10):
                yield f"accuracy/{name}{what}/{snr_db} dB", "white", Tone(cycles, snr_db=snr_db), *extra
    for cycles, channels in FEW:
        extra = ("channels", channels) if channels < CHANNELS else ("", 0)
        yield f"few_cycles/{cycles:g}/{channels} channels", "white", Tone((cycles, cycles)), *extra
    for speed, size in UNSTEADY:
        yield f"unsteady/{speed} of {100 * size:g} %", "white", Tone(speed=speed, change=size), "", 0


def movement(batch, found):
    """Counts the 95 % intervals of good and unsteady answers that cover the mean, the wander and
    the chirp."""
    sure = np.isin(found.status, ("good", "unsteady"))

    def holds(value, sigma, truth):
        return int((sure & (np.abs(value - truth) <= judge.NINETY_FIVE * sigma)).sum())

    lines = np.isfinite(batch.chirp)
    return {
        "sure": int(sure.sum()),
        "mean": holds(found.frequency_hz, found.sigma_hz, batch.frequency),
        "wander": holds(found.wander_percent, found.wander_sigma_percent, 100 * batch.wander),
        "lines": int((sure & lines).sum()),
        "chirp": holds(found.chirp_hz_per_s, found.chirp_sigma_hz_per_s, batch.chirp),
    }


def names_both(batch, found):
    """Counts the answers that name both tones, in either order, and the sure answers that do
    not."""

    def near(value, truth):
        return np.abs(value / truth - 1) <= judge.WRONG

    one, other = found.frequency_hz, found.other_tone_hz
    both = near(one, batch.frequency) & near(other, batch.second) | near(other, batch.frequency) & near(one, batch.second)
    sure = np.isin(found.status, ("good", "unsteady"))
    return {"second": int(both.sum()), "unnamed": int((sure & ~both).sum())}


def opponent(batch, every):
    """Returns the answers of harmonic least squares for white, independent noise on every n-th
    window."""
    return judge.Answers(*np.array([methods.nls(x, HARMONICS) for x in batch.x[::every]]).T)


def some(batch, every):
    """Returns every n-th window of a batch."""
    of = {name: value[::every] for name, value in vars(batch).items() if isinstance(value, np.ndarray)}
    return Windows(**of)


def measure(run):
    """Returns counts of every test case and window, for Ridgetone and for harmonic least
    squares."""
    found = {}
    for path, kind, tone, extra, size in run.progress(list(cells())):
        for window_s in WINDOWS_S:
            name = f"{path}/{window_s:g} s"
            # A press usually looks like one relaxation without a tone, so ten times as many windows
            # count its outliers to 0.1 %.
            many = run.windows * (10 if path.endswith("one relaxation of 100 sigma") else 1)
            batch = make(run.rng(name), many, frames(window_s), kind, tone, extra, size)
            answers = fits(batch, HARMONICS)
            found[name] = judge.count(batch, judge.of_fits(answers))
            if tone:
                found[name] |= movement(batch, answers)
            if batch.second is not None:
                found[name] |= names_both(batch, answers)
            _, kind_name, *snr = path.split("/")
            if kind_name in KINDS and path.startswith(("no_tone", "sigma")) and snr in ([], ["20 dB"]) and run.full:
                found[f"nls/{name}"] = judge.count(some(batch, 10), opponent(batch, 10))
    return found


def detection(run):
    """Measures detection probability by SNR and channels, in white noise and windows of 1 s."""
    found = {}
    for snr_db in run.progress(list(SNRS_DB), "detection"):
        for channels in (1, 4, 16):
            name = f"detection/{snr_db} dB/{channels} channels"
            batch = make(run.rng(name), run.windows, frames(1.0), "white", Tone((4, 30), snr_db=snr_db))
            batch.x, batch.crb, batch.luck = batch.x[:, :, :channels], None, None
            found[name] = judge.count(batch, judge.of_fits(fits(batch, HARMONICS)))
            # On pure tones, measure the lean scene too, and the padded FFT, which answers every
            # window.
            batch = make(run.rng(f"pure {name}"), run.windows, frames(1.0), "white", Tone((4, 30), harmonics=SINE, snr_db=snr_db))
            batch.x, batch.crb, batch.luck = batch.x[:, :, :channels], None, None
            found[f"lean {name}"] = judge.count(batch, judge.of_fits(fits(batch, harmonics=1, exclude=["all"])))
            found[f"fft {name}"] = judge.count(batch, judge.Answers(*np.array([methods.honest_fft(x) for x in batch.x]).T))
    return found


def uneven(run, name, offsets):
    """Fits rows at uneven times (in frames) that the fit knows."""
    rng = run.rng(name)
    many, count = run.windows, frames(1.0)
    tone = Tone((4, 30))
    batch = make(rng, many, count, "white", tone)
    out = []
    for w in range(many):
        t = np.sort(np.arange(count) + offsets(rng, count))
        phases, gains = rng.uniform(0, 2 * np.pi, (len(RIDGES), CHANNELS)), rng.uniform(0.5, 1.5, CHANNELS)
        angles = 2 * np.pi * batch.frequency[w] * np.arange(1, len(RIDGES) + 1)[:, None, None] * t[:, None] + phases[:, None, :]
        amplitude = np.sqrt(2) * 10 ** (tone.snr_db / 20) * gains
        x = (amplitude * np.asarray(RIDGES)[:, None, None] * np.cos(angles)).sum(0) + rng.standard_normal((count, CHANNELS))
        one = Windows(x[None], batch.frequency[[w]])
        slope = -(
            amplitude * np.asarray(RIDGES)[:, None, None] * np.arange(1, len(RIDGES) + 1)[:, None, None] * np.sin(angles)
        ).sum(0)
        limits(
            one,
            (2 * np.pi * (t - t.mean()))[None, :, None] * slope,
            one.x,
            np.zeros((1, count, 0)),
            judge.WHITE,
            tone,
            t - t.mean(),
        )
        fit = judge.single(x, t, HARMONICS)
        out.append((fit.status, fit.frequency_hz, fit.sigma_hz, one.crb[0], one.luck[0]))
    status, frequency, sigma, batch.crb, batch.luck = (
        np.array(column, dtype=None if at == 0 else float) for at, column in enumerate(zip(*out, strict=True))
    )
    return judge.count(batch, judge.Answers(frequency, sigma, status)) | worst(batch, frequency, sigma, status)


def worst(batch, frequency, sigma, status):
    """Returns the largest error of a good answer, in its own sigmas."""
    off = np.abs(frequency - batch.frequency) / sigma
    return {"worst_sigmas": float(f"{np.max(off[status == 'good'], initial=0):.3g}")}


def extremes(run):
    """Measures rows at uneven times, clipped and coarse channels, tones near fractions of the
    frame rate, and scaled values, in 1 s."""
    found = {}
    spacings = [
        (f"uniform, +-{size:g} of a spacing", lambda rng, n, size=size: rng.uniform(-size, size, n))
        for size in (0.1, 0.2, 0.3, 0.4)
    ]
    spacings += [(f"normal, {size:g} of a spacing", lambda rng, n, size=size: rng.normal(0, size, n)) for size in (0.1, 0.2)]
    for name, offsets in run.progress(spacings, "uneven rows"):
        found[f"extreme/uneven rows: {name}"] = uneven(run, name, offsets)
    batches = {}
    for what, extra, size in (
        ("all channels clipped at 0.4 of the mean amplitude", "clipped", 0.4),
        ("all channels clipped at 0.8 of the mean amplitude", "clipped", 0.8),
        ("three levels: rounded to the amplitude", "rounded", 1.0),
        ("five levels: rounded to half of the amplitude", "rounded", 0.5),
    ):
        batches[what] = make(run.rng(what), run.windows, frames(1.0), "white", Tone((4, 30)), extra, size)
    for p, q in FRACTIONS:
        what = f"within 0.2 % of {p}/{q} of the frame rate"
        cycles = frames(1.0) * p / q
        batches[what] = make(run.rng(what), run.windows, frames(1.0), "white", Tone((cycles * 0.998, cycles * 1.002)))
    plain = make(run.rng("scaled"), run.windows, frames(1.0), "white", Tone((4, 30)))
    scaled = Windows(plain.x * (1 + 3e-6), plain.frequency, crb=plain.crb, luck=plain.luck)
    batches["the same windows, all values times 1 + 3e-6"] = scaled
    for what, batch in run.progress(list(batches.items()), "extremes"):
        answers = fits(batch, HARMONICS)
        found[f"extreme/{what}"] = judge.count(batch, judge.of_fits(answers)) | worst(
            batch, answers.frequency_hz, answers.sigma_hz, answers.status
        )
        if batch is scaled:
            before = fits(plain, HARMONICS)
            same = (before.status == answers.status) & ~(
                np.abs(before.frequency_hz - answers.frequency_hz) > 0.1 * before.sigma_hz
            )
            found[f"extreme/{what}"]["changed"] = int((~same).sum())
    return found


def tables(found):
    percent = pages.percent

    def kind(name, window_s):
        with_tone, without = found[f"sigma/{name}/20 dB/{window_s:g} s"], found[f"no_tone/{name}/{window_s:g} s"]
        nls, none = found[f"nls/sigma/{name}/20 dB/{window_s:g} s"], found[f"nls/no_tone/{name}/{window_s:g} s"]
        return [
            name, pages.significant(window_s, 3), pages.fixed(with_tone.get("over_crb"), 2), percent(with_tone["covered"], with_tone["good"]),
            percent(with_tone["windows"] - with_tone["good"], with_tone["windows"]), percent(without["good"], without["windows"]),
            pages.fixed(nls.get("over_crb"), 2), percent(nls["covered"], nls["good"]), percent(none["good"], none["windows"]),
        ]  # fmt: skip

    def extreme(path, cell):
        return [
            path.partition("/")[2], percent(cell["good"], cell["windows"]), cell["wrong"], percent(cell["covered"], cell["good"]),
            pages.fixed(cell.get("over_crb"), 2), pages.significant(cell["worst_sigmas"], 2),
        ]  # fmt: skip

    def something(name):
        short, second = (found[f"something/{name}/{window_s:g} s"] for window_s in (0.4, 1.0))
        both = [[percent(cell["good"], cell["windows"]), percent(cell["wrong"], cell["windows"])] for cell in (short, second)]
        return [name, *both[0], *both[1]]

    def detected(snr_db):
        at = [found[f"{who}detection/{snr_db} dB/{channels} channels"] for who in ("", "lean ", "fft ") for channels in (1, 4, 16)]
        return [
            snr_db,
            *(percent(cell["good"] - cell["wrong"], cell["windows"]) for cell in at),
            sum(cell["wrong"] for cell in at[:3]),
            sum(cell["wrong"] for cell in at[3:6]),
        ]

    return {
        "kinds": pages.table(
            "noise|window, s|RMS over CRB|coverage, %|unanswered, %|false positives, %|NLS: RMS over CRB|coverage, %|false positives, %",
            [kind(name, window_s) for name in KINDS for window_s in WINDOWS_S],
        ),
        "short": pages.table(
            "noise|window, s|RMS over CRB|coverage, %|unanswered, %|false positives, %|NLS: RMS over CRB|coverage, %|false positives, %",
            [kind(name, window_s) for name in KINDS for window_s in (0.4, 1.0)],
        ),
        "something": pages.table(
            "next to the tone|0.4 s: good, %|outliers called `good`, %|1 s: good, %|outliers called `good`, %",
            [something(name) for name, *_ in SOMETHING],
        ),
        "detection": pages.table("SNR, dB|1 channel, %|4, %|16, %|lean: 1 channel, %|4, %|16, %|FFT: 1 channel, %|4, %|16, %|outliers called `good`|lean", [detected(snr) for snr in SNRS_DB if snr not in HIDDEN_DB]),
        "extremes": pages.table(
            "extreme|good, %|outliers called `good`|coverage, %|RMS over CRB|worst, sigmas",
            [extreme(path, cell) for path, cell in found.items() if path.startswith("extreme/") and not path.endswith(HIDDEN_EXTREMES)],
        ),
    }  # fmt: skip


def values(found):
    """Returns values used in sentences: ranges of percentages over the cells that match a
    pattern."""

    def span(pattern, count, of="windows", less=False):
        cells = [cell for name, cell in found.items() if fnmatch.fnmatchcase(name, pattern) and cell[of]]
        percents = sorted(round(100 * (cell[of] - cell[count] if less else cell[count]) / cell[of]) for cell in cells)
        return f"{percents[0]} to {percents[-1]}" if percents[0] < percents[-1] else f"{percents[0]}"

    return {
        "narrow_band": span("no_tone/narrow band*", "good"),
        "two_tones": span("something/two tones*", "unnamed"),
        "faint": span("something/harmonics 1, 2, 4*/0.4 s", "wrong"),
        "halfway": span("something/the tone begins halfway/*", "good"),
        "bump": span("something/a bump*", "good", less=True),
        "coloured_unanswered": span("sigma/[pA][iR]*[k)9]/20 dB/*", "good", less=True),
        "ar_coverage": span("sigma/AR*", "covered", "good"),
        "pink_coverage": span("sigma/pink/*", "covered", "good"),
        "shared_coverage": span("sigma/pink,*", "covered", "good"),
        "creep_unanswered": span("sigma/white, log*", "good", less=True),
        "few_wrong": span("few_cycles/0.*", "wrong"),
        "first_cycles": span("accuracy/1 to*", "good", less=True),
        "wander_mean": span("unsteady/wander*", "mean", "sure"),
        "wander_long": span("unsteady/wander*/3.9 s", "wander", "sure"),
        "chirp": span("unsteady/chirp*", "chirp", "lines"),
        "detected_1": span("detection/-8 dB/1 *", "good"),
        "uneven": span("extreme/uneven rows: uniform, +-0.4*", "covered", "good"),
        "clipped": span("extreme/all channels clipped at 0.4*", "covered", "good"),
        "fractions": span("extreme/within*", "covered", "good"),
        "two_fifths": span("extreme/within*2/5*", "wrong"),
    }


def draw(found):
    """Draws RMS error over CRB by window, for Ridgetone and for harmonic least squares."""
    import plots

    figure, (axis,) = plots.panels()
    plots.ticks(axis, WINDOWS_S, " s")
    axis.set_yscale("log")
    axis.set_title("RMS error over the Cramer-Rao bound of the noise's whole covariance")
    drawn = {"white": "white", "pink": "pink", "pink, the same in all channels": "shared pink"}
    for number, (name, shown) in enumerate(drawn.items()):
        for who, path in (("Ridgetone", ""), ("NLS", "nls/")):
            ratios = [found[f"{path}sigma/{name}/20 dB/{window_s:g} s"].get("over_crb", np.nan) for window_s in WINDOWS_S]
            plots.curve(axis, WINDOWS_S, ratios, f"{who}: {shown}", number, dashed=bool(path))
    plots.save(figure, "noise", "Error over the bound in noise of three kinds")


def main():
    run = campaign.Run("noise", __doc__, WINDOWS, SEED)
    run.finish(run.cells(measure, detection, extremes), tables, draw, values)


if __name__ == "__main__":
    main()
