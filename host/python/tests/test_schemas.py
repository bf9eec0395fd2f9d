"""An independent validator accepts what the command prints, serves and exports against its schemas."""

import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT, SCENES, Run, command
from jsonschema import Draft202012Validator

SCHEMAS = json.loads((ROOT / "host/src/events/schema.json").read_text())

# The fields that describe a refused setting are not in the schema.
OPEN = {"reply"}


def check(lines: list[dict[str, Any]]) -> set[str]:
    """Asserts that every line fits the schema of its type and has no other fields. Returns the types."""
    assert lines
    for line in lines:
        schema = SCHEMAS[line["type"]]
        Draft202012Validator(schema).validate(line)
        assert line["type"] in OPEN or set(line) <= set(schema["properties"]), line
    return {line["type"] for line in lines}


def records(content: bytes) -> Iterator[tuple[int, bytes]]:
    """Yields the records of an MCAP file, including those in its chunks (mcap.dev/spec)."""
    at = 0
    while at + 9 <= len(content):
        code, length = struct.unpack_from("<BQ", content, at)
        record = content[at + 9 : at + 9 + length]
        at += 9 + length
        if code == 6:
            _, rest = text(record, 28)
            yield from records(record[rest + 8 :])
        else:
            yield code, record


def text(record: bytes, at: int) -> tuple[str, int]:
    """Returns a string, and where it ends."""
    (length,) = struct.unpack_from("<I", record, at)
    return record[at + 4 : at + 4 + length].decode(), at + 4 + length


def mcap(path: Path) -> tuple[dict[str, dict[str, Any]], list[tuple[str, dict[str, Any]]]]:
    """Returns the schema of each topic of an MCAP file, and its messages with their topics."""
    schemas, topics, by_topic, messages = {}, {}, {}, []
    for code, record in records(path.read_bytes()[8:-8]):
        if code == 3:
            _, at = text(record, 2)
            encoding, at = text(record, at)
            assert encoding == "jsonschema"
            schemas[struct.unpack_from("<H", record)[0]] = json.loads(text(record, at)[0])
        elif code == 4:
            number, schema = struct.unpack_from("<HH", record)
            topics[number] = text(record, 4)[0]
            by_topic[topics[number]] = schemas[schema]
        elif code == 5:
            messages.append((topics[struct.unpack_from("<H", record)[0]], json.loads(record[22:])))
    return by_topic, messages


def one_type(schema: dict[str, Any]) -> Iterator[Any]:
    """Yields the types in a schema; viewers need a single type for each field."""
    yield schema["type"]
    yield from (kind for field in schema.get("properties", {}).values() for kind in one_type(field))
    if "items" in schema:
        yield from one_type(schema["items"])


def test_the_schemas_are_schemas() -> None:
    for schema in SCHEMAS.values():
        Draft202012Validator.check_schema(schema)


def test_a_wrong_message_does_not_fit() -> None:
    release = {"type": "release", "sequence": 1, "t_s": 1.0, "reported_after_s": 0.1}
    assert check([release]) == {"release"}
    for wrong in [{**release, "t_s": None}, {**release, "sequence": -1}, {"type": "release", "sequence": 1}, {**release, "x": 1}]:
        with pytest.raises(Exception):
            check([wrong])


@pytest.mark.parametrize("name", SCENES)
def test_a_replay_fits(name: str, run: Run, tmp_path: Path) -> None:
    known = tmp_path / "known.toml"
    known.write_text("interferer_hz = 50\n")
    kinds = check(run("replay", "--json", "--scene", f"hal-mock/scenes/{name}.toml", "--settings", known))
    assert {"hello", "contact", "slide", "estimate", "image", "release", "health"} <= kinds


def test_a_fit_fits(recordings: dict[str, Path], run: Run) -> None:
    for name in ["tone", "blank", "noise"]:
        assert check(run("fit", recordings[name], "--json")) == {"fit"}
    assert check(run("fit", recordings["single"], "--json", "--speed-column", "c0")) == {"fit"}


def test_an_emulated_touch_fits(run: Run) -> None:
    *events, truth = run("emulate", "--json")
    assert truth["type"] == "truth"
    # Only the emulator knows when a message's last byte had left the board.
    assert all(event["t_s"] < event.pop("left_s") for event in events)
    kinds = check(events)
    assert {"hello", "contact", "slide", "estimate", "texture", "image", "release", "health"} <= kinds


def test_a_recording_fits_in_every_form(telemetry: dict[str, Path], run: Run) -> None:
    assert "raw" in check(run("replay", telemetry["rec"], "--json"))
    lines = [json.loads(line) for line in telemetry["ndjson"].read_text().splitlines()]
    assert {"hello", "raw", "estimate", "health"} <= check(lines)


def test_streams_and_mcap_share_topics_and_schemas_and_fit(telemetry: dict[str, Path]) -> None:
    schemas, exported = mcap(telemetry["mcap"])
    done = command("serve", "--json", "--finger", f"finger={telemetry['rec']}")
    assert done.returncode == 0, done.stderr
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    served = [(line["topic"], line["message"]) for line in lines]
    for topic, message in [*exported, *served]:
        schema = schemas[topic]
        Draft202012Validator(schema).validate(message)
        unknown = set(message) - set(schema["properties"])
        assert message["type"] in OPEN or unknown <= {"positions_mm"}, unknown
    for schema in schemas.values():
        assert all(isinstance(kind, str) for kind in one_type(schema))
    own = {"connection", "lost"}
    of_board = [message["type"] for _, message in served if message["type"] not in own]
    assert of_board == [message["type"] for _, message in exported]
    assert {topic for topic, _ in exported} <= {topic for topic, _ in served} <= set(schemas)
