"""Tests the page with the emulated board."""

import json
import os
import re
import time
from collections.abc import Callable
from pathlib import Path
from urllib.request import urlopen

import pytest
from conftest import ROOT, View, drawn, looks, text, wait

Start = Callable[..., View]
NOW_S = "parseFloat(document.getElementById('source')?.textContent.split(', ').at(-1))"
PANELS = ("strips", "history", "spectrum", "fit", "map")
IMAGE = ROOT / "target/firmware/feather-f405/ridgetone-firmware.elf"
pytestmark = pytest.mark.skipif(not IMAGE.exists(), reason="there is no firmware image: cargo xtask firmware")


def change(page, **settings: str) -> None:  # type: ignore[no-untyped-def]
    for name, value in settings.items():
        page.locator(f"#{name}").evaluate("(input, value) => { input.value = value; input.dispatchEvent(new Event('input', { bubbles: true })); }", value)
    page.click("#settings-send")


def test_the_emulated_board_waits_while_nobody_looks_takes_settings_and_is_recorded(view: Start) -> None:
    started = view("--emulated")

    def now_s() -> float:
        with urlopen(f"{started.url}state.json", timeout=20) as answer:
            return json.load(answer)["live"]["now_s"] or 0.0

    time.sleep(2)
    assert now_s() < 0.5, "nobody has looked yet"
    page = started.page()
    wait(page, "document.getElementById('settings')?.hidden === false")
    page.click("#record")
    applied = "document.getElementById('settings-message').textContent.startsWith('Applied, not stored')"
    change(page, window_s="0.5", stride_s="0.1", harmonics="2")
    wait(page, applied)
    # A refusal must stay until the next command, although every update repeats the board's answer.
    change(page, harmonics="9")
    wait(page, "document.getElementById('settings-message').textContent.startsWith('harmonics: ')")
    page.wait_for_timeout(1500)
    assert text(page, "settings-message").startswith("harmonics: ")
    change(page, harmonics="2")
    wait(page, applied)
    wait(page, "document.getElementById('frequency-small').textContent.includes('window of 0.50 s')")
    assert "f " in text(page, "fit-small") and "3f " not in text(page, "fit-small")
    enough_s = now_s() + 1.5
    wait(page, f"{NOW_S} > {enough_s}")
    page.click("#record")
    wait(page, "document.querySelectorAll('#run-rows tr').length === 1")
    assert re.match("emulated-board-.* Hz", page.locator("#run-rows tr").text_content() or "")
    # Frames received before the recording started can be viewed too.
    page.click("#latest")
    wait(page, "document.querySelectorAll('#run-rows tr').length === 2 && !document.getElementById('scrub').hidden")
    assert float(page.get_attribute("#time", "min") or "1") < 0.1
    page.click("#live")
    # A new plan sets its own window and stride.
    change(page, plan="hand")
    wait(page, "document.getElementById('settings-message').textContent.includes('1458.')")
    wait(page, "Math.abs(Number(document.getElementById('window_s').value) - 0.373) < 0.001")
    # If the page is hidden, the board must stop three seconds after the last request for its state.
    see = "(hidden) => { Object.defineProperty(document, 'hidden', { value: hidden, configurable: true }); document.dispatchEvent(new Event('visibilitychange')); }"
    page.evaluate(see, True)
    time.sleep(1)
    before_s = now_s()
    time.sleep(6)
    assert 0 <= now_s() - before_s < 4.5
    page.evaluate(see, False)
    wait(page, f"{NOW_S} > {before_s + 5}")


def test_the_emulated_board_is_live_at_every_width_in_light_and_dark(view: Start) -> None:
    page = view("--emulated").page()
    wait(page, "document.getElementById('phase')?.textContent === 'sliding' && document.getElementById('frequency').textContent.includes('Hz')")
    drawn(page, *PANELS)
    for _look in looks(page):
        drawn(page, "strips", "history", "map")

    def pixels() -> str:
        return page.evaluate("document.querySelector('#strips canvas').toDataURL()")

    before = pixels()
    page.wait_for_timeout(500)
    assert pixels() != before, "it is live"
    page.click("#pause")
    page.wait_for_timeout(300)
    still, received = pixels(), text(page, "lost-small")
    page.wait_for_timeout(700)
    assert (pixels(), text(page, "lost-small")) == (still, received), "it is paused"
    page.click("#pause")
    page.wait_for_timeout(500)
    assert pixels() != still, "it goes on"


def test_the_picture_of_the_page_shows_the_period_of_the_first_scene(view: Start, tmp_path: Path) -> None:
    """Takes the documents' picture, saved in the folder that `cargo xtask pictures` names."""
    page = view("--emulated").page((1280, 978))
    wait(page, "/, 5\\.[34] s$/.test(document.querySelector('#source')?.textContent)")
    period, sigma = re.fullmatch(r"(\S+) ± (\S+) mm", text(page, "period")).groups()  # type: ignore[union-attr]
    assert abs(float(period) - 3.6) < 2 * float(sigma)
    drawn(page, *PANELS)
    picture = Path(os.environ.get("RIDGETONE_PICTURES", tmp_path)) / "view.png"
    page.screenshot(path=picture)
    assert picture.stat().st_size > 10_000
