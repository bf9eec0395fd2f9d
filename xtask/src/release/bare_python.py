"""Copies this interpreter, its library and the shared libraries of both into a folder, at the same
paths: `bare_python.py ROOT PACKAGES`. Shared libraries of the packages in PACKAGES come along."""

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

root, packages = map(Path, sys.argv[1:])


def copy(file: Path) -> None:
    to = root / file.relative_to("/")
    to.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy2(file, to)


library = Path(sysconfig.get_path("stdlib"))
left_out = shutil.ignore_patterns("site-packages", "dist-packages", "test", "__pycache__", "*.a")
shutil.copytree(library, root / library.relative_to("/"), ignore=left_out, dirs_exist_ok=True)

interpreter = Path(os.path.realpath(sys.executable))
copy(interpreter)
(root / "python").symlink_to(interpreter)

files = [interpreter, *library.glob("lib-dynload/*.so"), *packages.rglob("*.so*")]
linked = subprocess.run(["ldd", *files], capture_output=True, text=True, check=True).stdout
for word in {word for word in linked.split() if word.startswith("/") and not word.endswith(":")}:
    if not Path(word).is_relative_to(packages):
        copy(Path(word))
