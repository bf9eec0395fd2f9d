"""Helpers for the page of `ridgetone view` in Chromium."""

import contextlib
import csv
import io
import json
import math
import os
import random
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

ROOT = Path(__file__).parents[3]
COMMAND = os.environ.get("RIDGETONE_COMMAND", str(ROOT / "target/debug/ridgetone"))
RECORDINGS = os.environ.get("RIDGETONE_RECORDINGS", str(ROOT / "target/debug/examples/page_recordings"))
CHROMIUM = os.environ.get("RIDGETONE_BROWSER") or shutil.which("chromium")
PATIENCE_MS = 120_000
WIDTHS = {"phone": (390, 844), "tablet": (800, 900), "desk": (1400, 900)}
# Controls smaller than 44 px, too small for a finger on a phone (WCAG 2.2, 2.5.5).
TARGETS = """() => [...document.querySelectorAll("button, select, input, a, label.button")]
    .filter((target) => target.id !== "file").map((target) => [target, target.getBoundingClientRect()])
    .filter(([, { width, height }]) => width > 0 && (height < 44 || width < 44))
    .map(([target, { width, height }]) => `${target.id || target.textContent} ${width} x ${height}`)"""
READABLE = (Path(__file__).parent / "readable.js").read_text()
# Fraction of a canvas's pixels that are not empty.
DRAWN = """(canvas) => {
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", { willReadFrequently: true });
    copy.drawImage(canvas, 0, 0);
    const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
    return data.filter((value, at) => at % 4 === 3 && value > 0).length / (data.length / 4); }"""


def ridgetone(*arguments: object) -> list[dict[str, Any]]:
    """Returns the JSON lines that a command prints."""
    done = subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True, check=True, cwd=ROOT)
    return [json.loads(line) for line in done.stdout.splitlines()]


class View:
    """`ridgetone view`, running until it is ended, and its pages."""

    def __init__(self, browser: Browser, arguments: tuple[object, ...]) -> None:
        words = [COMMAND, "view", *map(str, arguments)]
        self.process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT)
        assert self.process.stdout
        self.url = self.process.stdout.readline().strip()
        self.browser = browser
        self.said: list[str] = []

    def page(self, size: tuple[int, int] = (1280, 800), **more: Any) -> Page:
        """Opens a page. `said` collects console messages and requests to other addresses."""
        width, height = size
        page = self.browser.new_page(viewport={"width": width, "height": height}, accept_downloads=True, **more)
        page.set_default_timeout(PATIENCE_MS)
        page.on("console", lambda message: self.said.append(message.text))
        page.on("pageerror", lambda error: self.said.append(str(error)))
        own = (self.url, f"blob:{self.url}")
        page.on("request", lambda sent: sent.url.startswith(own) or self.said.append(sent.url))
        page.goto(self.url)
        return page

    def ended(self, **more: Any) -> Page:
        """Opens the page of a recording that is played at once, and waits for its end."""
        page = self.page(**more)
        wait(page, "document.getElementById('status').textContent.startsWith('The recording is over')")
        return page

    def refused(self) -> int:
        """Removes the browser's messages about refused requests, and returns their number."""
        before = len(self.said)
        self.said[:] = [said for said in self.said if "status of 422" not in said]
        return before - len(self.said)

    def end(self) -> None:
        self.process.kill()
        self.process.communicate()


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        # The sandbox needs a user other than root. Only our own page is opened.
        yield playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])


@pytest.fixture
def view(browser: Browser) -> Iterator[Callable[..., View]]:
    """Starts commands. Fails if their pages reported anything that the test did not remove."""
    views: list[View] = []

    def start(*arguments: object) -> View:
        views.append(View(browser, arguments))
        return views[-1]

    yield start
    # Collect these before ending the commands: a page logs an error when its command is gone.
    said = [said for one in views for said in one.said]
    for context in browser.contexts:
        context.close()
    for one in views:
        one.end()
    assert said == []


@pytest.fixture(scope="session")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a folder with recordings of the simulated finger, and tables."""
    folder = tmp_path_factory.mktemp("recordings")
    subprocess.run([RECORDINGS, folder], check=True)
    subprocess.run([COMMAND, "export", folder / "slower.rec", "-o", folder / "slower.mcap"], check=True)
    table(folder / "sound.csv", 8000, 1.5, lambda t: [math.sin(2 * math.pi * 440.25 * t)])
    table(folder / "two.csv", 500, 8, lambda t: [math.sin(2 * math.pi * (12 if t < 4 else 17) * t + c) for c in (0, 1, 2)])
    (folder / "letter.txt").write_text("Dear all,\nthis is no table.\n")
    rows = (folder / "two.csv").read_text().splitlines()
    (folder / "untimed.csv").write_text("\n".join(row.split(",", 1)[1] for row in rows) + "\n")
    return folder


def table(path: Path, rate_hz: float, length_s: float, values: Callable[[float], list[float]]) -> None:
    noise = random.Random(7)
    times = [row / rate_hz for row in range(int(rate_hz * length_s))]
    lines = [[f"{t:.6f}", *(f"{v + noise.gauss(0, 0.05):.5f}" for v in values(t))] for t in times]
    head = ["time_s", *(f"c{c} [mV]" for c in range(len(lines[0]) - 1))]
    path.write_text("\n".join(",".join(line) for line in [head, *lines]) + "\n")


def wait(page: Page, expression: str) -> None:
    """Waits until an expression is true. Playwright's wait uses `eval`, which the page forbids."""
    until = time.monotonic() + PATIENCE_MS / 1000
    while not page.evaluate(expression):
        assert time.monotonic() < until, expression
        page.wait_for_timeout(50)


def saved(page: Page, what: str, how: str = "csv") -> tuple[str, bytes]:
    """Clicks the save button of a panel, and returns the file's name and content."""
    with page.expect_download() as download:
        page.click(f"#{what} [data-save={how}]")
    return download.value.suggested_filename, Path(download.value.path()).read_bytes()


def numbers(page: Page, what: str) -> list[list[float]]:
    """Returns the rows of a panel's table, with NaN for cells that are not numbers."""
    rows = list(csv.reader(io.StringIO(saved(page, what)[1].decode())))[1:]

    def number(cell: str) -> float:
        with contextlib.suppress(ValueError):
            return float(cell)
        return math.nan

    return [[number(cell) for cell in row] for row in rows]


def text(page: Page, name: str) -> str:
    return page.locator(f"#{name}").text_content() or ""


def drawn(page: Page, *plots: str) -> None:
    for plot in plots:
        assert page.evaluate(f"({DRAWN})(document.querySelector('#{plot} canvas'))") > 0.01, plot


def drop(page: Page, *paths: Path) -> None:
    """Drops local files onto the page."""
    files = [[path.name, list(path.read_bytes())] for path in paths]
    page.evaluate(
        """(files) => {
            const dataTransfer = new DataTransfer();
            for (const [name, bytes] of files) dataTransfer.items.add(new File([new Uint8Array(bytes)], name));
            document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
        }""",
        files,
    )


def drag(page: Page, plot: str, begin: float, end: float, height: float = 0.5) -> None:
    """Drags across a plot; `begin` and `end` are fractions of its width."""
    over = page.locator(f"#{plot} .u-over")
    over.scroll_into_view_if_needed()
    box = over.bounding_box()
    assert box
    page.mouse.move(box["x"] + begin * box["width"], box["y"] + height * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + end * box["width"], box["y"] + height * box["height"], steps=4)
    page.mouse.up()


def looks(page: Page) -> Iterator[str]:
    """Asserts at every width, light and dark, that nothing overflows and all is readable."""
    for name, (width, height) in WIDTHS.items():
        for scheme in ("light", "dark"):
            page.set_viewport_size({"width": width, "height": height})
            page.emulate_media(color_scheme=scheme)
            page.wait_for_timeout(300)
            assert page.evaluate("document.documentElement.scrollWidth") <= width, (name, scheme)
            assert page.evaluate(READABLE) == [], (name, scheme)
            if name == "phone":
                assert page.evaluate(TARGETS) == [], scheme
            yield f"{name}-{scheme}"
