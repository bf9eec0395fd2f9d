"""A board, live."""

from __future__ import annotations

import asyncio
import json
import urllib.error
import urllib.request
import warnings
from collections.abc import AsyncIterator, Iterator
from types import TracebackType
from typing import Any, Protocol

from . import _ridgetone
from ._events import Event, event
from ._objects import Settings, load
from ._recording import Path

# Longest wait between two checks for Ctrl-C, seconds.
_LOOK_S = 0.1


class _Source(Protocol):
    def next(self, max_s: float) -> tuple[str, str] | None: ...
    def close(self) -> None: ...


class _Page:
    """Packets from a running `ridgetone view`."""

    def __init__(self, url: str) -> None:
        try:
            self._lines = urllib.request.urlopen(f"{url.rstrip('/')}/packets", timeout=10)
        except (urllib.error.URLError, OSError) as error:
            raise _ridgetone.Error(f"{url}: {error}; is `ridgetone view` running there?") from error

    def next(self, max_s: float) -> tuple[str, str] | None:
        try:
            line = self._lines.readline()
        except (TimeoutError, OSError, ValueError):
            line = b""
        return ("event", line.decode()) if line else ("over", "")

    def close(self) -> None:
        self._lines.close()


class Live(Iterator[Event], AsyncIterator[Event]):
    """Iterates over the events of a board as they arrive, with `for` or `async for`. Ends when its scene is over.

    If the board is unplugged, warns and waits for it. Close the object, or use it in a `with` statement.
    """

    def __init__(self, source: _Source) -> None:
        self._source = source

    def _event(self) -> Event | None:
        """Returns the next event; None if none arrives soon."""
        found = self._source.next(_LOOK_S)
        if found is None:
            return None
        kind, text = found
        if kind == "over":
            raise StopIteration
        if kind == "warning":
            warnings.warn(text, stacklevel=4)
            return None
        return event(text)

    def __iter__(self) -> Live:
        return self

    def __next__(self) -> Event:
        while True:
            if (found := self._event()) is not None:
                return found

    def __aiter__(self) -> Live:
        return self

    async def __anext__(self) -> Event:
        def look() -> Event | None | type[StopIteration]:
            try:
                return self._event()
            except StopIteration:
                return StopIteration

        while True:
            found = await asyncio.to_thread(look)
            if found is StopIteration:
                raise StopAsyncIteration
            if isinstance(found, Event):
                return found

    def _board(self) -> _ridgetone.Board:
        if isinstance(self._source, _ridgetone.Board):
            return self._source
        raise _ridgetone.UsageError("a page takes no requests: open the board itself")

    @property
    def settings(self) -> Settings:
        """The settings in force."""
        return load(Settings, self._board().settings())

    def set(self, *, keep: bool = False, **changes: Any) -> Settings:
        """Applies settings by their names in the settings file, from the next window on; `keep` also stores them."""
        self._board().change(json.dumps(changes), keep)
        return self.settings

    def command(self, name: str) -> None:
        """Sends a command: `start`, `stop`, `restart`, or `forget`, which erases the stored settings."""
        self._board().command(name)

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of packets received, missing by their sequence numbers, and damaged."""
        return dict(zip(("received", "missing", "damaged"), self._board().counts(), strict=True))

    def close(self) -> None:
        self._source.close()

    def __enter__(self) -> Live:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()


def live(
    source: str | None = None,
    *,
    usb_serial: str | None = None,
    raw: bool = False,
    settings: dict[str, Any] | None = None,
    record: Path | None = None,
    scene: Path | None = None,
    once: bool = False,
    pace: float = 1.0,
    elf: Path | None = None,
) -> Live:
    """Opens a board: the name of a serial port, "emulated", or the address of a `ridgetone view` such as
    "http://127.0.0.1:8321". Default: the only board on this computer.

    `raw` requests every frame; `settings` are applied first; `record` writes what arrives to a new recording. For the emulated
    board: `scene` is a scene file; `once` ends after one touch; `pace` is the speed, 0 for as fast as possible; `elf` is the
    firmware: a file or, in a wheel of a release, the name of a board whose image it contains: "feather-f405" (the default) or
    "nucleo-f446re". Without either, it is the image that `cargo xtask firmware` builds in the repository,
    `target/firmware/feather-f405/ridgetone-firmware.elf`.
    """
    is_emulated = source == "emulated"
    if not is_emulated and (scene is not None or once or pace != 1.0 or elf is not None):
        raise _ridgetone.UsageError("scene, once, pace and elf are for the emulated board")
    if source is not None and source.startswith(("http://", "https://")):
        if usb_serial or raw or settings is not None or record is not None:
            raise _ridgetone.UsageError("usb_serial, raw, settings and record are for a board, not for a page")
        return Live(_Page(source))
    port = None if is_emulated else source
    given = None if settings is None else json.dumps(settings)
    return Live(_ridgetone.Board(port, usb_serial, is_emulated, scene, once, pace, elf, raw, given, record))
