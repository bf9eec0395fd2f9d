"""Result of `replay`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from ._events import Contact, Estimate, Event, Release, Slide

E = TypeVar("E", bound=Event)


class Replayed(list[Event]):
    """The events of a replay in order, with properties that select one kind.

    Times of events are seconds from the first row of the samples, or from the first conversion of a scene.
    """

    def of(self, kind: type[E]) -> list[E]:
        """Events of one class, such as `ridgetone.Texture`."""
        return [event for event in self if isinstance(event, kind)]

    @property
    def contacts(self) -> list[Contact]:
        """Contacts of the finger."""
        return self.of(Contact)

    @property
    def slides(self) -> list[Slide]:
        """Completed slides, with `start_s` and `end_s`. The whole list also has an event at the start of each."""
        return [slide for slide in self.of(Slide) if slide.end_s is not None]

    @property
    def estimates(self) -> list[Estimate]:
        """Estimates of the frequency; `span` distinguishes windows from whole slides."""
        return self.of(Estimate)

    @property
    def releases(self) -> list[Release]:
        """Ends of a touch."""
        return self.of(Release)

    def columns(self, kind: type[E], where: Callable[[E], bool] | None = None) -> dict[str, npt.NDArray[np.generic]]:
        """Fields of the events of one class as arrays, an element for each event.

        Parameters
        ----------
        kind : type
            Class of the events, such as `ridgetone.Estimate`.
        where : callable, optional
            Takes an event, and returns False to leave it out.

        Returns
        -------
        dict of str to ndarray
            Numbers are float64 with NaN where a field is null, flags are bool, texts are str. Fields that are lists or objects,
            such as `channels`, are omitted.

        >>> import ridgetone as rt
        >>> found = rt.replay().columns(rt.Estimate, lambda one: one.span == "window")
        >>> bool(abs(found["frequency_hz"].mean() - 8.333) < 0.01)
        True
        """
        events = [event for event in self.of(kind) if where is None or where(event)]
        names = dict.fromkeys(name for event in events for name in event)
        columns: dict[str, npt.NDArray[np.generic]] = {}
        for name in names:
            values = [event.get(name) for event in events]
            there = [value for value in values if value is not None]
            if any(isinstance(value, (list, dict)) for value in there):
                continue
            if there and all(isinstance(value, str) for value in there):
                columns[name] = np.array(["" if value is None else value for value in values])
            elif len(there) == len(values) and all(isinstance(value, bool) for value in there):
                columns[name] = np.array(values, dtype=bool)
            else:
                columns[name] = np.array([np.nan if value is None else value for value in values], dtype=np.float64)
        return columns
