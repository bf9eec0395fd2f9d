"""Measure the images that get flashed on the emulator: docs/results/boards.md.

    python lab/boards.py            builds the images; a minute or two after that
    python lab/boards.py --short    compares the Feather with the page instead; writes nothing

Needs the target thumbv7em-none-eabihf, as `cargo xtask firmware` does.
"""

import argparse
import json
import struct
import subprocess
import sys

import pages

BOARDS = ("feather-f405", "nucleo-f446re")
RAM = 128
START = ("from power-up to START, ms", "from power-up to the first conversion that is read, ms", "from power-up to the end of `hello` on the line, ms", "conversions lost at the start")
PHASES = ("in the air", "in contact", "sliding, with fits")
TOLERANCE = 0.05
"""Allowed deviation of figures made by another compiler, as a fraction; or 0.3."""


def image(board):
    """Builds an image and returns its path."""
    subprocess.run(["cargo", "xtask", "firmware", "--board", board], cwd=pages.ROOT, check=True, stdout=sys.stderr)
    return pages.ROOT / "target" / "firmware" / board / "ridgetone-firmware.elf"


def memory(path):
    """Returns KiB of flash and of RAM, from the sections of an ELF file that are loaded or
    allocated. The stack gets the rest of the RAM."""
    elf = path.read_bytes()
    start, size, count = struct.unpack_from("<I", elf, 32)[0], *struct.unpack_from("<HH", elf, 46)
    flash = ram = 0
    for at in range(start, start + size * count, size):
        _, kind, flags, address, _, length = struct.unpack_from("<6I", elf, at)
        is_kept, is_ram = flags & 2 and length, address >= 0x2000_0000
        # Initial values of statics are in flash too; sections of type 8 (NOBITS) have none.
        flash += length if is_kept and kind != 8 else 0
        ram += length if is_kept and is_ram else 0
    return flash / 1024, ram / 1024


def measured(board):
    path = image(board)
    words = ["cargo", "run", "--quiet", "--release", "-p", "ridgetone-bench", "--bin", "boards", "--", board, str(path)]
    done = subprocess.run(words, cwd=pages.ROOT, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout) | dict(zip(("flash_kib", "ram_kib"), memory(path), strict=True))


def tables(found):
    one = lambda values: [pages.fixed(value, 1) for value in values]
    rows = [[name, *(pages.fixed(found[board]["start_ms"][at], 1) for board in found)] for at, name in enumerate(START)]
    for name, rate in (("load_percent", "5,064"), ("load_fast_percent", "23,739")):
        rows += [[f"load {phase}, {rate} conversions a second, %", *one(found[board][name][at] for board in found)] for at, phase in enumerate(PHASES)]
    latency = [found[board]["latency_ms"] for board in found]
    rows += [["from the end of a window to its estimate on the line, mean, ms", *one(each[0] for each in latency)], ["longest, ms", *one(each[1] for each in latency)]]
    rows += [[f"jitter of time stamps, {what}, us", *one(found[board]["jitter_us"][at] for board in found)] for at, what in enumerate(("no byte arrives", "bytes arrive one behind the other"))]
    rows += [["flash of the image, KiB", *one(found[board]["flash_kib"] for board in found)], [f"RAM of its statics, of {RAM} KiB, KiB", *one(found[board]["ram_kib"] for board in found)]]
    tasks = [[f"`{task}`", int(figures[0]), *one(figures[1:])] for task, figures in found[BOARDS[0]]["tasks"].items()]
    return {"boards": pages.table("|".join(["", *found]), rows), "tasks": pages.table("task|runs|mean, us|longest, us|mean wait, us|longest wait, us", tasks)}


def differences(fresh, shipped, board):
    """Returns the figures of a board that differ from those on the page."""
    column = shipped["boards"]["columns"].index(board)
    pairs = [(row[0], row[1], next((old[column] for old in shipped["boards"]["rows"] if old[0] == row[0]), None)) for row in fresh["boards"]["rows"]]
    old_tasks = {row[0]: row for row in shipped["tasks"]["rows"]}
    for row in fresh["tasks"]["rows"]:
        pairs += [(f"{row[0]}, {name}", *both) for name, *both in zip(shipped["tasks"]["columns"][1:], row[1:], old_tasks[row[0]][1:], strict=True)]
    return [f"{name}: {new}, the page has {old}" for name, new, old in pairs if old is None or abs(new - old) > max(0.3, TOLERANCE * abs(old))]


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--short", action="store_true", help="compare the Feather with the page; writes nothing")
    given = arguments.parse_args()
    found = {board: measured(board) for board in (BOARDS[:1] if given.short else BOARDS)}
    fresh = tables(found)
    if given.short:
        print(pages.markdown(fresh["boards"]))
        return "\n".join(differences(fresh, pages.load("boards")["tables"], BOARDS[0])) or 0
    # The page shows the figures of the busier board.
    most = lambda name, at: max(found[board][name][at] for board in found)
    values = {"load_rest": round(most("load_percent", 0)), "load_sliding": round(most("load_percent", 2)), "latency_ms": round(most("latency_ms", 0))}
    pages.save("boards", fresh, values)
    return 0


if __name__ == "__main__":
    sys.exit(main())
