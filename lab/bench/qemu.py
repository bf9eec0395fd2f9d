"""Runs the bench image under QEMU and on the emulator, and compares the results to the bit.

QEMU decodes and executes Thumb-2 and floating-point instructions by code of its own, so it checks the emulator's. The image
needs neither semihosting nor peripherals: its results are read from RAM through QEMU's monitor.

    cargo xtask counts                      # builds the image
    python3 lab/bench/qemu.py               # needs qemu-system-arm; without it nothing is compared
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

QEMU, MACHINE, LIMIT_S = "qemu-system-arm", "netduinoplus2", 120
ROOT = pathlib.Path(__file__).resolve().parents[2]
WORDS_A_ROW = 3


def symbols(elf):
    """Returns address and size of the statics, by parts of their names."""
    lines = subprocess.run(["nm", "-S", elf], check=True, capture_output=True, text=True).stdout.splitlines()
    rows = [line.split() for line in lines]
    found = {}
    for name in ("bench_image4DONE", "bench_image7RESULTS"):
        address, size = next((row[0], row[1]) for row in rows if len(row) == 4 and name in row[3])
        found[name[12:]] = (int(address, 16), int(size, 16))
    return found


def under_qemu(elf):
    """Returns the words of all results, and the seconds that QEMU took."""
    places = symbols(elf)
    (done, _), (results, size) = places["DONE"], places["RESULTS"]
    with tempfile.TemporaryDirectory() as folder:
        dump = pathlib.Path(folder, "words")

        def read(address, length):
            dump.unlink(missing_ok=True)
            qemu.stdin.write(f"pmemsave {address:#x} {length} \"{dump}\"\n".encode())
            qemu.stdin.flush()
            while not dump.exists() or dump.stat().st_size < length:
                if qemu.poll() is not None or time.monotonic() - begun > LIMIT_S:
                    sys.exit(f"{QEMU} gives no memory")
                time.sleep(0.02)
            data = dump.read_bytes()
            return [int.from_bytes(data[at : at + 4], "little") for at in range(0, length, 4)]

        options = ["-M", MACHINE, "-kernel", elf, "-display", "none", "-serial", "null", "-monitor", "stdio"]
        begun = time.monotonic()
        qemu = subprocess.Popen([QEMU, *options], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
        try:
            while read(done, 4)[0] < size // 4 // WORDS_A_ROW:
                if time.monotonic() - begun > LIMIT_S:
                    sys.exit(f"the image still runs after {LIMIT_S} s")
                time.sleep(0.5)
            return read(results, size), time.monotonic() - begun
        finally:
            qemu.kill()
            qemu.wait()


def on_emulator(elf):
    command = ["cargo", "run", "--quiet", "--release", "-p", "ridgetone-bench", "--", elf, "--words"]
    output = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return [int(word, 16) for word in output.split()]


def main():
    if shutil.which(QEMU) is None:
        sys.exit(f"no {QEMU} on this computer: nothing is compared")
    elf = str(ROOT / "target/firmware/bench/bench-image.elf")
    theirs, seconds = under_qemu(elf)
    ours = on_emulator(elf)
    wrong = [at for at, pair in enumerate(zip(ours, theirs, strict=True)) if pair[0] != pair[1]]
    version = subprocess.run([QEMU, "--version"], capture_output=True, text=True).stdout.split("\n")[0]
    print(f"{version}: {len(ours) - len(wrong)} of {len(ours)} words equal, {seconds:.0f} s under QEMU")
    for at in wrong[:10]:
        print(f"row {at // WORDS_A_ROW}, word {at % WORDS_A_ROW}: {ours[at]:08x} here, {theirs[at]:08x} under QEMU")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
