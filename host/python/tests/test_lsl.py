"""The Lab Streaming Layer's own library reads what `lsl.py` gives."""

import importlib.util
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import ridgetone as rt
from conftest import ROOT

pylsl = pytest.importorskip("pylsl", reason="LSL's library is not there: pip install pylsl")


def test_a_reader_gets_volts_at_their_time(tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("lsl", ROOT / "host/python" / "lsl.py")
    assert spec and spec.loader
    lsl = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(lsl)
    name, frames = f"test of {tmp_path}", []

    def told(board: rt.Live) -> Iterator[rt.Event]:
        for event in board:
            if isinstance(event, rt.Raw):
                frames.append(event)
            yield event

    def run() -> None:
        with rt.live("emulated", raw=True, once=True) as board:
            lsl.stream(told(board), name)

    running = threading.Thread(target=run)
    running.start()
    found = pylsl.resolve_byprop("name", name, timeout=60)
    assert len(found) == 1 and (found[0].channel_count(), found[0].type()) == (16, "Tactile")
    assert found[0].nominal_srate() == pytest.approx(241, abs=1)
    inlet = pylsl.StreamInlet(found[0], recover=False)
    samples, times_s = [], []
    while len(samples) < 400:
        sample, time_s = inlet.pull_sample(timeout=30)
        assert sample is not None, f"{len(samples)} samples"
        samples.append(sample)
        times_s.append(time_s)
    unit = inlet.info().desc().child("channels").child("channel").child_value("unit")
    inlet.close_stream()
    running.join()
    assert unit == "V"
    # The samples are a part of the frames, without a gap.
    volts = np.array([frame.volts for frame in frames], np.float32)
    begin = int(np.flatnonzero((volts == np.float32(samples[0])).all(axis=1))[0])
    assert (volts[begin : begin + len(samples)] == np.array(samples, np.float32)).all()
    # LSL's clock differs from UTC by a constant.
    utc_s = np.array([frame.utc_s for frame in frames[begin : begin + len(samples)]])
    offset_s = np.array(times_s) - utc_s - (pylsl.local_clock() - time.time())
    assert np.abs(offset_s).max() < 0.02, offset_s
