"""Arrays are read without a copy, converted, or refused with the names of Python's arguments."""

import copy
import pickle
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import ridgetone as rt
from ridgetone._recording import numbers


def sine(rows: int = 1000, channels: int = 3) -> "np.ndarray[tuple[int, int], np.dtype[np.float64]]":
    t = np.arange(rows)[:, None] / 250
    return np.sin(2 * np.pi * 8 * t + np.arange(channels)) * (1 + np.arange(channels))


def test_the_closed_form_is_found() -> None:
    found = rt.fit(sine(), 250)
    assert found.status == "good" and abs(found.frequency_hz - 8) < 1e-4
    for c, channel in enumerate(found.channels):
        assert abs(channel.amplitude - (1 + c)) < 1e-3
    assert rt.fit(sine()[:, 0], 250).channels[0].name == "ch0"


def test_floats_are_not_copied_and_others_are_converted() -> None:
    for array in [sine(), sine().astype(np.float32), np.asfortranarray(sine()), sine()[::2, 1:]]:
        assert numbers(array) is array
    whole = np.round(1000 * sine()).astype(np.int16)
    assert rt.fit(whole, 250) == rt.fit(whole.astype(float), 250)
    narrow = sine().astype(np.float32)
    assert rt.fit(narrow, 250) == rt.fit(narrow.astype(float), 250)
    swapped = sine().astype(">f8")
    assert rt.fit(swapped, 250) == rt.fit(sine(), 250)


def test_an_array_of_a_terabyte_is_fitted_where_it_is(tmp_path: Path) -> None:
    # Sparse file: reading it all would take hours, and copying it would end the process.
    part = sine(1000, 16)
    big = np.memmap(tmp_path / "big", dtype=np.float64, mode="w+", shape=(2**33, 16))
    big[:1000] = part
    assert rt.fit(big, 250, to_s=999 / 250) == {**rt.fit(part, 250), "part": "given"}


def test_other_threads_run_meanwhile() -> None:
    array = np.random.default_rng(1).normal(size=(32768, 16)).cumsum(axis=0)
    ticks, done = [], threading.Event()

    def tick() -> None:
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begun = time.perf_counter()
    rt.fit(array, 250)
    rt.replay(array[:3000], rate_hz=250, scale=1e-4)
    ended = time.perf_counter()
    done.set()
    thread.join()
    inside = [t for t in ticks if begun < t < ended]
    gaps = np.diff([begun, *inside, ended])
    assert ended - begun > 0.05 and gaps.max() < 0.5 * (ended - begun), (ended - begun, gaps.max())


def test_missing_readings_are_nan() -> None:
    array = sine()
    array[::10, 1] = np.nan
    found = rt.fit(array, 250)
    assert found.readings_missing == 100 and abs(found.frequency_hz - 8) < 1e-3


def test_the_warning_names_the_argument() -> None:
    with pytest.warns(UserWarning, match="rate_hz=100 is used, though time_s gives 250.0000 Hz"):
        rt.fit(sine(), 100, time_s=np.arange(1000) / 250)


def test_what_is_guessed_of_a_table_is_said(tmp_path: Path) -> None:
    path = tmp_path / "excel.csv"
    rows = "".join(f"{4 * row};{value:.6f};\n".replace(".", ",") for row, value in enumerate(sine()[:, 1]))
    path.write_text(f"t;force (N);\n{rows}")
    with pytest.raises(rt.Error, match='time_column="t:ms"'):
        rt.read(path)
    with pytest.warns(UserWarning, match="semicolons; decimals follow a comma; column t is the time in milliseconds"):
        found = rt.read(path, time_column="t:ms")
    assert found.units == ["N"] and found.names == ["force (N)"] and found.rate_hz == pytest.approx(250)
    assert rt.fit(found).frequency_hz == pytest.approx(8, rel=1e-4)


def test_errors_have_the_commands_text_and_pythons_arguments(tmp_path: Path, refusal: Callable[..., str]) -> None:
    tables = {
        "no_rate": ("a\n1\n2\n", "with rate_hz"),
        "empty": ("", ""),
        "no_unit": ("t,a\n0,1\n4,2\n8,1\n", 'time_column="t:ms", or give rate_hz'),
        "quoted": ("Relative Time,a\n0,1\n4,2\n8,1\n", 'time_column="Relative Time:ms"'),
        "backwards": ("time_s,a\n" + "".join(f"0.{row:02},1\n" for row in range(40)) + "0.005,3\n", "rate_hz, or choose another time_column"),
    }
    for name, (text, words) in tables.items():
        path = tmp_path / f"{name}.csv"
        path.write_text(text)
        with pytest.raises(rt.Error) as raised:
            rt.fit(path)
        ours, theirs = str(raised.value), refusal("fit", path)
        assert words in ours and "--" not in ours and (words or ours == theirs), (ours, theirs)
        # The messages differ only in the options.
        assert ours.split(";")[0] == theirs.split(";")[0] or words in ours.split(";")[0]
    with pytest.raises(rt.Error) as raised:
        rt.read(tmp_path / "none.csv")
    assert str(raised.value) == refusal("fit", tmp_path / "none.csv")
    with pytest.raises(rt.UsageError) as raised:
        rt.replay(settings={"window_s": 9})
    assert str(raised.value) == refusal("replay", "--window", "9")
    with pytest.raises(rt.Error) as raised:
        rt.live("/dev/no such port")
    assert str(raised.value) == refusal("monitor", "--port", "/dev/no such port")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: rt.fit(np.zeros((5, 2))), "give rate_hz, or time_s"),
        (lambda: rt.fit(np.zeros((2, 2, 2)), 1), "3 dimensions"),
        (lambda: rt.fit(np.array(["a"]), 1), "numbers are needed"),
        (lambda: rt.fit([[1.0, np.inf]], 1), "row 1: column ch1: inf is not finite"),
        (lambda: rt.fit(np.zeros((0, 2)), 1), "no data"),
        (lambda: rt.fit(sine(), time_s=[0, 1]), "2 times for 1000 rows"),
        (lambda: rt.fit(sine(), names=["a"], rate_hz=1), "1 names for 3 columns"),
        (lambda: rt.fit(sine(10), time_s=[0, 1, 2, 3, 4, 5, 6, 7, 9, 8]), "row 10: the time does not increase: 8 s after 9 s"),
        (lambda: rt.settings(window=1), "no setting `window`: choose from plan, window_s"),
        (lambda: rt.live("emulated", usb_serial=None, scene="none.toml"), "none.toml"),
        (lambda: rt.live(once=True), "emulated"),
        (lambda: rt.fit(sine(), 250, harmonics=0), "harmonics=0: must be 1 to 5"),
        (lambda: rt.fit(sine(), 250, harmonics=9), "harmonics=9: must be 1 to 5"),
        (lambda: rt.fit(sine(), 250, from_s=3, to_s=2), "from_s=3 is not before to_s=2"),
        (lambda: rt.fit(sine(), 250, to_s=200), "to_s=200 is outside the data"),
        (lambda: rt.fit(sine(), -1), "rate_hz=-1: must be greater than 0"),
        (lambda: rt.fit(sine(70000), 250, position_mm=np.linspace(0, 1e3, 70000)), "choose a part with from_s and to_s"),
        (lambda: rt.fit(np.zeros((20, 1000)), 250), "give the array transposed"),
        (lambda: rt.fit(sine(), 250, columns=["ch1", "ch1"]), "columns names ch1 twice"),
        (lambda: rt.fit(sine(), 250, time_column="ch0"), "time_column is for files and data frames"),
        (lambda: rt.fit(sine(), 250, position_mm=[1, 2]), "position_mm: 2 values for 1000 rows"),
        (lambda: rt.fit(sine(), 250, position_mm=[1], speed_mm_s=[1]), "speed_mm_s and position_mm: one of them"),
        (lambda: rt.fit(sine(), 250, position_column="ch0:furlong"), "unit"),
    ],
)
def test_what_cannot_be_used_is_refused(call: Callable[[], object], words: str) -> None:
    with pytest.raises(rt.Error, match=words.replace("(", r"\(")):
        call()


def test_masked_readings_are_missing() -> None:
    array, mask = sine(), np.zeros((1000, 3), bool)
    mask[::9, 2] = True
    missing = np.where(mask, np.nan, array)
    masked = np.ma.masked_array(np.where(mask, 1e9, array), mask)
    assert rt.fit(masked, 250) == rt.fit(missing, 250)
    assert rt.fit(np.ma.masked_array(array), 250) == rt.fit(array, 250)
    counts = np.round(1000 * array).astype(int)
    assert rt.fit(np.ma.masked_array(np.where(mask, 10**9, counts), mask), 250) == rt.fit(np.where(mask, np.nan, counts), 250)
    times = np.ma.masked_array(np.arange(1000) / 250, mask=np.arange(1000) == 5)
    with pytest.raises(rt.Error, match="row 6: time_s: NaN is no time"):
        rt.fit(array, time_s=times)


def test_uneven_times_are_fitted_as_they_are() -> None:
    t = np.sort(np.random.default_rng(3).uniform(0, 4, 1000))
    noise = np.random.default_rng(4).normal(0, 0.01, (1000, 2))
    found = rt.fit(np.c_[np.sin(2 * np.pi * 8 * t), np.cos(2 * np.pi * 8 * t)] + noise, time_s=t)
    assert found.status == "good" and abs(found.frequency_hz - 8) < 4 * found.sigma_hz < 0.01


def test_one_exclusion_needs_no_list() -> None:
    parts = ["overtones", "curved_baseline", "coloured_noise", "shared_noise", "impulses"]
    lean = rt.fit(sine(), 250, exclude="all")
    assert lean == rt.fit(sine(), 250, exclude=parts) and lean.harmonics == 1
    assert rt.fit(sine(), 250, exclude="impulses") == rt.fit(sine(), 250, exclude=("impulses",))
    with pytest.raises(rt.UsageError, match="everything"):
        rt.fit(sine(), 250, exclude="everything")


def test_positions_and_speeds_are_arrays_too() -> None:
    t = np.arange(1000) / 250
    position = 20 * t + 3 * np.sin(2 * t)
    array = np.sin(2 * np.pi * position / 2.5)[:, None] * [1, 2] + np.random.default_rng(5).normal(0, 0.01, (1000, 2))
    by_position = rt.fit(array, 250, position_mm=position)
    by_speed = rt.fit(array, 250, speed_mm_s=20 + 6 * np.cos(2 * t))
    for found in [by_position, by_speed]:
        assert found.domain == "position" and abs(found.period_mm - 2.5) < 4 * found.period_sigma_mm < 0.01
        assert [channel.name for channel in found.channels] == ["ch0", "ch1"]
    named = rt.fit(np.c_[array, position], 250, names=["a", "b", "x"], position_column="x:mm")
    assert named.period_mm == by_position.period_mm


def test_data_frames_have_names_and_times() -> None:
    pandas = pytest.importorskip("pandas")
    array, t = sine(), np.arange(1000) / 250
    known = rt.fit(array, time_s=t, names=["x", "y", "z"])
    known = {**known, "file": "data frame"}
    frame = pandas.DataFrame(array, columns=["x", "y", "z"])
    assert rt.fit(frame.assign(time_s=t)) == known
    assert rt.fit(frame, time_s=t) == known
    assert rt.fit(frame.set_index(pandas.Index(t, name="time_s"))) == known
    assert rt.fit(frame.assign(clock=1000 * t), time_column="clock:ms").frequency_hz == pytest.approx(known["frequency_hz"])
    with pytest.warns(UserWarning, match="no numbers, and so no channels: label"):
        assert rt.fit(frame.assign(time_s=t, label="a")) == known
    dates = pandas.date_range("2026-03-29 00:59:58", periods=1000, freq="4ms", tz="UTC").tz_convert("Europe/Vienna")
    for given in [frame.set_index(dates), frame.assign(when=dates), frame.assign(when=dates.tz_convert("UTC").tz_localize(None))]:
        found = rt.fit(given)
        assert found.frequency_hz == pytest.approx(known["frequency_hz"], rel=1e-9) and found.from_s == 0
    assert rt.fit(array, time_s=dates).frequency_hz == pytest.approx(known["frequency_hz"], rel=1e-9)
    rows = np.arange(1000)
    stamps = {"header.stamp.secs": 1_700_000_000 + rows // 250, "header.stamp.nsecs": 4_000_000 * (rows % 250)}
    split = rt.fit(frame.assign(**stamps))
    assert split.frequency_hz == pytest.approx(known["frequency_hz"], rel=1e-7) and split.status == known["status"]
    assert [channel.name for channel in split.channels] == ["x", "y", "z"]
    missing = frame.astype("Float64").mask(np.repeat((np.arange(1000) % 7 == 0)[:, None], 3, axis=1))
    assert rt.fit(missing, 250).readings_missing == rt.fit(np.where((np.arange(1000) % 7 == 0)[:, None], np.nan, array), 250).readings_missing
    assert [channel.name for channel in rt.fit(frame["y"], 250).channels] == ["y"]
    with pytest.raises(rt.UsageError, match="no column t; there are: x, y, z"):
        rt.fit(frame, time_column="t")
    with pytest.raises(rt.Error, match="give rate_hz, or time_s"):
        rt.fit(frame)


def test_a_file_has_a_column_of_times_by_name(tmp_path: Path) -> None:
    path = tmp_path / "plain.csv"
    path.write_text("clock,a\n" + "".join(f"{4 * row},{value}\n" for row, value in enumerate(sine()[:, 0])))
    with pytest.warns(UserWarning, match="milliseconds"):
        assert rt.fit(path, time_column="clock:ms").frequency_hz == pytest.approx(8, rel=1e-4)


def test_the_package_shows_its_api_alone() -> None:
    assert dir(rt) == sorted(rt.__all__) and "json" not in dir(rt)


def test_results_are_readable() -> None:
    random = np.random.default_rng(6)
    found = rt.fit(sine() + random.normal(0, 0.1, (1000, 3)), 250)
    digits = f"{found.sigma_hz:.1e}"
    decimals = 1 - int(digits.partition("e")[2])
    line = f"{found.frequency_hz:.{decimals}f} ± {found.sigma_hz:.{decimals}f}"
    assert f"<td>{line}</td>" in found._repr_html_()
    shown = dict(row.split(maxsplit=1) for row in str(found).splitlines() if len(row.split()) > 1)
    assert shown["frequency_hz"] == line and shown["rate_hz"] == "250"
    assert "sigma_hz" not in shown and "rate_sigma_hz" not in shown
    for event in rt.replay():
        assert str(event).startswith(type(event).__name__) and event._repr_html_().endswith("</table>")


def test_a_fit_has_a_picture() -> None:
    found = rt.fit(sine(), 250, names=["left", "middle", "right"])
    picture = rt.picture(found)
    assert picture.startswith("<svg") and all(f">{name}<" in picture for name in ["left", "middle", "right"])
    assert picture._repr_svg_() == picture
    copied = pickle.loads(pickle.dumps(found))  # noqa: S301
    assert copied == found == copy.deepcopy(found) and isinstance(copied, rt.Fit)
    with pytest.raises(rt.UsageError, match="fit again"):
        rt.picture(copied)


def test_objects_have_their_fields() -> None:
    found = rt.fit(sine(), 250)
    assert found["status"] == found.status and "frequency_hz" in dir(found)
    with pytest.raises(AttributeError, match="Fit has no field frequenzy; there are: type, file"):
        _ = found.frequenzy
    contact = next(event for event in rt.replay() if isinstance(event, rt.Contact))
    match contact:
        case rt.Contact(taxel=taxel, t_s=t_s):
            assert taxel in range(16) and abs(t_s - 0.51) < 0.01
