"""Compares frames of the simulated finger with the command's, and their stated true values with the frames."""

import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import ridgetone as rt

from conftest import ROOT, SCENES, Run

# Conversions per scan: 16 taxels and five of the chip's own readings.
SLOTS = 21


@pytest.mark.parametrize("name", ["c1", "c10"])
def test_a_replay_is_what_the_emulated_board_reports(name: str, run: Run) -> None:
    path = ROOT / f"hal-mock/scenes/{name}.toml"
    found = rt.simulate(path)
    # The command plays the scene to the same chip, so it reports the events of these frames, except
    # that each channel has its own time in a scan.
    events = run("emulate", path, "--json")
    [contact] = [event for event in events if event["type"] == "contact"]
    [end] = [event for event in events if event["type"] == "slide" and event["end_s"] is not None]
    replayed = rt.replay(found)
    assert replayed.contacts[0].t_s == pytest.approx(contact["t_s"], abs=5e-3)
    assert replayed.slides[0].start_s == pytest.approx(end["start_s"], abs=5e-3)
    assert replayed.slides[0].end_s == pytest.approx(end["end_s"], abs=5e-3)
    [whole] = [event for event in events if event["type"] == "estimate" and event["span"] == "slide"]
    [own] = [one for one in replayed.estimates if one.span == "slide"]
    assert abs(own.frequency_hz - whole["frequency_hz"]) < 0.3 * whole["sigma_hz"] + 1e-6 * whole["frequency_hz"]


def test_raw_frames_of_a_board_are_these(telemetry: dict[str, Path]) -> None:
    # The emulated board plays the first scene.
    board = rt.read(telemetry["rec"])
    found = rt.simulate(ROOT / "hal-mock/scenes/c1.toml")
    # On a busy computer the recording begins some frames after the scene.
    at = np.rint(board.time_s * found.scan_hz).astype(int)
    rows = at < len(found.values)
    assert rows.sum() > 1000
    # Volts are f32; the recording has their shortest decimals.
    np.testing.assert_array_equal(board.values[rows].astype(np.float32), found.values[at[rows]].astype(np.float32))
    np.testing.assert_allclose(board.time_s[rows], found.time_s[at[rows]] - found.time_s[0], atol=5e-6)


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_is_the_same_as_file_text_and_mapping(name: str) -> None:
    path = ROOT / f"hal-mock/scenes/{name}.toml"
    settings = {"plan": "hand"} if name == "hand" else None
    by = [rt.simulate(one, settings=settings, converter=False) for one in (path, path.read_text(), tomllib.loads(path.read_text()))]
    for other in by[1:]:
        np.testing.assert_array_equal(by[0].values, other.values)
        assert by[0].truth == other.truth
    assert by[0].values.shape == (len(by[0].time_s), 16) == (len(by[0].position_mm), 16)


def test_the_truth_is_seen_in_the_frames() -> None:
    # Without noise, the frequency is speed over period, and positions follow the speed.
    scene = {"period_mm": 3.1, "speed_mm_s": 20, "slide_mm": 40, "finger": {"noise_uv": 0.0}}
    found = rt.simulate(scene, converter=False)
    truth = found.truth
    assert truth.frequency_hz == pytest.approx(20 / 3.1)
    assert truth.slide_end_s - truth.slide_start_s == pytest.approx(40 / 20 + 0.02)
    is_slide = (found.time_s > truth.slide_start_s + 0.05) & (found.time_s < truth.slide_end_s - 0.05)
    np.testing.assert_allclose(np.gradient(found.position_mm, found.time_s)[is_slide], 20, rtol=1e-6)
    assert np.ptp(found.position_mm) == pytest.approx(40)
    fitted = rt.fit(found.values[is_slide], found.scan_hz)
    assert fitted.frequency_hz == pytest.approx(truth.frequency_hz, rel=1e-4)
    idle = found.values[found.time_s < truth.contact_s - 0.05]
    np.testing.assert_allclose(idle, np.broadcast_to([one.offset_v for one in found.channels], idle.shape), atol=1e-9)


def test_random_channels_have_the_amplitudes_that_are_told() -> None:
    found = rt.simulate({"seed": 5, "snr_db": 60.0}, random_channels=True, converter=False)
    truth = found.truth
    is_slide = (found.time_s > truth.slide_start_s + 0.05) & (found.time_s < truth.slide_end_s - 0.05)
    # Fit by least squares against the position at the time of each channel's own slot.
    for taxel, channel in enumerate(found.channels):
        at_mm = found.position_mm[is_slide] + 30 * taxel / SLOTS / found.scan_hz
        turns = 2 * np.pi * at_mm / 3.6
        basis = np.stack([np.ones_like(turns), *(part(h * turns) for h in (1, 2, 3, 4) for part in (np.cos, np.sin))], axis=1)
        parts = np.linalg.lstsq(basis, found.values[is_slide, taxel], rcond=None)[0]
        assert np.hypot(parts[1], parts[2]) == pytest.approx(channel.tone_v, rel=0.01)
        assert parts[0] - channel.offset_v == pytest.approx(channel.load_v, abs=5e-3 * abs(channel.load_v))
    power = np.mean([one.tone_v**2 for one in found.channels]) / 2
    assert found.noise_v == pytest.approx(np.sqrt(power / 1e6))
    still = rt.simulate({"seed": 5, "snr_db": 60.0}, random_channels=True, converter=False).values
    np.testing.assert_array_equal(still, found.values)
    assert not np.array_equal(rt.simulate({"seed": 5}, random_channels=True, seed=6, converter=False).values, found.values)


def test_the_converters_noise_is_the_data_sheets() -> None:
    # The converter has noise of 4.5 uV rms at the scan's data rate (SBAS297G); the finger has none
    # here.
    scene = {"finger": {"noise_uv": 0.0}, "idle_s": 5.0}
    by = [rt.simulate(scene, converter=converter) for converter in (True, False)]
    idle = [one.values[one.time_s < 4.9] for one in by]
    assert np.std(idle[0] - idle[0].mean(axis=0)) == pytest.approx(4.5e-6, rel=0.02)
    assert np.abs(idle[0].mean(axis=0) - idle[1].mean(axis=0)).max() < 2e-6


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda: rt.simulate({"period": 3}), rt.Error, "unknown field `period`"),
        (lambda: rt.simulate("period_mm = 2.6\nspeed_mm_s = -1"), rt.Error, "line 2: speed_mm_s"),
        (lambda: rt.simulate({"period_mm": "3"}), rt.UsageError, "period_mm is '3'"),
        (lambda: rt.simulate("none.toml"), rt.Error, "none.toml: No such file"),
        (lambda: rt.simulate(3), rt.UsageError, "int, and a path"),  # type: ignore[arg-type]
        (lambda: rt.simulate({"speed_mm_s": 600.0}), rt.Error, "follow less than half"),
        (lambda: rt.simulate({"speed_mm_s": 0.01}), rt.Error, "at most 3600 s"),
        (lambda: rt.simulate({"speed_mm_s": 0.01}, converter=False), rt.Error, "at most 3600 s"),
        (lambda: rt.simulate(settings={"plan": "single"}), rt.Error, "converts 1 of 16 channels"),
        (lambda: rt.simulate(settings={"plan": "slow"}), rt.Error, "plan"),
    ],
)
def test_what_cannot_be_simulated_is_refused(call: Callable[[], object], kind: type[Exception], words: str) -> None:
    with pytest.raises(kind, match=words):
        call()


def test_replayed_events_by_kind_and_as_arrays() -> None:
    found = rt.simulate({"seed": 3})
    replayed = rt.replay(found)
    assert [type(event) for event in replayed.contacts + replayed.slides + replayed.releases] == [rt.Contact, rt.Slide, rt.Release]
    # Times count from the first row.
    assert abs(found.time_s[0] + replayed.slides[0].start_s - found.truth.slide_start_s) < 0.02
    assert abs(found.time_s[0] + replayed.slides[0].end_s - found.truth.slide_end_s) < 0.02
    estimates = replayed.columns(rt.Estimate)
    assert list(estimates["frequency_hz"]) == [one.frequency_hz for one in replayed.estimates]
    assert estimates["status"].dtype.kind == "U" and "channels" not in estimates
    windows = replayed.columns(rt.Estimate, lambda one: one.span == "window")
    assert 0 < len(windows["t_s"]) < len(estimates["t_s"])
    slides = replayed.columns(rt.Slide)
    assert np.isnan(slides["end_s"]).tolist() == [True, False]
    assert replayed.columns(rt.Fault) == {} and replayed[0] in replayed


@pytest.mark.parametrize(("speed_mm_s", "period_mm"), [(48, 3.1), (15, 3.1), (48, 2.6)])
def test_static_images_are_what_the_grating_at_rest_makes(speed_mm_s: float, period_mm: float) -> None:
    scene = {"speed_mm_s": speed_mm_s, "period_mm": period_mm, "reverse": True}
    noisy = rt.simulate({**scene, "finger": {"noise_uv": 900.0}})
    # The same finger without noise and without creep: both time constants are equal.
    elastic = rt.simulate({**scene, "finger": {"noise_uv": 0.0, "relaxation_s": 3.0, "creep_s": 3.0}}, converter=False)
    offset_v = np.array([channel.offset_v for channel in elastic.channels])
    images = rt.replay(noisy).of(rt.Image)
    assert [image.hold for image in images] == ["before_slide", "after_slide"]
    for image, at_s in zip(images, (noisy.truth.slide_start_s - 0.1, noisy.truth.release_s - 0.1), strict=True):
        expected_v = elastic.values[np.searchsorted(elastic.time_s, at_s)] - offset_v
        level_v = np.array([taxel.level_v for taxel in image.taxels])
        # Allows 5 % for creep, and the noise of a mean of 72 readings less one of 48.
        assert np.all(np.abs(level_v - expected_v) < 0.06 * np.abs(expected_v) + 4 * 0.9e-3 * np.sqrt(1 / 72 + 1 / 48)), (level_v, expected_v)
    # Piezoresistors 1 and 3 of unit 1 at rest: opposite signs (Oddo et al., figure 10).
    assert images[0].taxels[0].level_v < 0 < images[0].taxels[2].level_v
