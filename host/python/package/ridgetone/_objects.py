"""The objects of the command's JSON as Python's: their fields are items and attributes.

Numbers are those of the JSON to the last bit. What the board computes is f32: such a number is the shortest decimal that reads
back to the same f32. Fields that are not known are None.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any, Literal, TypeVar

T = TypeVar("T", bound="Object")
Status = Literal["good", "ambiguous", "unsteady", "doubtful", "no_tone", "too_short", "nothing"]


class Object(dict[str, Any]):
    """A JSON object. `o.name` is `o["name"]`; `match` statements and `json.dumps` take it as it is."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"{type(self).__name__} has no field {name}; there are: {', '.join(self)}") from None

    def __dir__(self) -> Iterable[str]:
        return [*super().__dir__(), *self]

    def __repr__(self) -> str:
        fields = ", ".join(f"{name}={value!r}" for name, value in self.items() if name != "type")
        return f"{type(self).__name__}({fields})"


class Fit(Object):
    """The result of `fit`. By place the fields are `frequency_per_mm`, `sigma_per_mm`, `period_mm`, `period_sigma_mm`."""

    file: str
    rate_hz: float
    rate_sigma_hz: float
    window_s: float
    rows: int
    rows_missing: int
    readings_missing: int
    abscissa: Literal["time", "place"]
    frequency_hz: float | None
    sigma_hz: float | None
    status: Status
    wander_percent: float | None
    harmonics: int
    channels: list[Object]


class Felt(Object):
    """The result of `feel`."""

    file: str
    rate_hz: float
    window_s: float
    windows: int
    reference_hz: float
    receptors: list[Object]
    scores: list[Object]
    channels: list[Object]


class Settings(Object):
    """Settings, by the names of the settings file."""

    window_s: float
    hop_s: float
    harmonics: int
    accuracy: float
    interferer_hz: float
    vref_v: float
    slide: Object
    array: Object
    feel: Object


_KINDS: dict[str, type[Event]] = {}


class Event(Object):
    """A message of a board. The book's chapter on telemetry lists the fields of each kind."""

    type: str
    sequence: int

    def __init_subclass__(cls) -> None:
        _KINDS[cls.__name__.lower()] = cls


class Hello(Event):
    """The greeting, with the settings in force."""

    protocol: int
    version: str
    frame_rate_hz: float
    settings: Settings


class Contact(Event):
    t_s: float
    taxel: int
    height_v: float


class Slide(Event):
    t_s: float
    state: Literal["start", "end"]
    start_s: float
    end_s: float | None


class Estimate(Event):
    """A frequency, over a window or a whole slide."""

    t_s: float
    window_s: float
    span: Literal["window", "slide"]
    abscissa: Literal["time", "place"]
    status: Status
    frequency_hz: float | None
    sigma_hz: float | None
    harmonics: int
    faults: list[str]
    spatial_period_mm: float | None
    speed_mm_s: float | None
    channels: list[Object]


class Feel(Event):
    """What a finger feels: intensities of receptors, and scores from 1 to 7; what is absent says why in `absent`."""

    t_s: float
    window_s: float
    rate_hz: float
    taxels: int
    faults: list[str]
    m: float | None
    m_sigma: float | None
    receptors: list[Object]
    scores: list[Object]
    spectrum: list[Object]


class Texture(Event):
    """What is under the finger: once a touch, and again when it has changed by more than three standard deviations of the
    difference.
    """

    t_s: float
    plan: str | dict[str, Any]
    period_mm: float
    period_sigma_mm: float
    power_v2: float
    power_sigma_v2: float
    overtones: list[Object]
    level_v: float | None


class Release(Event):
    t_s: float


class Image(Event):
    t_s: float
    hold: Literal["before_slide", "after_slide"]
    taxels: list[Object]


class Fault(Event):
    t_s: float
    kind: str
    state: Literal["start", "end"]


class Reply(Event):
    number: int
    outcome: str


class Raw(Event):
    """A frame as it was read: codes of all taxels, volts where they can be trusted, and bits of those that are there."""

    t_s: float
    number: int
    present: int
    good: int
    codes: list[int]
    volts: list[float | None]


class Health(Event):
    t_s: float
    frames: int
    frame_rate_hz: float
    load: float


def event(line: str) -> Event:
    """The event of one line of JSON."""
    fields = json.loads(line, object_hook=Object)
    return _KINDS.get(fields.get("type", ""), Event)(fields)


def load(kind: type[T], text: str) -> T:
    """An object of a kind from its JSON."""
    return kind(json.loads(text, object_hook=Object))
