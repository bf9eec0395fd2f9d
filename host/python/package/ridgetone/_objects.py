"""The JSON objects of the command in Python, with fields as items and attributes.

Numbers are those of the JSON to the last bit. The board computes in f32; its numbers are the shortest decimals that read back
to the same f32. Unknown fields are None; `_events` describes the fields of messages.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any, Literal, TypeVar

from . import _show

T = TypeVar("T", bound="Object")


class Object(dict[str, Any]):
    """A JSON object. `o.name` is `o["name"]`; `match` statements and `json.dumps` work with it."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            if any(name in getattr(kind, "__annotations__", {}) for kind in type(self).__mro__):
                return None
            raise AttributeError(f"{type(self).__name__} has no field {name}; there are: {', '.join(self)}") from None

    def __dir__(self) -> Iterable[str]:
        return [*super().__dir__(), *self]

    def __repr__(self) -> str:
        fields = ", ".join(f"{name}={value!r}" for name, value in self.items() if name != "type")
        return f"{type(self).__name__}({fields})"

    def __str__(self) -> str:
        return _show.text(type(self).__name__, self)

    def _repr_html_(self) -> str:
        return _show.html(type(self).__name__, self)

    def __reduce__(self) -> tuple[type[Object], tuple[dict[str, Any]]]:
        # Copies only the fields, not the samples and settings of a fit.
        return type(self), (dict(self),)


# `cargo xtask settings` writes what follows.
class SlideSettings(Object):
    """Settings `slide`."""

    rule: Literal["found", "protocol", "always"]
    """Source of slides: found in the signal, timed by the protocol of the stimulus, or always (every frame is part of a slide, without contact and hold)."""
    delay_s: float
    """With the protocol: hold time between the contact spike and the slide. [s]"""
    speed_mm_s: float
    """Speed of the stimulus, which also gives the spatial period. Used with the rule `protocol` and, unless 0, with `always`. [mm/s]"""
    length_mm: float
    """With the protocol: length of the slide to use (paper: 55 of 60). [mm]"""


class ArraySettings(Object):
    """Settings `array`."""

    pitch_mm: float
    """Effective spacing of the two sensor columns along the motion, from phase. [mm]"""
    edge_phase_rad: float
    """Phase by which the contact's ends reduce the lag between the columns: the lag is 2 pi pitch / period less this. [rad]"""
    edge_phase_sigma_rad: float
    """Standard deviation of true lags about those of pitch and edge phase; 0.3 or more means that the array is not calibrated. [rad]"""
    period_min_mm: float
    """Shortest possible spatial period. [mm]"""
    period_max_mm: float
    """Longest possible spatial period; between one pitch and two the answer is unique. [mm]"""
    may_go_forward: bool
    """The grating may move along +x."""
    may_go_backward: bool
    """The grating may move against +x; if only one direction is possible, every period above one pitch is unique."""
    front: int
    """Taxels of the front column, further along +x: bit k is taxel k. [mask]"""
    alike: list[int]
    """Four masks of taxels that respond alike, the same piezoresistor of every unit; a taxel in none of them is not used. [masks]"""


class SceneSettings(Object):
    """Settings `scene`."""

    overtones: bool
    """The tone may have overtones, up to `harmonics`; otherwise it is a single sine."""
    curved_baseline: bool
    """Levels may bend over a window, as under a skin that creeps; otherwise they have only a slope."""
    coloured_noise: bool
    """Noise may have any spectrum; otherwise it is white."""
    shared_noise: bool
    """Noise may be correlated between channels."""
    moving_speed: bool
    """The speed changes with a probability of one half; otherwise it is most likely steady."""
    impulses: bool
    """Single values may be outliers."""


class Settings(Object):
    """Settings, by the names of the settings file."""

    plan: str | dict[str, Any]
    """Inputs that the chip converts, and how fast; a new plan brings its default window and stride."""
    window_s: float
    """Length of a window. [s]"""
    stride_s: float
    """Time from the start of one window to the start of the next; below 0.05 s each window is reported as a short `track`. [s]"""
    harmonics: int
    """Maximum number of harmonics to fit, the fundamental included."""
    accuracy: float
    """Required standard deviation as a fraction of the frequency: windows grow by a stride until they meet it; 0 for windows of one length. [fraction]"""
    interferer_hz: float
    """Frequency of a known interferer in all channels, such as mains hum; 0 for none. [Hz]"""
    vref_v: float
    """Reference voltage of the ADC. [V]"""
    slide: SlideSettings
    array: ArraySettings
    scene: SceneSettings
# End of what `cargo xtask settings` writes.


def load(kind: type[T], text: str) -> T:
    """Parses JSON into an object of the class `kind`."""
    return kind(json.loads(text, object_hook=Object))
