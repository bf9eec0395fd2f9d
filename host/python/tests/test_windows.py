"""Windows as arrays equal those of `ridgetone fit --window`, to the last bit."""

import re
from pathlib import Path

import numpy as np
import pytest
import ridgetone as rt
from conftest import Refusal, Run
from ridgetone._events import Fit

ROWS, RATE_HZ = 1000, 250


def sine() -> "np.ndarray[tuple[int, int], np.dtype[np.float64]]":
    t = np.arange(ROWS)[:, None] / RATE_HZ
    noise = np.random.default_rng(3).normal(size=(ROWS, 3))
    return np.sin(2 * np.pi * 8 * t + np.arange(3)) * (1 + np.arange(3)) + 0.01 * noise


@pytest.mark.parametrize(
    ("options", "arguments"),
    [
        ({}, []),
        ({"stride_s": 0.25}, ["--stride", 0.25]),
        ({"harmonics": 1, "exclude": ["all"]}, ["--harmonics", 1, "--exclude", "all"]),
    ],
)
def test_each_row_is_the_commands(options: dict[str, object], arguments: list[object], tmp_path: Path, run: Run) -> None:
    path = tmp_path / "rows.csv"
    lines = (",".join(map(repr, row)) for row in sine().tolist())
    path.write_text("ch0,ch1,ch2\n" + "\n".join(lines) + "\n")
    printed = run("fit", path, "--rate", RATE_HZ, "--window", 1, *arguments, "--json")
    fits = rt.fit(sine(), RATE_HZ, window_s=1, **options)
    assert len(fits) == len(printed) > 3
    fields = [name for name in Fit.__annotations__ if name in rt.Fits.__annotations__]
    for at, line in enumerate(printed):
        for name in fields:
            own, theirs = getattr(fits, name)[at], line.get(name)
            assert (theirs is None and np.isnan(own)) or own == theirs, name
        for channel, other in enumerate(line["channels"]):
            assert [fits.usable[at, channel], fits.amplitude[at, channel]] == [other["usable"], other["amplitude"]]
    assert fits.names == ["ch0", "ch1", "ch2"] and fits.amplitude.shape == (len(fits), 3)
    assert np.all(np.abs(fits.frequency_hz - 8) < 5 * fits.sigma_hz)


def test_every_figure_of_a_fit_is_an_array() -> None:
    of_windows = {"type", "file", "part", "domain", "channels", "groups"}
    assert set(Fit.__annotations__) - of_windows <= set(rt.Fits.__annotations__)


def test_a_window_without_a_fit_says_why() -> None:
    stands = np.full(ROWS, 30 / RATE_HZ)
    stands[250:500] = 0
    fits = rt.fit(sine(), RATE_HZ, window_s=1, position_mm=stands.cumsum())
    assert fits.status[1] == "no_fit" and not (fits.status[[0, 2, 3]] == "no_fit").any()
    assert "does not move" in fits.why[1] and not fits.why[0] and np.isnan(fits.frequency_per_mm[1]) and fits.from_s[1] == 1
    assert not fits.usable[1].any() and re.search("1 no_fit", repr(fits))
    assert [row["status"] for row in fits] == list(fits.status)


def test_what_makes_no_sense_is_refused(tmp_path: Path, refusal: Refusal) -> None:
    with pytest.raises(rt.UsageError, match="stride_s is for windows: give window_s, too"):
        rt.fit(sine(), RATE_HZ, stride_s=1)  # type: ignore[call-overload]
    with pytest.raises(rt.Error, match="window_s and stride_s must be greater than 0 s"):
        rt.fit(sine(), RATE_HZ, window_s=1, stride_s=0)
    with pytest.raises(rt.Error, match="its rows fill no window of 9 s: choose a shorter window_s"):
        rt.fit(sine(), RATE_HZ, window_s=9)
