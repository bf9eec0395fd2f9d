"""Tests windows, methods, judgement and pages against closed forms; `cargo xtask results
--short` runs them."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

import judge
import methods
import pages
import windows as w

NOISES = ["white", "pink", "ar 0.9", "shared pink", "shared phases"]


@pytest.mark.parametrize("kind", NOISES)
def test_the_bound_is_that_of_the_whole_covariance_as_a_matrix(kind):
    tone, count = w.Tone((2, 6), (1, 0.4)), 40
    found = w.make(np.random.default_rng(5), 3, count, kind, tone)
    rng = np.random.default_rng(5)
    _, covariance = w.noise(rng, kind, 3, count)
    course = w.courses(rng, tone, 3, count)
    slope = w.sound(rng, course, np.sqrt(2) * 10 * np.asarray(tone.harmonics), rng.uniform(0.5, 1.5, (3, w.CHANNELS)))[1]
    lag = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    over_time = sum((variance * factor**lag for factor, variance in covariance.parts), np.zeros((count, count)))
    for at in range(3):
        across = np.eye(w.CHANNELS) if covariance.gains is None else covariance.gains[at] @ covariance.gains[at].T
        whole = np.kron(across, over_time) + covariance.white * np.eye(w.CHANNELS * count)
        t = np.arange(count)
        own = np.column_stack([np.ones(count), t / count, w.waves(t, found.frequency[at], 2)])
        unknowns = np.column_stack([slope[at].T.ravel(), np.kron(np.eye(w.CHANNELS), own)])
        information = unknowns.T @ np.linalg.solve(whole, unknowns)
        assert found.crb[at] == pytest.approx(np.sqrt(np.linalg.inv(information)[0, 0]), rel=1e-6)


@pytest.mark.parametrize("kind", NOISES)
def test_the_error_on_the_bound_has_the_mean_square_of_the_bound(kind):
    found = w.make(np.random.default_rng(1), 400, 96, kind, w.Tone((2, 6), (1, 0.4)))
    # Within four standard deviations of a chi-square with 400 degrees of freedom, divided by its
    # mean.
    assert 0.72 < np.mean(np.square(found.luck / found.crb)) < 1.28


@pytest.mark.parametrize(
    ("kind", "square", "next_frame", "next_channel"),
    [
        ("white", 1, 0, 0),
        ("impulses", 5, 0, 0),
        ("ar 0.9", 1, 0.9, 0),
        ("ar 0.6", 1, 0.6, 0),
        ("shared pink", 13 / 12, None, 12 / 13),
        ("shared phases", 13 / 12, None, 0),
    ],
)
def test_a_noise_has_the_moments_of_its_definition(kind, square, next_frame, next_channel):
    x, _ = w.noise(np.random.default_rng(3), kind, 60, 1000)
    mean = np.mean(x**2)
    assert mean == pytest.approx(square, rel=0.15)
    assert next_frame is None or np.mean(x[:, 1:] * x[:, :-1]) / mean == pytest.approx(next_frame, abs=0.01)
    assert np.mean(x[:, :, 1:] * x[:, :, :-1]) / mean == pytest.approx(next_channel, abs=0.1)


def test_pink_noise_has_as_much_power_in_each_octave():
    x, _ = w.noise(np.random.default_rng(5), "pink", 20, 1024)
    power = np.square(np.abs(np.fft.rfft(x, axis=1))).mean((0, 2))
    octaves = np.array([power[8 << k : 16 << k].sum() for k in range(6)])
    assert np.all((octaves / octaves.mean() > 0.5) & (octaves / octaves.mean() < 2))


@pytest.mark.parametrize("name", [*methods.METHODS])
@pytest.mark.parametrize("cycles", [5.3, 9.8])
def test_a_method_finds_a_pure_tone(name, cycles):
    batch = w.finger(np.random.default_rng(2), 4, 241, cycles / 241, w.SINE, 60.0)
    for x in batch.x:
        frequency, sigma = methods.METHODS[name](x)
        # A parabola through the spectrum of a Hann window has its own error.
        assert frequency == pytest.approx(cycles / 241, rel=2e-3 if name == "honest FFT" else 2e-4)
        assert not np.isfinite(sigma) or 0.2 < sigma / batch.crb[0] < 5


def test_the_package_gives_one_row_for_each_window_of_a_batch():
    batch = w.finger(np.random.default_rng(2), 7, 96, 8.2 / 241, w.RIDGES)
    found = w.fits(batch)
    assert len(found) == 7 and found.amplitude.shape == (7, w.CHANNELS)
    assert np.all(np.abs(found.frequency_hz - batch.frequency) < 5 * batch.crb)


def test_answers_are_counted():
    batch = w.Windows(np.zeros((4, 1, 1)), np.full(4, 10.0), crb=np.full(4, 0.1), luck=np.zeros(4))
    found = judge.count(
        batch, judge.Answers([10.1, 10.3, 20.0, np.nan], [0.1] * 4, np.array(["good", "good", "good", "no_tone"]))
    )
    assert {name: found[name] for name in ("windows", "good", "wrong", "covered", "octaves")} == {
        "windows": 4,
        "good": 3,
        "wrong": 1,
        "covered": 1,
        "octaves": 1,
    }
    assert found["rms_percent"] == pytest.approx(100 * np.sqrt((0.01**2 + 0.03**2 + 1) / 3), rel=1e-3)


COUNT = {"name": "wrong", "count": "wrong", "of": "windows"}


@pytest.mark.parametrize(
    ("requirement", "cell", "verdict"),
    [
        (COUNT | {"max": 1}, {"wrong": 2, "windows": 200}, None),
        (COUNT | {"max": 1}, {"wrong": 1, "windows": 10}, "luck"),
        (COUNT | {"max": 1}, {"wrong": 4, "windows": 10}, "missed"),
        (COUNT | {"max": 0}, {"wrong": 1, "windows": 10}, "missed"),
        (COUNT | {"min": 90}, {"wrong": 8, "windows": 10}, "luck"),
        (COUNT | {"min": 90}, {"wrong": 2, "windows": 10}, "missed"),
        (COUNT | {"min": 90}, {"wrong": 0, "windows": 0}, None),
        ({"value": "ratio", "sigma": "spread", "max": 1.05}, {"ratio": 1.2, "spread": 0.1}, "luck"),
        ({"value": "ratio", "sigma": "spread", "max": 1.05}, {"ratio": 1.2, "spread": 0.01}, "missed"),
        ({"value": "ratio", "max": 10}, {"ratio": 11}, "missed"),
    ],
)
def test_a_requirement_is_missed_beyond_its_error_alone(requirement, cell, verdict):
    assert judge.missed(requirement, cell)[1] == verdict


def test_a_known_miss_must_not_get_worse(tmp_path):
    text = '[[requirement]]\ntopic = "t"\nname = "n"\ncells = ["a/*"]\ncount = "wrong"\nof = "windows"\nmax = 1\n[requirement.known]\n"a/b" = 30\n'
    (tmp_path / "requirements.toml").write_text(text)
    for name, wrong, failed in (("a/b", 60, 0), ("a/b", 120, 1), ("a/c", 60, 1), ("c", 200, 0)):
        _, failures = judge.requirements("t", {name: {"wrong": wrong, "windows": 200}}, tmp_path)
        assert len(failures) == failed, name


def test_tables_and_values_are_filled_in_and_unknown_ones_refused(tmp_path):
    (tmp_path / "t.md").write_text(
        "<!-- rows: 0 2 -->\nold\n<!-- end -->\nIt takes <!-- value: s -->2<!-- end --> s.\n".replace("old\n", "")
    )
    made = pages.table("a|b|c", [["x", 1, 12345], ["y", None, 0.5]])
    pages.save("t", {"rows": made}, {"s": "3"}, folder=tmp_path)
    page = (tmp_path / "t.md").read_text()
    assert (
        page
        == "<!-- rows: 0 2 -->\n| a | c |\n|---|---:|\n| x | 12,345 |\n| y | 0.5 |\n<!-- end -->\nIt takes <!-- value: s -->3<!-- end --> s.\n"
    )
    assert pages.filled(page, "t", tmp_path) == page
    assert pages.filled("<!-- value: t.s -->9<!-- end -->", "other", tmp_path) == "<!-- value: t.s -->3<!-- end -->"
    for wrong in ("<!-- value: none -->2<!-- end -->", "<!-- none -->\n<!-- end -->"):
        with pytest.raises(KeyError):
            pages.filled(wrong, "t", tmp_path)
