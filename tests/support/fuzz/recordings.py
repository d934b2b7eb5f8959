"""Mutated recordings and traces: as files of bytes, as records, and as the messages in them."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass
from random import Random
from typing import Any

from tests.support.fuzz.finding import Case
from tests.support.fuzz.recorded import Recording, load, records, small, written, written_by_others
from tests.support.fuzz.recordings_verdict import judge
from tests.support.fuzz.targets import Target
from tests.support.project import ROOT

FOLDERS = (ROOT / "tests/fuzz/corpus/recordings",)

NUMBERS = (0, 1, 2, 255, 2**15, 2**31 - 1, 2**31, 2**32 - 1, 2**48, 2**62, 2**63, 2**64 - 1)
TIMES = (0, 1, -1, 10**9, 2**31, 2**53, 2**62, 2**63 - 1, 2**63, 2**64 - 1)
KINDS = (
    *("bool", "byte", "int8", "uint8", "int16", "uint32", "int64", "uint64", "float32", "float64"),
    *("string", "wstring", "string<=5", "float64[]", "uint8[]", "string[]", "float64[3]", "Header"),
    *("uint8[<=9]", "nobody/Knows", "string[4000000000]", f"uint8[{'9' * 5000}]", "float64[0]"),
    *("std_msgs/Header", "geometry_msgs/Pose[]", "builtin_interfaces/Time", "empty/Empty[1000]"),
)
JSON = (
    *("", "null", "[]", "{}", "0", "1e999", "NaN", '"x"', "[1]", "[1, 2, 3]", '["a", "b", "c"]'),
    *('{"a": {"b": []}}', "[" * 2_000, "9" * 5_000, "-1", "true", '{"t": 1, "event": "x"}', "\x00"),
)
FACTS = ("start_ns", "world", "robot_hull", "namespace", "versions", "seed", "robot", "missing")
VALUES: tuple[Any, ...] = (
    *(None, True, 0, -1, 1.5, 10**30, "", "x", [], [1], {}, {"a": 1}, float("nan"), "\x1b[2J"),
    *(10**400, float("inf"), "goal sent", "status", "a" * 3000, "\ud800"),
)


@dataclass(frozen=True)
class Corpus:
    """What mutations begin with: whole files, recordings as data, and the lines of traces."""

    files: tuple[bytes, ...]
    recordings: tuple[Recording, ...]
    traces: tuple[bytes, ...]


def corpus() -> Corpus:
    """Read the recordings that are there, of this version and of earlier ones."""
    paths = [path for folder in FOLDERS for path in sorted(folder.glob("*.mcap"))]
    recordings = tuple(small(load(path)) for path in paths)
    return Corpus(
        tuple(written(sample) for sample in recordings)
        + tuple(path.read_bytes() for path in paths),
        recordings,
        tuple(filter(None, map(_trace, recordings))),
    )


def _trace(recording: Recording) -> bytes:
    """Return the trace in a recording as a file of its own."""
    lines = [
        data[8:].rstrip(b"\0")
        for topic, _, data in recording.messages
        if recording.topics[topic].name.endswith("/trace")
    ]
    return b"".join(line + b"\n" for line in lines)


def samples(known: Corpus) -> Iterator[Case]:
    """Yield what is sound."""
    yield from (Case("m.mcap", contents) for contents in known.files)
    yield from (Case("m.jsonl", contents) for contents in known.traces)


def case(known: Corpus, seed: int, number: int) -> Case:
    """Return a mutated recording or trace."""
    rng = Random(f"{seed}/{number}")
    chance = rng.random()
    if chance < 0.2:
        return Case("m.jsonl", _mutated_trace(rng, rng.choice(known.traces)))
    if chance < 0.45:
        few = rng.random() < 0.8
        files = known.files[: len(known.recordings)] if few else known.files
        return Case("m.mcap", _mutated_bytes(rng, rng.choice(files)))
    recording = deepcopy(rng.choice(known.recordings))
    for _ in range(rng.choice((1, 1, 2, 3, 6))):
        rng.choice(_CHANGES)(rng, recording, known)
    others = rng.random() < 0.4
    try:
        contents = written_by_others(rng, recording) if others else written(recording)
    except (struct.error, UnicodeEncodeError, MemoryError):  # this cannot be written at all
        contents = rng.choice(known.files)[: rng.randrange(2_000)]
    if rng.random() < 0.1:
        contents = _mutated_bytes(rng, contents)
    return Case("m.mcap", contents)


# ---- bytes --------------------------------------------------------------------------------------


def _mutated_bytes(rng: Random, contents: bytes) -> bytes:
    spoilt = bytearray(contents)
    match rng.randrange(7):
        case 0:
            return contents[: rng.randrange(len(contents) + 1)]
        case 1:
            _change_record(rng, spoilt)
        case 2:
            places = list(records(contents))
            at, length = rng.choice(places)
            del spoilt[at : at + 9 + length]
        case 3:
            places = list(records(contents))
            (at, length), (other, _) = rng.choice(places), rng.choice(places)
            spoilt[other:other] = contents[at : at + 9 + length]
        case 4:
            start = rng.randrange(len(spoilt) + 1)
            del spoilt[start : start + rng.choice((1, 4, 9, 1_000))]
        case _:
            for _ in range(rng.choice((1, 1, 1, 4, 50))):
                if spoilt:
                    spoilt[rng.randrange(len(spoilt))] ^= 1 << rng.randrange(8)
    return bytes(spoilt)


def _change_record(rng: Random, spoilt: bytearray) -> None:
    """Change the kind or the length of a record, or a length within it."""
    places = list(records(bytes(spoilt)))
    if not places:
        return
    at, length = rng.choice(places)
    number = rng.choice(NUMBERS)
    match rng.randrange(3):
        case 0:
            spoilt[at] = rng.choice((*range(16), 0x80, 0xFF))
        case 1:
            wrong = rng.choice((number, max(length + rng.choice((-1, 1, -9, 9)), 0)))
            spoilt[at + 1 : at + 9] = wrong.to_bytes(8, "little")
        case _:
            place, size = at + 9 + rng.randrange(min(length, 60) + 1), rng.choice((2, 4, 8))
            spoilt[place : place + size] = (number % 2 ** (8 * size)).to_bytes(size, "little")


# ---- data ---------------------------------------------------------------------------------------


def _with_data(rng: Random, recording: Recording, _known: Corpus) -> None:
    """Spoil a message: its bits, its length, a number in it."""
    if not recording.messages:
        return
    index = rng.randrange(len(recording.messages))
    topic, time_ns, data = recording.messages[index]
    spoilt = bytearray(data)
    start = rng.randrange(len(spoilt) + 1)
    match rng.randrange(6):
        case 0:
            del spoilt[start:]
        case 1:
            del spoilt[start : start + rng.choice((1, 4, 8))]
        case 2:
            spoilt[start:start] = rng.choice((b"\0", b"\xff", spoilt[start:] * 3))
        case 3:
            start -= start % 4
            number = rng.choice(NUMBERS) % 2**32
            spoilt[start : start + 4] = number.to_bytes(4, "little")
        case 4:
            start -= start % 8
            wrong = rng.choice((float("nan"), float("inf"), -1e308, 5e-324, 1e30))
            spoilt[start + 4 : start + 12] = struct.pack("<d", wrong)
        case _:
            for _ in range(rng.randint(1, 8)):
                if spoilt:
                    spoilt[rng.randrange(len(spoilt))] ^= 1 << rng.randrange(8)
    recording.messages[index] = topic, time_ns, bytes(spoilt)


def _with_definition(rng: Random, recording: Recording, known: Corpus) -> None:
    """Give a topic another schema: a field of another type or name, or that of another topic."""
    topic = rng.choice(recording.topics)
    lines = topic.definition.split("\n")
    fields = [i for i, line in enumerate(lines) if len(line.split()) >= 2 and line[0] not in "#=M"]
    match rng.randrange(6):
        case 0:
            topic.definition = rng.choice(rng.choice(known.recordings).topics).definition
        case 1:
            topic.type_name = rng.choice(
                (rng.choice(recording.topics).type_name, "", "x", "a/b/c/d", "std_msgs/msg/Empty")
            )
        case 2:
            start = rng.randrange(len(topic.definition) + 1)
            topic.definition = topic.definition[:start]
        case _ if fields:
            index = rng.choice(fields)
            words = lines[index].split()
            if rng.random() < 0.6:
                words[0] = rng.choice(KINDS)
            elif rng.random() < 0.5:
                words[1] = lines[rng.choice(fields)].split()[1]
            else:
                words = []
            lines[index] = " ".join(words)
            extra = "\n" + "=" * 80 + "\nMSG: empty/Empty\n"
            topic.definition = "\n".join(lines) + (extra if "empty/" in lines[index] else "")


def _with_order(rng: Random, recording: Recording, _known: Corpus) -> None:
    """Lose, double, move or re-date messages."""
    messages = recording.messages
    if not messages:
        return
    i, j = rng.randrange(len(messages)), rng.randrange(len(messages))
    match rng.randrange(6):
        case 0:
            messages[i], messages[j] = messages[j], messages[i]
        case 1:
            messages.insert(j, messages[i])
        case 2:
            del messages[min(i, j) : max(i, j)]
        case 3:
            rng.shuffle(messages)
        case 4:
            topic, _, data = messages[i]
            messages[i] = topic, rng.choice(TIMES) % 2**64, data
        case _:
            topic = messages[i][0]
            recording.messages = [message for message in messages if message[0] != topic]


def _with_channel(rng: Random, recording: Recording, _: Corpus) -> None:
    """Have messages come by another topic, or in another encoding."""
    i, j = rng.randrange(len(recording.topics)), rng.randrange(len(recording.topics))
    match rng.randrange(4):
        case 0:
            first, other = recording.topics[i], recording.topics[j]
            first.name, other.name = other.name, first.name
        case 1:
            recording.topics[i].name = rng.choice(
                ("", "/", "a", "/é", "/scan", "/x/_action/feedback")
            )
        case 2:
            recording.topics[i].encoding = rng.choice(("", "json", "ros1", "protobuf"))
        case _:
            recording.messages = [
                (j if topic == i else topic, time_ns, data)
                for topic, time_ns, data in recording.messages
            ]


def _with_notes(rng: Random, recording: Recording, _known: Corpus) -> None:
    """Spoil the facts and the summary, and the files within the file."""
    names = [*recording.notes, "bt_mission", "bt_mission_summary"]
    facts = recording.notes.setdefault(rng.choice(names), {})
    match rng.randrange(4):
        case 0 if facts:
            del facts[rng.choice(sorted(facts))]
        case 1 if recording.attached:
            index = rng.randrange(len(recording.attached))
            name, kind, time_ns, data = recording.attached[index]
            spoilt = (
                (rng.choice(("", "../x", "a\x00", "é")), kind, time_ns, data),
                (name, rng.choice(("image/png", "text/plain", "", "image/é")), time_ns, data),
                (name, kind, rng.choice(TIMES) % 2**64, data),
                (name, kind, time_ns, rng.choice((b"", b"\xff\xfe", b"\0" * 99))),
            )
            recording.attached[index] = rng.choice(spoilt)
        case _:
            facts[rng.choice((*facts, *FACTS))] = rng.choice(JSON)


def _with_line(rng: Random, recording: Recording, _: Corpus) -> None:
    """Spoil a line of the trace that is within the recording."""
    traces = [
        index
        for index, (topic, _, _) in enumerate(recording.messages)
        if recording.topics[topic].name.endswith("/trace")
    ]
    if not traces:
        return
    index = rng.choice(traces)
    topic, time_ns, data = recording.messages[index]
    line = _spoilt_line(rng, data[8:].rstrip(b"\0"))
    data = data[:4] + struct.pack("<I", len(line) + 1) + line + b"\0"
    recording.messages[index] = topic, time_ns, data


_CHANGES = (
    *(_with_data, _with_data, _with_data, _with_definition, _with_definition, _with_order),
    *(_with_order, _with_channel, _with_notes, _with_notes, _with_line),
)


# ---- traces -------------------------------------------------------------------------------------


def _mutated_trace(rng: Random, contents: bytes) -> bytes:
    lines = contents.split(b"\n")
    for _ in range(rng.choice((1, 1, 2, 4))):
        i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
        match rng.randrange(6):
            case 0:
                lines[i], lines[j] = lines[j], lines[i]
            case 1:
                del lines[i]
                lines = lines or [b""]
            case 2:
                lines = b"\n".join(lines)[: rng.randrange(len(contents) + 1)].split(b"\n")
            case _:
                lines[i] = _spoilt_line(rng, lines[i])
    return b"\n".join(lines)


def _spoilt_line(rng: Random, line: bytes) -> bytes:
    try:
        event = json.loads(line)
    except ValueError:
        event = None
    if not isinstance(event, dict) or not event or rng.random() < 0.2:
        spoilt = bytearray(line or b"x")
        spoilt[rng.randrange(len(spoilt))] ^= 1 << rng.randrange(8)
        return bytes(spoilt).replace(b"\n", b" ")
    key = rng.choice(sorted(event))
    match rng.randrange(4):
        case 0:
            del event[key]
        case 1:
            event[rng.choice(("t", "event", "status", "text", "with", "x"))] = rng.choice(VALUES)
        case _:
            event[key] = rng.choice(VALUES)
    return json.dumps(event).encode()


TARGET = Target(corpus, samples, case, judge)
