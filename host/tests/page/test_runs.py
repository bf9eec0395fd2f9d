"""Tests runs: moving in time, comparing, notes, saving, reading with other settings."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import View, drawn, drop, numbers, ridgetone, text, wait

Start = Callable[..., View]
NOW_S = "parseFloat(document.getElementById('source')?.textContent.split(', ').at(-1))"


def go(page, t_s: float) -> None:  # type: ignore[no-untyped-def]
    """Moves the slider of a run, and waits for the state at that time."""
    with page.expect_response(re.compile("state.json")):
        page.locator("#time").evaluate("(time, t_s) => { time.value = t_s; time.dispatchEvent(new Event('input', { bubbles: true })); }", t_s)
    wait(page, f"Math.abs({NOW_S} - {t_s}) < 0.06")


def test_a_run_is_scrubbed_compared_and_has_new_settings(view: Start, recordings: Path) -> None:
    page = view(recordings / "quiet.rec").page()
    wait(page, "document.querySelectorAll('#run-rows tr').length === 1")
    for name in ("touch.rec", "slower.mcap"):
        drop(page, recordings / name)
        wait(page, f"document.getElementById('recording-name').textContent === '{name}'")
    page.click("[aria-label='Look touch.rec']")
    wait(page, "document.getElementById('recording-name').textContent === 'touch.rec'")
    lines = ridgetone("monitor", "--file", recordings / "touch.rec", "--pace", 0, "--json")
    windows = [line for line in lines if line.get("span") == "window"]
    go(page, 0.2)
    assert text(page, "phase") == "no contact"
    go(page, windows[1]["t_s"] + 0.02)
    assert text(page, "phase") == "sliding"
    assert float(text(page, "frequency").split()[0]) == pytest.approx(windows[1]["frequency_hz"], rel=1e-5)
    drawn(page, "strips", "history", "spectrum", "fit", "map")
    # The space bar starts and stops playback even while the slider has focus.
    page.focus("#time")
    page.keyboard.press(" ")
    assert text(page, "play") == "Stop"
    page.keyboard.press(" ")
    assert text(page, "play") == "Play"
    # The two runs have 30 and 20 mm/s over the same grating.
    page.click("[aria-label='Compare slower.mcap']")
    wait(page, "document.getElementById('difference').textContent.includes('touch.rec − slower.mcap: ')")
    found = re.search(r"mcap: (\S+)", text(page, "difference"))
    assert found and float(found[1]) == pytest.approx(windows[1]["frequency_hz"] / 3, rel=0.03)
    # Reads the frames with other settings. Without an estimate, the page must show the reason.
    for window_s, words in [("3.9", "s, fills no window of 3.9 s"), ("0.5", "with the new settings")]:
        page.fill("#window_s", window_s)
        page.click("#settings-send")
        wait(page, f"document.getElementById('settings-message').textContent.includes('{words}')")
    wait(page, "document.getElementById('frequency-small').textContent.includes('window of 0.50 s')")
    # Keys zoom and move a plot, and show all of it again.
    all_ = numbers(page, "strips")
    page.press("#strips .plot", "+")
    near = numbers(page, "strips")
    assert len(near) / (2 * 241) == pytest.approx(0.6, abs=0.05)
    page.press("#strips .plot", "ArrowLeft")
    assert near[0][0] - numbers(page, "strips")[0][0] == pytest.approx(0.2 * 1.2, abs=0.05)
    page.press("#strips .plot", "0")
    assert len(numbers(page, "strips")) == len(all_)
    # Every control must have a name for screen readers.
    tree = page.locator("body").aria_snapshot()
    for role in ("button", "slider", "spinbutton", "combobox", "link", "textbox"):
        assert not re.search(rf"^\s*- {role}$", tree, re.MULTILINE), role
    for part in ('slider "time', 'button "Compare slower.mcap"', 'link "Save touch.rec"', 'group "Spectrum, plot'):
        assert part in tree, part


def test_runs_have_notes_are_reloaded_and_do_not_go_unsaved(view: Start, recordings: Path, tmp_path: Path) -> None:
    path = tmp_path / "touch.rec"
    path.write_bytes((recordings / "touch.rec").read_bytes())
    page = view("--file", path, "--pace", 0.5).page()
    wait(page, "document.querySelectorAll('#run-rows tr').length === 1")
    # Clearing removes received frames from the page, but keeps later ones.
    wait(page, f"{NOW_S} > 0.8")
    before_s = page.evaluate(NOW_S)
    page.click("#clear")
    wait(page, f"{NOW_S} > {before_s} + 0.5")
    assert numbers(page, "strips")[0][0] > before_s - 0.1
    # A different program rewrites the file.
    path.unlink()
    path.write_bytes((recordings / "quiet.rec").read_bytes())
    page.click("[aria-label='Reload touch.rec']")
    wait(page, "document.querySelector('#run-rows tr').children[1].textContent.startsWith('0.4')")
    # Neither the page nor the run may close without a warning before it is saved.
    page.click("#latest")
    wait(page, "document.querySelectorAll('#run-rows tr').length === 2")
    row = page.locator("#run-rows tr").last
    assert ".rec, not saved" in (row.text_content() or "")
    leaves = "() => { const event = new Event('beforeunload', { cancelable: true }); window.dispatchEvent(event); return !event.defaultPrevented; }"
    assert page.evaluate(leaves) is False
    asked = []
    page.once("dialog", lambda dialog: (asked.append(dialog.message), dialog.dismiss()))
    row.locator("[aria-label^=Close]").click()
    assert "is not saved" in asked[0] and page.locator("#run-rows tr").count() == 2
    # A note is kept by the command, and is part of the file's name. Typing it must not move the
    # slider.
    t_s = page.input_value("#time")
    row.locator("input").press_sequentially("oak,2")
    row.locator("input").blur()
    assert page.input_value("#time") == t_s
    wait(page, "fetch('/runs').then((r) => r.json()).then((all) => all[1].note === 'oak,2')")
    with page.expect_download() as download:
        row.locator("a").click()
    assert download.value.suggested_filename.endswith("s-oak-2.rec")
    assert Path(download.value.path()).read_bytes().startswith(b"ridgetone telemetry")
    wait(page, "!document.querySelector('#run-rows tr:last-child').textContent.includes('not saved')")
    assert page.evaluate(leaves) is True
