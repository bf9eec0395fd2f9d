"""Streams a finger's volts to the Lab Streaming Layer, until Ctrl-C: `pip install pylsl`, then

    python host/python/lsl.py NAME [PORT | emulated]

NAME is the stream's name, its type is "Tactile". A sample is a frame: 16 channels in volts, NaN where a reading is missing or not
valid, at the time of its first conversion.
"""

import math
import sys
import time
from collections.abc import Iterable

import pylsl
import ridgetone as rt


def outlet(name: str, rate_hz: float) -> pylsl.StreamOutlet:
    """A stream of 16 channels, whose readers may be a minute behind."""
    info = pylsl.StreamInfo(name, "Tactile", 16, rate_hz, "float32", f"ridgetone {name}")
    channels = info.desc().append_child("channels")
    for taxel in range(16):
        channel = channels.append_child("channel")
        channel.append_child_value("label", f"taxel {taxel}").append_child_value("unit", "V")
    return pylsl.StreamOutlet(info, max_buffered=60)


def stream(board: Iterable[rt.Event], name: str) -> None:
    """Gives the frames of a board to whoever reads, until the board is over."""
    stream = None
    for event in board:
        match event:
            case rt.Hello() if stream is None:
                stream = outlet(name, event.frame_rate_hz)
            case rt.Raw() if stream is not None:
                volts = [math.nan if value is None else value for value in event.volts]
                # UTC on this computer, in seconds of LSL's clock.
                stream.push_sample(volts, event.utc_s - time.time() + pylsl.local_clock())


if __name__ == "__main__":
    if not 2 <= len(sys.argv) <= 3:
        sys.exit(__doc__)
    with rt.live(*sys.argv[2:], raw=True) as board:
        stream(board, sys.argv[1])
