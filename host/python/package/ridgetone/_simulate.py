"""Frames of the simulated finger."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from . import _ridgetone
from ._objects import Object
from ._recording import Array, Path, Recording

_TAXELS = 16


@dataclass(frozen=True, slots=True, kw_only=True)
class Simulated(Recording):
    """Frames of the simulated finger, with their true values. `fit` and `replay` accept them directly.

    Attributes
    ----------
    values : ndarray, shape (n, 16)
        Readings of AIN0 to AIN15, volts.
    time_s : ndarray, shape (n,)
        When AIN0 was converted, seconds from the beginning of the scene. AIN`k` follows `k` conversions later.
    position_mm : ndarray, shape (n,)
        Position of the grating at `time_s`: distance of a ridge ahead of the contact's middle, millimetres.
    truth : Object
        `contact_s`, `slide_start_s`, `slide_end_s`, `release_s` and `end_s` in seconds from the beginning of the scene, and
        `frequency_hz`: speed over period, ignoring ripple; for a hand, at its greatest speed.
    channels : list of Object
        `offset_v`, `load_v` and `tone_v` of each channel: level without touch, its step under load, and amplitude of the
        fundamental, volts. The finger's creep and filter change them.
    noise_v : float
        Standard deviation of the scene's noise, volts; the converter adds its own.
    scan_hz : float
        Nominal frames per second.
    """

    time_s: Array
    position_mm: Array
    truth: Object
    channels: list[Object]
    noise_v: float
    scan_hz: float


def simulate(
    scene: Path | str | Mapping[str, Any] | None = None,
    *,
    seed: int | None = None,
    settings: Mapping[str, Any] | None = None,
    random_channels: bool = False,
    converter: bool = True,
) -> Simulated:
    """Slides a grating over the simulated finger, in front of the simulated ADS1258.

    Parameters
    ----------
    scene : path, str or mapping, optional
        Scene as a file, as text, or as a mapping of its keys, such as ``{"period_mm": 2.6, "finger": {"depth_mm": 1.0}}``.
        ``ridgetone emulate --print-scene`` and ``hal-mock/scenes/every_key.toml`` list the keys. Default: the paper's protocol
        at 30 mm/s over 3.6 mm.
    seed : int, optional
        Seed of the run, instead of the scene's.
    settings : mapping, optional
        Board settings, of which only `plan` and `vref_v` are used: ``{"plan": "hand"}``. The plan must convert 16 channels.
    random_channels : bool
        Draw gains, phases and offsets of the channels from the seed instead of modelling the finger: no creep, no filter, and
        three overtones of known amplitude.
    converter : bool
        False returns the voltages at the converter's inputs, without its noise, its steps and its clock's error.

    Returns
    -------
    Simulated

    Raises
    ------
    Error
        The scene cannot be read or is impossible; the message names the line and the key.
    UsageError
        The scene is neither a path nor text nor a mapping, or a value cannot be written as TOML.

    >>> found = simulate({"period_mm": 2.6, "slide_mm": 30})
    >>> found.values.shape[1], round(found.truth.frequency_hz, 3)
    (16, 11.538)
    """
    name, text = _text(scene)
    facts, channels, times, values, positions = _ridgetone.simulate(
        {
            "name": name,
            "text": text,
            "random_channels": random_channels,
            "seed": seed,
            "settings": json.dumps(settings or {}),
            "converter": converter,
        }
    )
    *truth, noise_v, scan_hz = facts
    names = ("contact_s", "slide_start_s", "slide_end_s", "release_s", "end_s", "frequency_hz")
    return Simulated(
        file=name,
        names=[f"ain{taxel}" for taxel in range(_TAXELS)],
        units=["V"] * _TAXELS,
        values=np.frombuffer(values, dtype=np.float64).reshape(-1, _TAXELS),
        time_s=np.frombuffer(times, dtype=np.float64),
        position_mm=np.frombuffer(positions, dtype=np.float64),
        truth=Object(zip(names, truth, strict=True)),
        channels=[Object(zip(("offset_v", "load_v", "tone_v"), channel, strict=True)) for channel in channels],
        noise_v=noise_v,
        scan_hz=scan_hz,
    )


def _text(scene: Path | str | Mapping[str, Any] | None) -> tuple[str, str]:
    """Returns a scene's name for messages, and its text."""
    if scene is None:
        return "scene", ""
    if isinstance(scene, Mapping):
        return "scene", _toml(scene)
    if isinstance(scene, str) and ("=" in scene or "\n" in scene):
        return "scene", scene
    if not isinstance(scene, (str, PathLike)):
        raise _ridgetone.UsageError(f"scene: {type(scene).__name__}, and a path, TOML or a mapping is needed")
    try:
        return fspath(scene), FilePath(scene).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise _ridgetone.Error(f"{fspath(scene)}: {getattr(error, 'strerror', None) or 'not UTF-8'}") from None


def _toml(scene: Mapping[str, Any]) -> str:
    """Writes a mapping, and the mappings in it, as TOML."""
    tables = {name: value for name, value in scene.items() if isinstance(value, Mapping)}
    lines = [f"{name} = {_value(name, value)}" for name, value in scene.items() if name not in tables]
    for table, keys in tables.items():
        lines += [f"[{table}]", *(f"{name} = {_value(name, value)}" for name, value in keys.items())]
    return "\n".join(lines)


def _value(name: str, value: object) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    raise _ridgetone.UsageError(f"scene: {name} is {value!r}, and a number, True or False is needed")
