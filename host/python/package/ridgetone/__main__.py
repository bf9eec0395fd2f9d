"""`python -m ridgetone feel`: the firing of mechanoreceptors over a recording. For all else use the command `ridgetone`."""

from __future__ import annotations

import argparse
import json
import sys

from ._feel import feel, volts_per_um
from ._ridgetone import Error


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m ridgetone", description=__doc__)
    words = parser.add_subparsers(dest="command", required=True).add_parser(
        "feel", help="estimate firing intensities of FA I, FA II, SA I and SA II, and the scores soft and rough"
    )
    words.add_argument("file", metavar="FILE", help="table or recording")
    words.add_argument("--rate", type=float, metavar="HZ", help="rows a second [default: by the stamps]")
    words.add_argument("--from", dest="from_s", type=float, metavar="S", help="first time to use, seconds")
    words.add_argument("--to", dest="to_s", type=float, metavar="S", help="last time to use, seconds")
    words.add_argument("--columns", type=lambda text: text.split(","), metavar="NAMES", help="columns of vibration [default: all]")
    words.add_argument("--time-column", metavar="NAME[:UNIT]", help="column of the time, as for `ridgetone fit`")
    words.add_argument("--window", type=float, default=3.0, metavar="S", help="longest window, seconds [default: 3]")
    words.add_argument("--m", type=float, metavar="RATIO", help="tangential over normal force")
    words.add_argument("--m-sigma", type=float, default=0.0, metavar="SIGMA", help="standard deviation of --m")
    words.add_argument("--sigma-fraction", type=float, default=0.0, metavar="F", help="standard deviation of --volts-per-um over it")
    known = words.add_mutually_exclusive_group(required=True)
    known.add_argument("--volts-per-um", type=float, metavar="V", help="amplitude for one micrometre from peak to peak")
    known.add_argument("--reference", metavar="FILE", help="recording of a surface of known roughness, whose Ra, RSm and speed follow")
    words.add_argument("--ra-um", type=float, metavar="UM", help="roughness Ra of the reference")
    words.add_argument("--rsm-mm", type=float, metavar="MM", help="mean element length RSm of the reference")
    words.add_argument("--speed-mm-s", type=float, metavar="MM_S", help="speed of the finger over the reference")
    words.add_argument("--json", action="store_true", help="print one JSON object")
    given = parser.parse_args()
    surface = (given.ra_um, given.rsm_mm, given.speed_mm_s)
    if given.reference is not None and None in surface:
        words.error("--reference needs --ra-um, --rsm-mm and --speed-mm-s")
    try:
        per_um, sigma_fraction = given.volts_per_um, given.sigma_fraction
        if given.reference is not None:
            ra_um, rsm_mm, speed_mm_s = surface
            found = volts_per_um(
                given.reference,
                given.rate,
                ra_um=ra_um,
                rsm_mm=rsm_mm,
                speed_mm_s=speed_mm_s,
                columns=given.columns,
                time_column=given.time_column,
            )
            per_um, sigma_fraction = found.volts_per_um, found.sigma_fraction
        felt = feel(
            given.file,
            given.rate,
            volts_per_um=per_um,
            sigma_fraction=sigma_fraction,
            m=None if given.m is None else (given.m, given.m_sigma),
            window_s=given.window,
            from_s=given.from_s,
            to_s=given.to_s,
            columns=given.columns,
            time_column=given.time_column,
        )
    except Error as error:
        sys.exit(f"ridgetone: {error}")
    print(json.dumps(felt) if given.json else felt)


if __name__ == "__main__":
    main()
