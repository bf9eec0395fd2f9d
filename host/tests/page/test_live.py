"""Tests a board or a played recording: numbers, plots, cursor, saved files, ports."""

import os
import pty
import re
import threading
import time
import tty
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import View, drag, drawn, looks, numbers, ridgetone, saved, text, wait

Start = Callable[..., View]
PANELS = ("strips", "history", "spectrum", "fit", "map")


def test_a_played_recording_has_the_numbers_of_json_and_can_be_saved(view: Start, recordings: Path, tmp_path: Path) -> None:
    arguments = ("--file", recordings / "part.rec", "--pace", 0)
    page = view(*arguments).ended()
    estimates = [line for line in ridgetone("monitor", "--json", *arguments) if line["type"] == "estimate"]
    latest = estimates[-1]
    value, sigma = re.fullmatch(r"(\S+) ± (\S+) Hz", text(page, "frequency")).groups()  # type: ignore[union-attr]
    decimals = len(value.split(".")[1])
    assert decimals >= 4
    assert (value, sigma) == (f"{latest['frequency_hz']:.{decimals}f}", f"{latest['sigma_hz']:.{decimals}f}")
    assert text(page, "phase") == "sliding"
    wait(page, "[...document.querySelectorAll('main .empty')].every((text) => text.hidden)")
    drawn(page, *PANELS)
    # The channels saved as CSV are a recording in which `fit` finds the tone.
    name, content = saved(page, "strips")
    assert re.fullmatch(r"ridgetone-strips-.*\.csv", name)
    (tmp_path / "strips.csv").write_bytes(content)
    (fit,) = ridgetone("fit", tmp_path / "strips.csv", "--from", latest["t_s"] - 1, "--to", latest["t_s"], "--json")
    assert abs(fit["frequency_hz"] - latest["frequency_hz"]) < 2 * latest["sigma_hz"]
    for what, rows in [("history", len(estimates)), ("spectrum", 127), ("fit", 241), ("map", 16)]:
        assert len(numbers(page, what)) == rows, what
    for what in PANELS:
        name, picture = saved(page, what, "png")
        assert name.endswith(".png") and picture.startswith(b"\x89PNG\r\n\x1a\n") and len(picture) > 2000
    # Dragging across the spectrum zooms in and pauses.
    page.select_option("#spectrum-x", "linear")
    drag(page, "spectrum", 0.2, 0.6)
    page.wait_for_selector("body.paused")
    zoomed = [row[0] for row in numbers(page, "spectrum")]
    assert 37 <= len(zoomed) < 65 and zoomed[0] > 15 and zoomed[-1] < 80
    # Everything that a caption names must be drawn.
    assert "residual" in text(page, "spectrum-small") and "all harmonics" in text(page, "fit-small")
    windows = [line["status"] == "good" for line in estimates if line["span"] == "window"]
    slides = [line for line in estimates if line["span"] == "slide"]
    expected = {"window ± σ": any(windows), "not good": not all(windows), "whole slide": bool(slides)}
    named = page.locator("#history [data-drawn]:visible").all_text_contents()
    assert [name.strip() for name in named] == [name for name, is_there in expected.items() if is_there]


def test_missing_frames_and_an_unsteady_tone_are_explained(view: Start, recordings: Path) -> None:
    started = view("--file", recordings / "unsteady.rec", "--pace", 0)
    page = started.ended()
    why = page.locator("#strips .empty").text_content()
    assert why == "This recording holds no raw frames, from which this is drawn."
    drawn(page, "history", "map")
    for part in ("unsteady", "wander 2.0 %", "other tone 12.50 Hz, 25 % of the power", "shorten the window, or give the speed"):
        assert part in text(page, "frequency-small")
    started.end()
    wait(page, "document.getElementById('status').textContent.startsWith('The command cannot be reached')")
    assert page.locator("#latest").is_disabled() and page.locator("body.gone").count() == 1
    started.said.clear()


def point(page, plot: str, x: float, y: float, clicks: bool) -> list[str]:  # type: ignore[no-untyped-def]
    """Moves the mouse in a plot, clicks if `clicks`, and returns the cursor's text."""
    over = page.locator(f"#{plot} .u-over")
    over.scroll_into_view_if_needed()
    box = over.bounding_box()
    (page.mouse.click if clicks else page.mouse.move)(box["x"] + x * box["width"], box["y"] + y * box["height"])
    return cursor(page, plot)


def cursor(page, plot: str) -> list[str]:  # type: ignore[no-untyped-def]
    return page.locator(f"#{plot} .readout").evaluate("(out) => (out.hidden ? '' : out.textContent)").replace("−", "-").splitlines()


def test_the_cursor_reads_every_plot_and_two_clicks_show_a_difference(view: Start, recordings: Path) -> None:
    page = view("--file", recordings / "part.rec", "--pace", 0).ended()
    wait(page, "document.querySelector('#fit .empty').hidden")
    frames = numbers(page, "strips")
    read = []
    for x, y in [(0.4, 0.3), (0.6, 0.31)]:
        lines = point(page, "strips", x, y, True)
        t_s, taxel, mv = (float(n) for n in re.match(r"(\S+) s, taxel (\d+): (\S+) mV", lines[0]).groups())  # type: ignore[union-attr]
        row = min(frames, key=lambda row: abs(row[0] - t_s))
        assert abs(row[0] - t_s) < 0.003 and abs(1e3 * row[1 + int(taxel)] - mv) < 0.051
        read.append((row[0], 1e3 * row[1 + int(taxel)]))
    apart = next(line for line in cursor(page, "strips") if line.startswith("Δ "))
    d_s, hz, d_mv = (float(n) for n in re.match(r"Δ (\S+) s \((\S+) Hz\), (\S+) mV", apart).groups())  # type: ignore[union-attr]
    assert abs(d_s - (read[1][0] - read[0][0])) < 0.003 and abs(d_mv - (read[1][1] - read[0][1])) < 0.051
    assert abs(hz * (read[1][0] - read[0][0]) - 1) < 0.01
    # The difference stays when the mouse leaves; a third click clears it.
    point(page, "history", 0.5, 0.5, False)
    assert cursor(page, "strips") == [apart]
    assert len(point(page, "strips", 0.5, 0.5, True)) == 1
    assert re.search(r" ± .* Hz$", point(page, "history", 0.99, 0.5, False)[0])
    page.select_option("#spectrum-x", "log")
    bins = numbers(page, "spectrum")
    at, db = (float(n) for n in re.match(r"(\S+) Hz, [^:]*: (\S+)", point(page, "spectrum", 0.5, 0.5, False)[0]).groups())  # type: ignore[union-attr]
    bin_ = min(bins, key=lambda row: abs(row[0] - at))
    assert abs(bin_[0] / at - 1) < 0.02 and min(abs(value - db) for value in bin_[1:]) < 0.6
    assert re.search(r"residual: .* mV$", point(page, "fit", 0.5, 0.9, False)[0])
    # Use only the keyboard.
    page.focus("#fit .plot")
    for _ in range(2):
        page.keyboard.press("Enter")
        page.keyboard.press("Shift+ArrowRight")
    assert len(cursor(page, "fit")) == 2 and cursor(page, "fit")[1].startswith("Δ 0.00")
    page.keyboard.press("Escape")
    assert len(cursor(page, "fit")) == 1


def test_a_zoomed_plot_follows_after_resume_and_zero_shows_all(view: Start, recordings: Path) -> None:
    page = view("--file", recordings / "touch.rec", "--pace", 0.25).page()
    now = "parseFloat(document.getElementById('source')?.textContent.split(', ').at(-1))"
    wait(page, f"{now} > 2.2")
    page.focus("#strips .plot")
    page.keyboard.press("+")
    page.wait_for_selector("body.paused")

    def ends() -> tuple[float, float]:
        rows = numbers(page, "strips")
        return rows[0][0], rows[-1][0]

    begin, end = ends()
    page.click("#pause")
    wait(page, f"{now} > {end + 1.2}")
    later, until = ends()
    assert abs((until - later) - (end - begin)) < 0.02 and later > begin + 0.3
    page.focus("#strips .plot")
    page.keyboard.press("0")
    all_, until = ends()
    assert until - all_ > 1.5 * (end - begin)


def test_one_wild_estimate_and_one_spike_stretch_no_axis(view: Start, recordings: Path) -> None:
    axes = []
    for name in ("part.rec", "wild.rec"):
        page = view("--file", recordings / name, "--pace", 0).ended()
        wait(page, "document.querySelector('#fit .empty').hidden")
        axes.append([page.locator(f"#{plot} .plot").get_attribute("aria-description") or "" for plot in ("strips", "history")])
        assert text(page, "history-small") == ("" if name == "part.rec" else "1 beyond the axis")
    assert axes[0][0] == axes[1][0], "the rows of the channels"
    plain, wild = ([float(end) for end in re.findall(r"[\d.]+", shown[1])] for shown in axes)
    assert wild[1] - wild[0] < 3 * (plain[1] - plain[0])


def test_values_of_the_touch_before_are_marked(view: Start, recordings: Path) -> None:
    page = view("--file", recordings / "part.rec", "--pace", 0).ended()
    marked = page.evaluate(
        """async () => {
            const { tiles } = await import("/panels.js");
            const estimate = { frequency_hz: 4, sigma_hz: 0.1, status: "good", span: "window", window_s: 1, t_s: 3, faults: [], travel: "known", spatial_period_mm: 3, spatial_period_sigma_mm: 0.1, speed_mm_s: 10, speed_sigma_mm_s: 1, direction: "forward" };
            const at = (contact_s) => {
                const live = { latest: { estimate }, counts: { received: 9, missing: 0, damaged: 0 }, phase: "held", phase_since_s: 4, touches: 2, contact_s };
                tiles({ remarks: [], live });
                return ["frequency", "period", "speed"].map((id) => [document.getElementById(id).classList.contains("past"), /of the touch before/.test(document.getElementById(`${id}-small`).textContent)]);
            };
            return [at(4), at(1)];
        }"""
    )
    assert marked == [[[True, True]] * 3, [[False, False]] * 3]


def test_a_port_on_the_page_is_connected_and_one_in_use_names_its_user(view: Start, recordings: Path) -> None:
    board, line = pty.openpty()
    tty.setraw(board)
    name = os.ttyname(line)
    started = view("--port", name)
    page = started.page()
    # A board at another port, which the page connects by its name.
    other, other_line = pty.openpty()
    tty.setraw(other)
    listed = [{"name": os.ttyname(other_line), "usb": None, "used_by": []}, {"name": name, "usb": None, "used_by": ["ridgetone (process 1)"]}]
    page.route("**/ports", lambda route: route.fulfill(json=listed))
    page.click("#ports-list")
    wait(page, "document.querySelectorAll('#port-rows li').length === 2")
    assert "in use by ridgetone (process 1)" in text(page, "port-rows")
    page.click(f"[aria-label='Connect {name}']")
    wait(page, "document.getElementById('ports-message').textContent.includes('in use by')")
    assert str(started.process.pid) in text(page, "ports-message")
    assert started.refused() == 1
    content = (recordings / "part.rec").read_bytes().split(b"\0", 1)[1]

    def send() -> None:
        for at in range(0, len(content), 512):
            os.write(other, content[at : at + 512])
            time.sleep(0.002)

    page.click(f"[aria-label='Connect {os.ttyname(other_line)}']")
    wait(page, f"document.getElementById('source').textContent.includes('{os.ttyname(other_line)}')")
    threading.Thread(target=send, daemon=True).start()
    wait(page, "document.getElementById('frequency').textContent.includes('Hz')")


def test_gaps_and_windows_that_are_not_good_are_not_drawn_over(view: Start, recordings: Path) -> None:
    page = view("--file", recordings / "begin.rec", "--pace", 0).ended()
    make = "const make = async (file, name) => new (await import(`/${file}.js`))[name](document.getElementById(file).cloneNode(true), () => {});"
    strips = page.evaluate(
        f"""async () => {{ {make} const plot = await make("strips", "Strips"); const t_s = [0, 0.004, 0.008, 1, 1.004, 1.008];
            plot.draw({{ live: {{ strips: {{ t_s, volts: Array.from({{ length: 16 }}, () => t_s) }} }} }}, 2); return plot.data.slice(0, 2); }}"""
    )
    assert len(strips[0]) == 7 and [at for at, value in enumerate(strips[1]) if value is None] == [3]
    history = page.evaluate(
        f"""async () => {{ {make} const plot = await make("history", "History");
            const points = ["good", "good", "ambiguous", "good"].map((status, at) => ({{
                t_s: 0.25 * at, status, span: "window", frequency: status === "good" ? 4 : 2.9, sigma: 1 }}));
            plot.draw({{ live: {{ history: points, now_s: 1, latest: {{}} }} }}, 30); return [...plot.data.slice(1, 4), plot.axis.range]; }}"""
    )
    for line in history[:3]:
        assert [at for at, value in enumerate(line) if value is None] == [2]
    assert history[3][0] < 3.6 and history[3][1] > 4.4


# Draws a spectrum. Returns its texts, and the pairs that overlap.
OVERLAPS = """async ([rate, harmonics, isLog]) => {
    const texts = [];
    const { fillText } = CanvasRenderingContext2D.prototype;
    CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
        const { width } = this.measureText(text);
        const { e, f, b } = this.getTransform();
        const begin = e + x - { left: 0, start: 0, center: 0.5, right: 1, end: 1 }[this.textAlign] * width;
        if (b === 0) texts.push({ ctx: this, text, begin, end: begin + width, y: Math.round(f + y) });
        fillText.call(this, text, x, y);
    };
    const { Spectrum } = await import("/spectrum.js");
    const plot = new Spectrum(document.getElementById("spectrum").cloneNode(true), () => {});
    const power_db = Array.from({ length: 256 }, (_, bin) => -40 + bin % 7);
    const lines = Array.from({ length: harmonics }, (_, at) => ({ frequency_hz: 0.01 * rate * (1 + at), power_db: -10 }));
    plot.draw({ spectrum: { power_db, bin_hz: rate / 512, lines } }, isLog);
    await new Promise((resolve) => setTimeout(resolve, 50));
    texts.length = 0;
    plot.plot.redraw();
    await new Promise((resolve) => setTimeout(resolve, 50));
    CanvasRenderingContext2D.prototype.fillText = fillText;
    // A busy browser draws twice.
    const key = ({ text, begin, y }) => `${text} ${begin} ${y}`;
    const own = texts.filter((one, at) => one.ctx === plot.plot.ctx && texts.findIndex((other) => key(other) === key(one)) === at);
    const overlaps = own.flatMap((one, at) => own.slice(at + 1)
        .filter((other) => Math.abs(other.y - one.y) < 11 && other.begin < one.end + 3 && one.begin < other.end + 3)
        .map((other) => `${one.text} ${other.text}`));
    return [own.map(({ text }) => text), overlaps]; }"""


def test_texts_do_not_overlap_and_the_events_use_their_room(view: Start, recordings: Path) -> None:
    page = view("--file", recordings / "begin.rec", "--pace", 0).ended()
    for rate_hz in (30.0, 241.14, 1458.8, 14_000.0, 23_739.0):
        for harmonics, is_log in [(4, True), (16, True), (4, False), (16, False)]:
            texts, overlaps = page.evaluate(OVERLAPS, [rate_hz, harmonics, is_log])
            assert overlaps == [], (rate_hz, is_log)
            shown = [t for t in texts if re.fullmatch(r"[\d.]+", t) and float(t) > 0]
            assert "f" in texts and len(shown) > int(is_log), (rate_hz, texts)
    # Ten updates a second: from a board that runs at half speed, and from one that restarts.
    first, slow, restarted = page.evaluate(
        """async () => { const { Pace } = await import("/model.js"); const pace = new Pace();
            const first = pace.take(10, 1); let slow;
            for (let t = 1; t < 80; t += 1) slow = pace.take(10 + 0.1 * t, 1 + 0.05 * t);
            return [first, slow, pace.take(18, 0)]; }"""
    )
    assert first is None and restarted is None and slow == pytest.approx(0.5)
    # The list of events must reach the bottom of its box.
    list_, card = (page.locator(name).bounding_box() for name in ("#lines", "#log"))
    assert list_ and card
    assert card["y"] + card["height"] - list_["y"] - list_["height"] < 20 and list_["height"] >= 190


def test_a_played_recording_looks_right_at_every_width_in_light_and_dark(view: Start, recordings: Path) -> None:
    page = view("--file", recordings / "part.rec", "--pace", 0).ended()
    for _look in looks(page):
        drawn(page, "strips", "history", "map")
