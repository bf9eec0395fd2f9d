"""The emulated board, live: as an iterator, with `async`, through the page's address, and its settings."""

import asyncio
import subprocess
from pathlib import Path

import pytest
import ridgetone as rt
from conftest import COMMAND, ROOT, Run


def test_the_emulated_board_is_listened_to_set_and_recorded(tmp_path: Path, run: Run) -> None:
    path, events = tmp_path / "touch.rec", []
    with rt.live("emulated", raw=True, once=True, record=path) as board:
        for event in board:
            events.append(event)
            if isinstance(event, rt.Contact):
                assert board.settings.window_s == 1.0
                assert board.set(window_s=0.5, stride_s=0.1).window_s == 0.5
                with pytest.raises(rt.UsageError, match="0.1 to 3.9"):
                    board.set(window_s=9)
        # A computer that is too slow for the pace repeats its requests, and the board may drop replies. It counts them.
        dropped = [event.messages_dropped for event in events if isinstance(event, rt.Health)][-1]
        assert board.counts["missing"] == dropped and board.counts["received"] >= len(events)
    windows = [event.window_s for event in events if isinstance(event, rt.Estimate) and event.span == "window"]
    assert len(windows) > 5 and all(abs(window_s - 0.5) < 0.01 for window_s in windows)
    frames = [event for event in events if isinstance(event, rt.Raw)]
    assert len(frames) > 1000
    for frame in frames[:50]:
        volts = [code * 4.096 / 7_864_320 for code in frame.codes]
        assert frame.volts == pytest.approx(volts, rel=1e-6)
    # The recording has everything that arrived, as the command prints it, including the answers to requests.
    printed = run("replay", path, "--json")
    assert [line for line in printed if line["type"] == "contact"] == [e for e in events if e.type == "contact"]
    # The scene may end within a frame, which then makes no row.
    assert len(rt.read(path).values) >= sum(frame.present & frame.good == 0xFFFF for frame in frames)
    with pytest.raises(rt.Error, match="closed"):
        _ = board.settings


def test_two_boards_at_once_as_async() -> None:
    async def touch(scene: Path) -> list[str]:
        with rt.live("emulated", once=True, pace=0, scene=scene) as board:
            return [event.type async for event in board]

    async def both() -> list[list[str]]:
        return await asyncio.gather(*(touch(ROOT / "hal-mock/scenes" / f"{name}.toml") for name in ["c7", "c10"]))

    for kinds in asyncio.run(both()):
        assert kinds[0] == "hello" and {"contact", "slide", "estimate", "release"} <= set(kinds)


def test_a_page_gives_its_packets() -> None:
    view = subprocess.Popen(
        [COMMAND, "view", "--emulated"], stdout=subprocess.PIPE, text=True, cwd=ROOT
    )
    try:
        assert view.stdout is not None
        address = view.stdout.readline().strip()
        kinds = set()
        for number, event in enumerate(rt.live(address)):
            kinds.add(event.type)
            if number > 600:
                break
        assert {"hello", "raw", "health"} <= kinds
        with pytest.raises(rt.UsageError, match="page"):
            rt.live(address).set(window_s=1)
    finally:
        view.terminate()
        view.wait(20)
