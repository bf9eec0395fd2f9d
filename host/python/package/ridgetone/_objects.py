"""The objects of the command's JSON as Python's: their fields are items and attributes.

Numbers are those of the JSON to the last bit. What the board computes is f32: such a number is the shortest decimal that reads
back to the same f32. Fields that are not known are None; those of messages are in `_events`.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any, TypeVar

T = TypeVar("T", bound="Object")


class Object(dict[str, Any]):
    """A JSON object. `o.name` is `o["name"]`; `match` statements and `json.dumps` take it as it is."""

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


def load(kind: type[T], text: str) -> T:
    """An object of a kind from its JSON."""
    return kind(json.loads(text, object_hook=Object))
