"""The package returns what the command prints, to the last bit, for every recording."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import ridgetone as rt
from conftest import SCENES, Refusal, Run, tables

ALL = [*SCENES, *tables()]
# Recordings with too few rows per second for touch detection.
SLOW = {"milliseconds", "gap", "blank", "single", "noise"}


def same(ours: object, theirs: object) -> None:
    """Asserts that both are equal and each number has the same bits: 0.0 is not -0.0, and 1 is not 1.0."""
    assert json.dumps(ours) == json.dumps(theirs)


@pytest.mark.parametrize("name", ALL)
def test_fit_of_a_file_a_recording_and_an_array(name: str, recordings: dict[str, Path], run: Run) -> None:
    path = recordings[name]
    part = {"from_s": 1.0, "to_s": 3.0}
    [printed] = run("fit", path, "--json", "--from", 1, "--to", 3)
    same(rt.fit(path, **part), printed)
    recording = rt.read(path)
    same(rt.fit(recording, **part), printed)
    for array in [recording.values, np.asfortranarray(recording.values), np.repeat(recording.values, 2, axis=0)[::2]]:
        found = rt.fit(array, time_s=recording.time_s, names=recording.names, **part)
        same({**found, "file": printed["file"]}, printed)
    [printed] = run("fit", path, "--json", "--from", 1, "--to", 3, "--min-hz", 1, "--max-hz", 2)
    same(rt.fit(recording, **part, min_hz=1, max_hz=2), printed)
    # Options for harmonics and mains hum.
    options = {"harmonics": 2, "mains_hz": 50.0}
    [printed] = run("fit", path, "--json", "--from", 1, "--to", 3, "--harmonics", 2, "--mains", 50)
    same(rt.fit(recording, **part, **options), printed)


@pytest.mark.parametrize("name", ALL)
def test_replay_of_a_file_and_of_a_recording(name: str, recordings: dict[str, Path], run: Run, refusal: Refusal) -> None:
    path = recordings[name]
    scale = 1e-3 if name in tables() else 1.0
    settings = {"window_s": 0.5}
    if name in SLOW:
        with pytest.raises(rt.Error, match="rows a second, and touches are found from 180 to 23740") as raised:
            rt.replay(path, scale=scale, settings=settings)
        assert str(raised.value) == refusal("replay", path, "--scale", scale)
        return
    printed = run("replay", path, "--json", "--scale", scale, "--window", 0.5)
    same(rt.replay(path, scale=scale, settings=settings), printed)
    same(rt.replay(rt.read(path), scale=scale, settings=settings), printed)


@pytest.mark.parametrize("name", SCENES)
def test_replay_of_a_scene(name: str, run: Run) -> None:
    printed = run("replay", "--scene", f"hal-mock/scenes/{name}.toml", "--json")
    same(rt.replay(scene=f"{Path(__file__).parents[3]}/hal-mock/scenes/{name}.toml"), printed)


def test_textures(run: Run) -> None:
    events = rt.replay()
    same(events, run("replay", "--json"))
    [texture] = [event for event in events if isinstance(event, rt.Texture)]
    assert set(rt.Texture.__annotations__) < set(texture)
    assert abs(texture.period_mm - 3.6) < 4 * texture.period_sigma_mm and texture.plan == "paper"


def test_telemetry_in_every_form(telemetry: dict[str, Path], run: Run) -> None:
    frames = {name: rt.read(path) for name, path in telemetry.items()}
    for recording in frames.values():
        assert recording.units == ["V"] * 16 and recording.names[3] == "ain3"
        np.testing.assert_array_equal(recording.values, frames["csv"].values)
        np.testing.assert_array_equal(recording.time_s, frames["csv"].time_s)
    without_raw = [line for line in run("replay", telemetry["rec"], "--json") if line["type"] != "raw"]
    same(frames["rec"].events, without_raw)
    same(frames["ndjson"].events, without_raw)
    # In MCAP, UTC follows from the delays of the whole recording, null fields are omitted, and fields of streams are added.
    def plain(value: Any) -> Any:
        if isinstance(value, list):
            return [plain(item) for item in value]
        if not isinstance(value, dict):
            return value
        without = {"utc_s", "utc_sigma_s", "index", "positions_mm"}
        return {name: plain(found) for name, found in value.items() if name not in without and found is not None}

    assert plain(frames["mcap"].events) == plain(without_raw)
    assert all(event.utc_s is None or event.utc_s > 0 for event in frames["mcap"].events)
    for name, path in telemetry.items():
        [printed] = run("fit", path, "--json", "--from", 2, "--to", 3)
        same(rt.fit(path, from_s=2, to_s=3), printed)
        assert printed["status"] == "good", name
        # Raw frames have the same codes in every format except CSV, whose volts are read as a table.
        if name != "csv":
            same(rt.replay(path), run("replay", telemetry["rec"], "--json", "--set", "window_s=1"))


def test_settings(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "finger.toml"
    file.write_text("window_s = 0.5\nharmonics = 2\n[array]\nperiod_max_mm = 3.9\n")
    hello = run("replay", "--json", "--settings", file)[0]
    same(rt.settings(file), hello["settings"])
    same(rt.settings(window_s=0.5, harmonics=2, array={"period_max_mm": 3.9}), hello["settings"])
    assert rt.replay(settings=rt.settings(file))[0].settings == hello["settings"]
