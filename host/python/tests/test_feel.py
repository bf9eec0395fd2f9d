"""Firing of mechanoreceptors: the paper's numbers, closed forms, and uncertainties against the scatter of many runs."""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import ridgetone as rt

Array = npt.NDArray[np.float64]

RATE_HZ = 2048
# Constants of table 1 and equations 1 to 4. Each threshold (um against Hz) is two lines on
# logarithmic axes: their factors and exponents, then the frequencies at which they begin, meet and
# end.
THRESHOLDS = {
    "FA I": (499, -0.890, 52.1, 0.0119, 0.5, 12.2, 67.0),
    "FA II": (1690, -1.93, 2.00e-5, 1.39, 20.0, 241.0, 800.0),
    "SA I": (43.5, -0.545, 0.787, 0.683, 0.5, 26.2, 120.0),
    "SA II": (501, -0.783, 17.1, -0.0340, 0.5, 91.2, 400.0),
}


def decades(receptor: str, um: float, hz: float) -> float:
    a, a_slope, b, b_slope, first, bend, last = THRESHOLDS[receptor]
    threshold_um = a * hz**a_slope if hz <= bend else b * hz**b_slope
    return max(0.0, np.log10(um / threshold_um)) if first < hz <= last else 0.0


def tone(um: float, hz: float, seconds: float = 3.0, rate_hz: float = RATE_HZ) -> Array:
    return um * np.cos(2 * np.pi * hz * np.arange(round(seconds * rate_hz)) / rate_hz + 0.7)


def intensities(felt: rt.Felt) -> dict[str, tuple[float, float]]:
    return {one.receptor: (one.intensity, one.intensity_sigma) for one in felt.receptors}


def test_a_vibration_of_known_amplitude_is_a_sum_of_logarithms() -> None:
    # A Hamming window spreads the tone over three bins, a third of a hertz apart.
    lines = [(40 - 1 / 3, 30 * 0.23 / 0.54), (40, 30), (40 + 1 / 3, 30 * 0.23 / 0.54)]
    volts = 2.5 + 2e-6 * tone(30, 40)
    felt = rt.feel(np.c_[volts, volts], RATE_HZ, volts_per_um=2e-6, m=(1.2, 0.1))
    for receptor, (intensity, sigma) in intensities(felt).items():
        expected = sum(decades(receptor, um, hz) for hz, um in lines)
        assert intensity == pytest.approx(expected, abs=2e-5) and (sigma > 0) == (expected > 0)
    (fa2, _), (sa1, _) = intensities(felt)["FA II"], intensities(felt)["SA I"]
    soft, rough = felt.scores
    assert soft.score == pytest.approx(5.59 - 0.002 * sa1) and soft.name == "soft"
    assert rough.score == pytest.approx(-16.075 + 0.011 * fa2 + 11.633 * 1.2, abs=1e-4)
    assert rough.score_sigma == pytest.approx(1.1633, rel=1e-3) and (felt.m, felt.m_sigma) == (1.2, 0.1)
    # The same tone in a different unit, with an additional channel that is not converted.
    with_noise = np.c_[2e3 * tone(30, 40), np.random.default_rng(1).normal(size=3 * RATE_HZ)]
    again = rt.feel(with_noise, RATE_HZ, volts_per_um=[2e3, np.nan])
    assert again.receptors == felt.receptors and again.channels == ["ch0"] and again.scores[1].absent == "needs m"
    gaps = volts.copy()
    gaps[100:200:7] = np.nan
    missing = intensities(rt.feel(gaps, RATE_HZ, volts_per_um=2e-6))
    assert missing["FA II"][0] == pytest.approx(intensities(felt)["FA II"][0], abs=0.2)


def test_a_slow_recording_or_a_short_window_says_what_is_needed() -> None:
    felt = rt.feel(tone(30, 40, rate_hz=241), 241, volts_per_um=1)
    assert [one.get("absent") for one in felt.receptors] == [None, "needs more than 1600 rows a second", None, "needs more than 800 rows a second"]
    assert felt.receptors[1].intensity is None and felt.scores[1].absent == "needs FA II"
    felt = rt.feel(tone(30, 40, 0.0064, 10_000), 10_000, volts_per_um=1)
    assert [one.get("absent") for one in felt.receptors] == ["needs a longer window", None, "needs a longer window", None]


def test_the_papers_conversion() -> None:
    # Section 3.2: 0.313 V on a plate of Ra 0.278 um and RSm 0.121 mm give 82.8 Hz and 0.564 V/um.
    volts = tone(0.313, 10 / 0.121) + 1e-4 * np.random.default_rng(2).normal(size=3 * RATE_HZ)
    found = rt.volts_per_um(np.c_[volts, 1e-9 * volts], RATE_HZ, ra_um=0.278, rsm_mm=0.121, speed_mm_s=10, ra_sigma_um=0.0278)
    assert found.frequency_hz == pytest.approx(82.8, abs=0.2)
    assert found.volts_per_um[0] == pytest.approx(0.564, abs=0.002) and found.sigma_fraction[0] == pytest.approx(0.1, rel=1e-3)
    assert found.volts_per_um[1] == pytest.approx(1e-9 * found.volts_per_um[0], rel=1e-5)
    # Leakage of a line between two bins must not count as an amplitude.
    with pytest.raises(rt.Error, match="no channel has a line at 20 Hz"):
        rt.volts_per_um(tone(1, 300.5), RATE_HZ, ra_um=1, rsm_mm=0.5, speed_mm_s=10)


def spread(values: list[float], sigmas: list[float]) -> float:
    """Returns the ratio of the scatter to the root of the mean reported variance."""
    return float(np.std(values, ddof=1) / np.sqrt(np.mean(np.square(sigmas))))


def noises(seed: int, runs: int, rows: int) -> Iterator[Array]:
    random = np.random.default_rng(seed)
    return (random.normal(size=rows) for _ in range(runs))


@pytest.mark.parametrize(
    ("um", "line_um", "receptors", "least", "most"),
    [
        # About 5000 um per bin, above all thresholds.
        (2.5e5, 0, list(THRESHOLDS), 0.9, 1.1),
        # About 10 um per bin, close to SA I's threshold.
        (500, 0, ["SA I"], 0.5, 1.05),
        # A steady tone 40 dB above the noise: the closed form is an upper bound.
        (0.001, 1, ["FA II"], 0, 0.3),
    ],
    ids=["loud", "near", "tone"],
)
def test_the_closed_form_of_one_window(um: float, line_um: float, receptors: list[str], least: float, most: float) -> None:
    line = tone(line_um, 250)
    found = [intensities(rt.feel(line + um * noise, RATE_HZ, volts_per_um=1)) for noise in noises(1, 300, len(line))]
    for receptor in receptors:
        ratio = spread(*zip(*(one[receptor] for one in found), strict=True))  # type: ignore[arg-type]
        assert least <= ratio < most, (receptor, ratio)


def test_the_scatter_of_several_windows() -> None:
    # 17 windows of 3 s that overlap by half.
    found = [intensities(rt.feel(1e5 * noise, 250, volts_per_um=1))["SA I"] for noise in noises(4, 150, 750 * 9)]
    ratio = spread(*zip(*found, strict=True))  # type: ignore[arg-type]
    assert 0.9 < ratio < 1.2, ratio


def test_the_conversions_uncertainty_is_part_of_the_scores() -> None:
    scores, sigmas, conversions, fractions = [], [], [], []
    random = np.random.default_rng(5)
    for noise in noises(6, 200, 3 * RATE_HZ):
        reference = tone(1, 100) + 10 * random.normal(size=len(noise))
        known = rt.volts_per_um(reference, RATE_HZ, ra_um=0.5, rsm_mm=0.1, speed_mm_s=10)
        felt = rt.feel(
            2.5e5 * noise, RATE_HZ, volts_per_um=known.volts_per_um, sigma_fraction=known.sigma_fraction, m=(1.2 + 0.1 * random.normal(), 0.1)
        )
        conversions.append(np.log(known.volts_per_um[0]))
        fractions.append(known.sigma_fraction[0])
        scores.append(felt.scores[1].score)
        sigmas.append(felt.scores[1].score_sigma)
    assert 0.85 < spread(conversions, fractions) < 1.15
    assert 0.85 < spread(scores, sigmas) < 1.15


@pytest.mark.parametrize(("um", "line_um"), [(250, 0), (7.5, 0), (7.5, 3), (1e-3, 3)], ids=["far above", "near", "line in noise", "line"])
def test_one_surface_has_one_score_from_windows_of_any_length(um: float, line_um: float) -> None:
    [noise] = noises(7, 1, 30 * RATE_HZ)
    samples = tone(line_um, 256, 30) + um * noise
    found = []
    for window_s in (3, 0.5, 0.25, 0.125, 0.0625):
        rough = rt.feel(samples, RATE_HZ, volts_per_um=1, sigma_fraction=0.02, m=1, window_s=window_s).scores[1]
        found.append((rough.score, rough.score_sigma))
    for value, sigma in found[1:]:
        assert abs(value - found[0][0]) < 3 * np.hypot(sigma, found[0][1]), found


@pytest.mark.parametrize("line_um", [3, 0.3, 0])
def test_one_reference_has_one_conversion_from_windows_of_any_length(line_um: float) -> None:
    found = []
    for seconds in (3, 0.5, 0.125):
        per_um = []
        for noise in noises(8, 60, round(seconds * RATE_HZ)):
            samples = tone(line_um, 100, seconds) + noise
            # Without a line, a few runs have less amplitude than leakage, and are refused.
            try:
                per_um.append(rt.volts_per_um(samples, RATE_HZ, ra_um=0.5, rsm_mm=0.1, speed_mm_s=10))
            except rt.Error:
                continue
        assert len(per_um) > 40
        values = [one.volts_per_um[0] for one in per_um]
        sigmas = [one.volts_per_um[0] * one.sigma_fraction[0] for one in per_um]
        found.append((np.mean(values), np.sqrt(np.mean(np.square(sigmas)))))
    for value, sigma in found[1:]:
        assert abs(value - found[0][0]) < 2 * np.hypot(sigma, found[0][1]), found


def test_rows_with_stamps(tmp_path: Path) -> None:
    samples, t_s = tone(30, 40), np.arange(3 * RATE_HZ) / RATE_HZ
    expected = rt.feel(samples, RATE_HZ, volts_per_um=1)
    by_stamps = rt.feel(samples, time_s=t_s, volts_per_um=1)
    assert by_stamps.rate_hz == pytest.approx(RATE_HZ) and intensities(by_stamps)["SA I"] == pytest.approx(intensities(expected)["SA I"], rel=1e-4)
    is_there = np.arange(len(t_s)) % 100 > 2
    gaps = rt.feel(samples[is_there], time_s=t_s[is_there], volts_per_um=1)
    assert intensities(gaps)["SA I"][0] == pytest.approx(intensities(expected)["SA I"][0], rel=0.02)
    path = tmp_path / "slide.csv"
    path.write_text("time_s,a,force\n" + "".join(f"{t:.6f},{v:.6f},1\n" for t, v in zip(t_s, samples, strict=True)))
    printed = subprocess.run(
        [sys.executable, "-m", "ridgetone", "feel", path, "--columns", "a", "--volts-per-um", "1", "--m", "1.2", "--m-sigma", "0.1", "--json"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert json.loads(printed.stdout) == rt.feel(path, columns=["a"], volts_per_um=1, m=(1.2, 0.1))
    surface = ["--reference", path, "--ra-um", "15", "--rsm-mm", "0.25", "--speed-mm-s", "10"]
    printed = subprocess.run([sys.executable, "-m", "ridgetone", "feel", path, "--columns", "a", *surface], capture_output=True, text=True, check=True)
    assert "SA II" in printed.stdout and "soft" in printed.stdout
    refused = subprocess.run([sys.executable, "-m", "ridgetone", "feel", tmp_path / "none.csv", "--volts-per-um", "1"], capture_output=True, text=True)
    assert refused.returncode == 1 and "none.csv" in refused.stderr and len(refused.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: rt.feel(tone(1, 40), volts_per_um=1), "give rate_hz, or time_s"),
        (lambda: rt.feel(tone(1, 40), RATE_HZ, volts_per_um=0), "greater than 0"),
        (lambda: rt.feel(tone(1, 40), RATE_HZ, volts_per_um=[1, 2]), "2 values for 1 channels"),
        (lambda: rt.feel(tone(1, 40), RATE_HZ, volts_per_um=1e-30), "no vibration of skin"),
        (lambda: rt.feel(tone(1, 40), RATE_HZ, volts_per_um=1, window_s=0.01), "20 rows at 2048 Hz"),
        (lambda: rt.feel(tone(1, 40), RATE_HZ, volts_per_um=1, from_s=2.99), "20 rows: at least 64"),
        (lambda: rt.feel(tone(1, 40), RATE_HZ, volts_per_um=1, columns=["a"]), "no column a: choose from ch0"),
        (lambda: rt.feel(tone(1, 40), -1, volts_per_um=1), "rate_hz=-1"),
        (lambda: rt.feel(np.full(100, np.nan), 100, volts_per_um=1), "ch0 has no reading"),
        (lambda: rt.feel(np.zeros(100), time_s=np.arange(100) ** 1.5, volts_per_um=1), "not evenly spaced"),
        (lambda: rt.feel(np.zeros(100), time_s=[*range(99), 1e12], volts_per_um=1), "half of them are missing"),
        (lambda: rt.volts_per_um(tone(1, 40), RATE_HZ, ra_um=0, rsm_mm=1, speed_mm_s=1), "greater than 0"),
        (lambda: rt.volts_per_um(tone(1, 40), RATE_HZ, ra_um=1, rsm_mm=1e-3, speed_mm_s=10), "1e\\+04 Hz: choose from 0.3333 Hz"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_refused(call: "object", words: str) -> None:
    with pytest.raises(rt.Error, match=words):
        call()  # type: ignore[operator]
