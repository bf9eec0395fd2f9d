"""The messages of a board, and the result of `fit`. `cargo xtask events` writes this file: do not edit it."""

from __future__ import annotations

import json
from typing import Literal

from ._objects import Object, Settings

__all__ = [
    "Connection",
    "Contact",
    "Converter",
    "Estimate",
    "Event",
    "Fault",
    "Fit",
    "Health",
    "Hello",
    "Image",
    "Lost",
    "Missed",
    "Moving",
    "Raw",
    "Release",
    "Reply",
    "Slide",
    "Texture",
    "Track",
]


class Event(Object):
    """A message of a board."""

    type: str
    """Kind of the message."""
    sequence: int
    """Number of the message since the board's start, modulo 65536."""
    received_utc_s: float | None
    """When this computer received the message, UTC since 1970 [s]."""
    utc_s: float | None
    """`t_s` in UTC, since 1970; null before the relation of the clocks is known [s]."""
    utc_sigma_s: float | None
    """Standard deviation of `utc_s`; null in the first quarter of a second, when it is not yet known [s]."""
    clock_offset_s: float | None
    """With `health`: UTC less board time at board time 0 [s]."""
    clock_skew_ppm: float | None
    """With `health`: by how much the board's clock is slow [ppm]."""
    clock_skew_sigma_ppm: float | None
    """With `health`: standard deviation of the skew [ppm]."""


class Hello(Event):
    """The greeting: after start-up, every ten seconds, and on request."""

    t_s: float
    """Device time; 0 until the first conversion. A time below the previous one means that the board has
    restarted [s]."""
    protocol: int
    """Version of the wire contract."""
    version: str
    """Version of the firmware."""
    frame_rate_hz: float
    """Nominal frames per second [Hz]."""
    settings: Settings
    """Settings in force, by the names of the settings file."""
    settings_source: Literal["default", "stored", "sent", "damaged", "stored_before", "migrated"]
    """Where the settings come from."""
    reset_cause: Literal["unknown", "power", "pin", "software", "watchdog"]
    """Cause of the processor's latest reset."""
    oscillator: Literal["unknown", "external", "internal"]
    """Source of the processor's clock; `internal` if the external oscillator did not start."""
    brown_out: Literal["unknown", "off", "level1", "level2", "level3"]
    """Supply level that resets the board."""
    record: Object | None
    """How the previous run ended, if it crashed."""
    positions_mm: list[list[float]] | None
    """Centre of each taxel's unit relative to the array's centre, along and across the sliding direction; only
    in streams [mm]."""


class Contact(Event):
    """A contact: the spike is over."""

    t_s: float
    """Device time of the spike [s]."""
    taxel: int
    """Taxel with the clearest spike, 0 to 15."""
    height_v: float
    """Height of the spike over the level without touch, signed [V]."""
    onset_s: float
    """When the load began to rise; for a load that creeps in, long before the spike [s]."""
    reported_after_s: float
    """Time from `t_s` until the event left the board's detector [s]."""


class Moving(Event):
    """The first sign of a motion along the surface in a hold. A `slide` follows if the motion lasts; a knock has
    none."""

    t_s: float
    """Device time of the first frame that shows the motion [s]."""
    reported_after_s: float
    """Time from `t_s` until the event left the board's detector [s]."""


class Slide(Event):
    """Start or end of the sliding phase. If the finger was already touching something at start-up, no `contact`
    precedes it."""

    t_s: float
    """Device time of the beginning or, once it is over, of the end [s]."""
    start_s: float
    """Device time of the beginning [s]."""
    end_s: float | None
    """Device time of the end; null while it lasts [s]."""
    state: Literal["start", "end"]
    """Beginning or end of the slide."""
    reported_after_s: float
    """Time from `t_s` until the event left the board's detector [s]."""


class Estimate(Event):
    """One fit: every stride of a slide, and for the whole of it."""

    t_s: float
    """Device time of the window's end [s]."""
    window_s: float
    """Length of the window [s]."""
    span: Literal["window", "slide"]
    """What the window covers."""
    frequency_hz: float | None
    """Common frequency, mean over the window; null without a tone, like all of its details [Hz]."""
    sigma_hz: float | None
    """Standard deviation of the frequency [Hz]."""
    wander_percent: float | None
    """RMS deviation of the frequency from its mean over the window [%]."""
    wander_sigma_percent: float | None
    """Standard deviation of the wander [%]."""
    chirp_hz_per_s: float | None
    """Change of the frequency with time [Hz/s]."""
    chirp_sigma_hz_per_s: float | None
    """Standard deviation of the chirp [Hz/s]."""
    other_tone_hz: float | None
    """Frequency of a second tone that is significant next to the first [Hz]."""
    other_tone_fraction: float | None
    """Power of the second tone over that of the first."""
    interferer_hz: float | None
    """Frequency of the interferer as fitted; null if none is set, or if the window is too short to fit it [Hz]."""
    status: Literal["good", "no_tone", "too_short", "nothing", "ambiguous", "doubtful", "unsteady"]
    """How far the estimate can be trusted."""
    harmonics: int
    """Harmonics in the fit, the fundamental included."""
    frames_missing: int
    """Frames that the window lacks."""
    faults: list[Literal["lost", "repeated", "bus", "bus_dead", "channel", "silent", "storm", "registers", "no_answer", "supply", "reference", "clock", "overload"]]
    """Kinds of faults in the window that may have changed the frequency."""
    travel: Literal["nothing", "unique", "ambiguous", "out_of_range", "given", "contradicted", "uncalibrated"]
    """Whether and how period, speed and direction are known."""
    direction: Literal["unknown", "forward", "backward"] | None
    """Direction in which the grating moves; null if it is not known."""
    spatial_period_mm: float | None
    """Spatial period, from the lags between the units or from the speed in the settings. With `uncalibrated`
    only its uncertainty is right [mm]."""
    spatial_period_sigma_mm: float | None
    """Standard deviation of the spatial period [mm]."""
    speed_mm_s: float | None
    """Speed over the surface, not negative [mm/s]."""
    speed_sigma_mm_s: float | None
    """Standard deviation of the speed; 0 if the settings have it [mm/s]."""
    channels: list[Object]
    """The valid channels."""


class Track(Event):
    """Short form of an estimate, for every window if the stride is below 0.05 s. Whole estimates then come at
    most twenty times a second."""

    t_s: float
    """Device time of the window's end [s]."""
    frequency_hz: float | None
    """Common frequency, mean over the window; null without a tone [Hz]."""
    sigma_hz: float | None
    """Standard deviation of the frequency [Hz]."""
    status: Literal["good", "no_tone", "too_short", "nothing", "ambiguous", "doubtful", "unsteady"]
    """How far the fit can be trusted."""


class Texture(Event):
    """The surface under the finger: once a touch, on request with `hello`, and after a change of more than three
    standard deviations."""

    t_s: float
    """Device time of the end of the estimate's window [s]."""
    plan: str | None
    """Name of the window's scan plan; null if it has none. `hello` has its fields."""
    period_mm: float
    """Spatial period [mm]."""
    period_sigma_mm: float
    """Standard deviation of the period [mm]."""
    power_v2: float
    """Half of the squared amplitude of the fundamental, mean of the valid channels [V^2]."""
    power_sigma_v2: float
    """Standard deviation of the power, from white noise [V^2]."""
    overtones: list[Object]
    """Second, third and fourth harmonic, common to the valid channels."""
    level_v: float | None
    """How hard the finger presses: mean level of the taxels in the hold before the slide, over that before the
    touch, signed; null without such a hold [V]."""


class Release(Event):
    """The finger has left the surface."""

    t_s: float
    """Device time [s]."""
    reported_after_s: float
    """Time from `t_s` until the event left the board's detector [s]."""


class Image(Event):
    """Pressure map of a hold before, between or after slides, if nothing moved in it for 0.1 s."""

    t_s: float
    """Device time of the end of the mean [s]."""
    start_s: float
    """Device time of the first frame of the mean [s]."""
    end_s: float
    """Device time of the end of its last frame [s]."""
    frames: int
    """Frames in the mean."""
    hold: Literal["before_slide", "after_slide"]
    """Which hold it is."""
    taxels: list[Object]
    """The live taxels."""


class Fault(Event):
    """A fault begins, or has ended."""

    t_s: float
    """Device time of the beginning or, once it is over, of the end [s]."""
    kind: Literal["lost", "repeated", "bus", "bus_dead", "channel", "silent", "storm", "registers", "no_answer", "supply", "reference", "clock", "overload"]
    """Which fault."""
    from_s: float
    """Device time at which it was detected [s]."""
    until_s: float | None
    """Device time at which it was last seen; null while it lasts [s]."""
    count: int
    """Number of times that this kind was seen since start-up."""
    state: Literal["start", "end"]
    """Beginning or end of the fault."""


class Reply(Event):
    """The answer to a command: carried out, or refused and why."""

    number: int
    """Number of the request."""
    outcome: str
    """Outcome of the request: `done`, `done_erased`, or why it was refused."""
    frame_rate_hz: float | None
    """Frames per second at the converter's nominal clock [Hz]."""
    nyquist_hz: float | None
    """Half of the frame rate (hertz): tones above it alias [Hz]."""
    window_max_s: float | None
    """The longest window, seconds [s]."""


class Raw(Event):
    """A frame as it was read, on request."""

    t_s: float
    """Device time at which taxel 0 was converted; taxel k follows 0.1975 ms x k later with the plan `paper` [s]."""
    number: int
    """Number of the frame since start-up, lost ones included."""
    present: int
    """Bit k: taxel k was converted and read."""
    good: int
    """Bit k: the result of taxel k can be trusted. A taxel that is present and good is valid."""
    codes: list[int]
    """Codes of the ADC by taxel."""
    volts: list[float | None] | None
    """Voltages by taxel; null where the code is not valid. Absent without the reference, which `hello` has [V]."""


class Health(Event):
    """Counters and readings, once a second."""

    t_s: float
    """Device time [s]."""
    frames: int
    """Frames since start-up; wraps after 206 days."""
    conversions_lost: int
    """Conversions lost: overruns of the queue and gaps in the scan."""
    conversions_doubtful: int
    """Conversions that cannot be trusted."""
    overruns: int
    """Windows that were not fitted because the fit was busy."""
    messages_dropped: int
    """Messages that were dropped because the line was slow."""
    chip_restarts: int
    """Number of times that the ADC was set up again, or that setting it up failed."""
    faults: Object
    """Number of times that each kind of fault was seen."""
    requests_damaged: int
    """Requests that arrived damaged."""
    bytes_overrun: int
    """Bytes of requests that the board read too late."""
    stack_used_bytes: int
    """Deepest stack since start-up; 0 if it is not measured, as on a PC [byte]."""
    stack_bytes: int
    """Size of the stack; 0 if it is not measured [byte]."""
    frame_rate_hz: float
    """True frame rate by the board's clock; 0 until measured [Hz]."""
    load: float
    """Fraction of time that the processor was busy, 0 to 1; 0 if it is not measured."""
    supply_v: float
    """The ADC's reading of its supply [V]."""
    reference_v: float
    """The ADC's reading of its reference [V]."""
    temperature_c: float
    """The ADC's reading of its temperature [degC]."""
    offset_v: float
    """The ADC's reading of its offset [V]."""
    gain: float
    """The ADC's reading of its gain, ideally 1."""
    frames_thinned: int
    """Raw frames that were not sent because the line was full."""


class Converter(Event):
    """The converter behind the inputs: after each greeting, and when it changes."""

    t_s: float
    """Device time [s]."""
    name: str
    """Name of the converter."""
    answers: bool
    """True if the converter holds the registers that were written; otherwise the board keeps trying."""
    registers: list[int]
    """Registers as read back at the latest set-up, padded with zeros; of an ADS1258 CONFIG0 to ID."""


class Connection(Event):
    """A source of messages comes or goes."""

    state: Literal["connected", "disconnected", "failed", "over"]
    """What happened to the source."""
    source: str | None
    """Port, recording or address."""
    why: str | None
    """The system's message."""


class Lost(Event):
    """Messages were lost, at the line or at a receiver."""

    at: str
    """`line`, or the receiver whose messages were lost."""
    packets: int | None
    """At the line: messages so far."""
    damaged: int | None
    """At the line: damaged messages so far."""
    frames: int | None
    """At a receiver: frames so far."""
    events: int | None
    """At a receiver: other messages so far."""
    frames_unconfirmed: int | None
    """At a receiver: frames handed to a connection that then broke."""


class Missed(Event):
    """A reader fell behind and missed messages."""

    count: int
    """Number of messages."""


class Fit(Object):
    """One fit, of a file or of an array."""

    type: str
    """Kind of the object."""
    file: str
    """Name of the file."""
    rate_hz: float
    """Number of rows per second [Hz]."""
    rate_sigma_hz: float
    """Standard deviation of the rate by the time stamps [Hz]."""
    part: Literal["slide", "whole", "given"]
    """Which part of the recording was fitted."""
    from_s: float
    """Time of the part's first row [s]."""
    to_s: float
    """Time of the part's last row [s]."""
    window_s: float
    """Length of the part that was fitted [s]."""
    rows: int
    """Rows that were fitted."""
    rows_missing: int
    """Rows missing between them, by the time stamps."""
    readings_missing: int
    """Blank cells in the rows."""
    domain: Literal["time", "position"]
    """Domain in which cycles are counted: time or position."""
    frequency_hz: float | None
    """Common frequency in time: its mean over the window [Hz]."""
    sigma_hz: float | None
    """Standard deviation of the frequency [Hz]."""
    frequency_per_mm: float | None
    """Common spatial frequency: its mean over the window [1/mm]."""
    sigma_per_mm: float | None
    """Standard deviation of the spatial frequency [1/mm]."""
    period_mm: float | None
    """Spatial period, the inverse of the spatial frequency [mm]."""
    period_sigma_mm: float | None
    """Standard deviation of the period [mm]."""
    wander_percent: float | None
    """RMS deviation of the frequency from its mean over the window [%]."""
    wander_sigma_percent: float | None
    """Standard deviation of the wander [%]."""
    chirp_hz_per_s: float | None
    """Change of the frequency with time [Hz/s]."""
    chirp_sigma_hz_per_s: float | None
    """Standard deviation of the chirp [Hz/s]."""
    other_tone_hz: float | None
    """Frequency of a second tone that is significant in the presence of the first [Hz]."""
    chirp_per_mm2: float | None
    """Change of the spatial frequency with position [1/mm^2]."""
    chirp_sigma_per_mm2: float | None
    """Standard deviation of the chirp by position [1/mm^2]."""
    other_tone_per_mm: float | None
    """Spatial frequency of a second tone that is significant in the presence of the first [1/mm]."""
    other_tone_fraction: float | None
    """Power of the second tone over that of the first."""
    interferer_hz: float | None
    """Frequency of the interferer as fitted; null if none is set, or if the window is too short to fit it [Hz]."""
    status: Literal["good", "no_tone", "too_short", "nothing", "ambiguous", "doubtful", "unsteady"]
    """Confidence in the fit."""
    harmonics: int
    """Harmonics in the fit, the fundamental included."""
    groups: int
    """Groups of at most 16 channels that were fitted by themselves; 1 for up to 16 channels."""
    channels: list[Object]
    """The columns."""


_KINDS: dict[str, type[Event]] = {
    "hello": Hello,
    "contact": Contact,
    "moving": Moving,
    "slide": Slide,
    "estimate": Estimate,
    "track": Track,
    "texture": Texture,
    "release": Release,
    "image": Image,
    "fault": Fault,
    "reply": Reply,
    "raw": Raw,
    "health": Health,
    "converter": Converter,
    "connection": Connection,
    "lost": Lost,
    "missed": Missed,
}


def event(line: str) -> Event:
    """The event of one line of JSON."""
    fields = json.loads(line, object_hook=Object)
    return _KINDS.get(fields.get("type", ""), Event)(fields)
