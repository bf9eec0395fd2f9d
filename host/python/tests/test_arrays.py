"""Arrays: where they are read, what is converted, and what is refused in the command's words."""

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
    # A sparse file: reading it all would take hours, and copying it would end the process.
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
    rt.replay(array[:3000], scale=1e-4)
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


def test_the_warning_is_the_commands() -> None:
    with pytest.warns(UserWarning, match="--rate 100 Hz is used, though time_s gives 250.0000 Hz"):
        rt.fit(sine(), 100, time_s=np.arange(1000) / 250)


def test_what_is_guessed_of_a_table_is_said(tmp_path: Path) -> None:
    path = tmp_path / "excel.csv"
    rows = "".join(f"{4 * row};{value:.6f};\n".replace(".", ",") for row, value in enumerate(sine()[:, 1]))
    path.write_text(f"t;force (N);\n{rows}")
    with pytest.raises(rt.Error, match="--time-column t:ms"):
        rt.read(path)
    with pytest.warns(UserWarning, match="semicolons; decimals follow a comma; column t is the time in milliseconds"):
        found = rt.read(path, time_column="t:ms")
    assert found.units == ["N"] and found.names == ["force (N)"] and found.rate_hz == pytest.approx(250)
    assert rt.fit(found).frequency_hz == pytest.approx(8, rel=1e-4)


def test_errors_have_the_commands_words(tmp_path: Path, refusal: Callable[..., str]) -> None:
    tables = {
        "no_rate": "a\n1\n2\n",
        "empty": "",
        "words": "time_s,a\n0,one\n0.1,two\n",
        "backwards": "time_s,a\n0,1\n0.2,2\n0.1,3\n",
        "wide": "time_s," + ",".join(f"c{c}" for c in range(17)) + "\n0" + ",1" * 17 + "\n1" + ",1" * 17 + "\n",
    }
    for name, text in tables.items():
        path = tmp_path / f"{name}.csv"
        path.write_text(text)
        with pytest.raises(rt.Error) as raised:
            rt.fit(path)
        assert str(raised.value) == refusal("fit", path)
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
        (lambda: rt.feel(sine(), {"ra_um": 1}, 100), "rsm_mm"),
        (lambda: rt.settings(window=1), "no setting `window`: choose from plan, window_s"),
        (lambda: rt.live("emulated", usb_serial=None, scene="none.toml"), "none.toml"),
        (lambda: rt.live(once=True), "emulated"),
    ],
)
def test_what_cannot_be_used_is_refused(call: Callable[[], object], words: str) -> None:
    with pytest.raises(rt.Error, match=words.replace("(", r"\(")):
        call()


def test_objects_have_their_fields() -> None:
    found = rt.fit(sine(), 250)
    assert found["status"] == found.status and "frequency_hz" in dir(found)
    with pytest.raises(AttributeError, match="Fit has no field frequenzy; there are: type, file"):
        _ = found.frequenzy
    contact = next(event for event in rt.replay() if isinstance(event, rt.Contact))
    match contact:
        case rt.Contact(taxel=taxel, t_s=t_s):
            assert taxel in range(16) and abs(t_s - 0.51) < 0.01
