"""Tests files on the page: the whole recording, and `fit` of the selected part."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import View, drag, drawn, drop, looks, ridgetone, text, wait

Start = Callable[..., View]


def shown(page) -> tuple[float, float]:  # type: ignore[no-untyped-def]
    """Returns the frequency and sigma on the page."""
    wait(page, "/ Hz$/.test(document.getElementById('part-frequency').textContent)")
    value, sigma = re.fullmatch(r"(\S+) ± (\S+) Hz", text(page, "part-frequency")).groups()  # type: ignore[union-attr]
    return float(value), float(sigma)


def agrees(page, fit: dict) -> bool:  # type: ignore[no-untyped-def, type-arg]
    value, sigma = shown(page)
    digits = max(sigma, 1e-7)
    return abs(value - fit["frequency_hz"]) <= digits and text(page, "part-status").startswith(fit["status"])


@pytest.mark.parametrize("name", ["sound.csv", "two.csv", "touch.rec", "slower.mcap"])
def test_a_file_opens_with_all_of_it_and_the_answer_of_fit(view: Start, recordings: Path, name: str) -> None:
    path = recordings / name
    page = view(path).page()
    page.wait_for_selector("#overview canvas")
    (fit,) = ridgetone("fit", path, "--json")
    if fit["frequency_hz"] is None:
        assert text(page, "part-frequency") == "no tone"
    else:
        assert agrees(page, fit), (text(page, "part-frequency"), fit)
    drawn(page, "overview")
    head = page.evaluate("fetch('/runs').then((r) => r.json()).then(([run]) => fetch(`/runs/${run.id}/rows.json`)).then((r) => r.json())")
    assert head["rows"] >= fit["rows"] and len(head["values"]) == len(fit["channels"])
    # A table has no board, so the board's panels are hidden.
    assert page.locator("#health").is_visible() == name.endswith((".rec", ".mcap"))
    if name == "touch.rec":
        events = ridgetone("monitor", "--file", path, "--pace", 0, "--json")
        times = {kind: [e["t_s"] for e in events if e["type"] == kind] for kind in ("contact", "release")}
        assert head["touches"]["contacts_s"] == pytest.approx(times["contact"], abs=1e-6)
        assert head["touches"]["releases_s"] == pytest.approx(times["release"], abs=1e-6)
        assert len(head["touches"]["slides"]) == 1


def test_a_part_that_is_dragged_is_fitted_at_once_as_fit_does(view: Start, recordings: Path) -> None:
    path = recordings / "two.csv"
    started = view(path)
    page = started.page()
    page.wait_for_selector("#overview canvas")
    for begin, end, expected_hz in [(0.05, 0.45, 12), (0.55, 0.95, 17)]:
        with page.expect_response(re.compile("fit.json")):
            drag(page, "overview", begin, end)
        wait(page, "document.getElementById('part-status').textContent.startsWith('good')")
        from_s, until_s = page.input_value("#part-from"), page.input_value("#part-until")
        assert float(until_s) - float(from_s) == pytest.approx(8 * (end - begin), rel=0.05)
        (fit,) = ridgetone("fit", path, "--from", from_s, "--to", until_s, "--json")
        assert agrees(page, fit) and abs(fit["frequency_hz"] - expected_hz) < 0.01
    # The picture shows the part. A part without enough rows shows the reason instead of a number.
    page.click("#picture summary")
    wait(page, "document.getElementById('part-picture').naturalWidth > 500")
    page.fill("#part-from", "3")
    page.fill("#part-until", "3.01")
    page.press("#part-until", "Enter")
    wait(page, "document.getElementById('part-frequency').textContent === 'no tone'")
    page.fill("#part-from", "30")
    page.press("#part-from", "Enter")
    wait(page, "document.getElementById('part-frequency').textContent === 'no fit'")
    assert "two.csv" in text(page, "part-status") and "/tmp" not in text(page, "part-status")
    page.click("#part-none")
    (fit,) = ridgetone("fit", path, "--json")
    assert text(page, "part-status").startswith(fit["status"])
    assert started.refused() == 1


def test_the_wheel_zooms_shift_moves_and_keys_do_too(view: Start, recordings: Path) -> None:
    page = view(recordings / "sound.csv").page()
    page.wait_for_selector("#overview canvas")
    over = page.locator("#overview .u-over")
    box = over.bounding_box()
    assert box
    asked = []
    page.on("request", lambda sent: "rows.json" in sent.url and asked.append(sent.url))

    def ends() -> tuple[float, float]:
        page.wait_for_timeout(400)
        found = re.search(r"from_s=([^&]+)&until_s=([^&]+)", asked[-1])
        assert found
        return float(found[1]), float(found[2])

    page.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + 0.5 * box["height"])
    page.mouse.wheel(0, -800)
    near = ends()
    whole_s = 1.5 - 1 / 8000
    # The position under the mouse must not move.
    assert near[1] - near[0] == pytest.approx(whole_s / 2.718**2, rel=0.02)
    assert near[0] + 0.25 * (near[1] - near[0]) == pytest.approx(0.25 * whole_s, abs=0.01)
    page.keyboard.down("Shift")
    drag(page, "overview", 0.5, 0.3)
    page.keyboard.up("Shift")
    moved = ends()
    assert moved[0] - near[0] == pytest.approx(0.2 * (near[1] - near[0]), rel=0.05)
    assert page.input_value("#part-from") == "0", "nothing was selected"
    page.focus("#overview .plot")
    page.keyboard.press("+")
    assert ends()[1] - ends()[0] < near[1] - near[0]
    page.click("#zoom-all")
    assert ends() == pytest.approx((0, whole_s), abs=1e-6)
    # Two clicks show the difference in time, and in the file's unit.
    for share in (0.3, 0.6):
        page.mouse.click(box["x"] + share * box["width"], box["y"] + 0.5 * box["height"])
    readout = page.locator("#overview .readout").inner_text()
    assert re.search(r"Δ .* s \(.* Hz\), .* mV", readout), readout


def test_several_files_have_a_row_each_and_a_click_shows_one(view: Start, recordings: Path) -> None:
    started = view(recordings / "sound.csv")
    page = started.page()
    page.wait_for_selector("#overview canvas")
    drop(page, *(recordings / name for name in ("two.csv", "touch.rec", "letter.txt", "untimed.csv")))
    wait(page, "document.querySelectorAll('#run-rows tr').length === 3")
    wait(page, "!document.getElementById('rate-label').hidden")
    assert "letter.txt" in text(page, "runs-message") and "untimed.csv" in text(page, "runs-message")
    for name in ("sound.csv", "touch.rec"):
        (fit,) = ridgetone("fit", recordings / name, "--json")
        row = page.locator("#run-rows tr", has_text=name).locator("td").nth(3).text_content() or ""
        found = re.match(r"([\d.]+) ± ([\d.]+) Hz", row)
        assert found and abs(float(found[1]) - fit["frequency_hz"]) < 2 * float(found[2]), (row, fit)
    # A table without time stamps asks for its rate.
    page.fill("#rate", "500")
    page.click("#rate-open")
    wait(page, "document.getElementById('recording-name').textContent === 'untimed.csv'")
    page.click("[aria-label='Look touch.rec']")
    wait(page, "document.getElementById('recording-name').textContent === 'touch.rec'")
    wait(page, "/16 channels/.test(document.getElementById('recording-small').textContent)")
    assert started.refused() == 2


def test_another_file_leaves_nothing_of_the_one_before(view: Start, recordings: Path) -> None:
    page = view(recordings / "touch.rec").page()
    page.wait_for_selector("#overview canvas")
    wait(page, "document.querySelector('#fit .empty').hidden")
    drop(page, recordings / "quiet.rec")
    wait(page, "document.getElementById('recording-name').textContent === 'quiet.rec'")
    wait(page, "!document.querySelector('#fit .empty').hidden")
    for plot in ("fit", "history"):
        assert page.locator(f"#{plot} .plot").evaluate("(plot) => getComputedStyle(plot).visibility") == "hidden"
        assert page.locator(f"#{plot} .plot").get_attribute("aria-description") is None
    assert text(page, "fit-small") == ""
    assert "residual" not in text(page, "spectrum-small") and "Dashed" not in text(page, "spectrum-small")
    assert not page.locator("#history .dot").filter(visible=True).count()


@pytest.mark.parametrize("name", ["sound.csv", "touch.rec"])
def test_a_file_looks_right_at_every_width_in_light_and_dark(view: Start, recordings: Path, name: str) -> None:
    page = view(recordings / name).page()
    page.wait_for_selector("#overview canvas")
    for _look in looks(page):
        drawn(page, "overview")
