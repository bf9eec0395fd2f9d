"""The notebook reproduces the README's picture; the guide's code, the examples and the types are correct."""

import doctest
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
import ridgetone as rt
from conftest import COMMAND, ROOT, command
from nbclient import NotebookClient


# A kernel starts within seconds, or within a minute or two while other tests keep the processor busy.
@pytest.mark.timeout(400)
def test_the_notebook_goes_from_a_recording_to_the_readmes_picture(tmp_path: Path) -> None:
    notebook = nbformat.read(ROOT / "host/python" / "touch.ipynb", as_version=4)
    scene = ROOT / "hal-mock/scenes/demo.toml"
    recorded = command("record", f"--emulated={scene}", "--raw", "-o", tmp_path / "touch.rec")
    assert recorded.returncode == 0, recorded.stderr
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = [output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", [])]
    html = "".join(data.get("text/html", "") for data in shown)
    assert re.search(r"frequency_hz</td><td>6\.06\d* ± 0\.00\d+<", html), html
    assert sum("image/svg+xml" in data for data in shown) == 2
    drawn = (tmp_path / "touch.svg").read_text()
    readme = (ROOT / "docs" / "demo.svg").read_text()
    title = re.compile(r"Sixteen taxels, one tone: ([\d.]+) ± [\d.]+ Hz")
    ours, theirs = title.search(drawn), title.search(readme)
    assert ours and theirs and abs(float(ours[1]) / float(theirs[1]) - 1) < 1e-3, (ours, theirs)
    labels = re.compile(r">(taxel|samples|fit|window of the fit|sliding phase|contact, release)<")
    assert sorted(set(labels.findall(drawn))) == sorted(set(labels.findall(readme)))
    # Ticks of the axes depend on the length of the recording.
    curves = re.compile(r'<path[^>]*class="(?!axis)')
    assert len(curves.findall(drawn)) == len(curves.findall(readme))


def test_the_chapters_code_runs(telemetry: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    os.symlink(telemetry["rec"], tmp_path / "touch.rec")
    monkeypatch.chdir(tmp_path)
    for chapter, least in (("1-first-hour.md", 1), ("4-recordings.md", 5)):
        page = (ROOT / "docs" / "guide" / chapter).read_text()
        blocks = re.findall(r"```python\n(.*?)```", page, re.S)
        assert len(blocks) >= least
        names: dict[str, object] = {}
        for block in blocks:
            if "sys.argv" in block:
                run_beside_the_emulated_board(block)
            else:
                exec(compile(block, chapter, "exec"), names)  # noqa: S102


def run_beside_the_emulated_board(script: str) -> None:
    """Runs a script that reads the port of an emulated board; the port's name is its argument."""
    with subprocess.Popen([COMMAND, "emulate", "--port"], stdout=subprocess.PIPE, text=True, cwd=ROOT) as board:
        assert board.stdout is not None
        port = re.search(r"/dev/\S+", board.stdout.readline())
        try:
            assert port
            read = subprocess.run([sys.executable, "-c", script, port[0]], capture_output=True, text=True, timeout=60)
        finally:
            board.send_signal(signal.SIGINT)
    assert read.returncode == 0 and "bytes:" in read.stdout, read.stderr


def test_examples_and_types() -> None:
    for module in (rt, rt._replayed, rt._simulate):
        tried = doctest.testmod(module)
        assert tried.attempted > 0 and tried.failed == 0, module
    checked = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", ROOT / "host/python" / "pyproject.toml", ROOT / "host/python" / "package" / "ridgetone"],
        capture_output=True,
        text=True,
    )
    assert checked.returncode == 0, checked.stdout


def test_everything_public_is_documented() -> None:
    for name in rt.__all__:
        thing = getattr(rt, name)
        if callable(thing) and not isinstance(thing, type):
            assert thing.__doc__ and thing.__annotations__["return"], name
