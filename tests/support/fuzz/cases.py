"""Mutated mission files: the same for the same seed, number and corpus."""

from __future__ import annotations

import json
import pickle
import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

import yaml  # type: ignore[import-untyped]

from tests.support.fuzz import verdict
from tests.support.fuzz.finding import Case
from tests.support.fuzz.large import large
from tests.support.fuzz.structure import Pool, change, is_node, names_in, slots, supply
from tests.support.fuzz.targets import Target
from tests.support.project import ROOT

CORPUS = ROOT / "tests/fuzz/corpus"
COMPANIONS = CORPUS / "beside"
FOLDERS = (CORPUS, ROOT / "missions", ROOT / "missions/sources", ROOT / "tests/language/broken")

LARGE_SHARE = 1 / 1000
LARGEST_START = 20_000
"""Characters of a file of the corpus that is still mutated."""

LARGEST = 1_100_000
"""Characters of a case, a little more than is read."""

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
_RAW = re.compile(r"""(?P<quote>["'])@RAW@(.*?)@(?P=quote)""")
_WORD = re.compile(r"[A-Za-z_$.0-9]+")
_SYMBOLS = "$ ${ } { [ ] : - & * ! | > # ' \" \\ % @ ` ? --- ... ~ = == (((  ))) [[[ {{{ ,"
_WORDS = (
    "1e999 .nan -1 2**99 true sin( uniform(0,1) x.y $speed turn wait do name outputs timeout é 前"
)
_PIECES = (
    *_SYMBOLS.split(),
    *_WORDS.split(),
    *(
        "\n",
        "  ",
        "\t",
        "\x00",
        "\u2028",
        "\ufeff",
        "\r",
        "\x85",
        "- ",
        ": ",
        "&a ",
        "*a",
        "<<: *a",
    ),
    *("9" * 400, "? ", "%YAML 1.1\n---\n", "\n---\n", "\n...\n", "!!binary ", "!<x> ", "\x7f"),
)


@dataclass(frozen=True)
class Corpus:
    """The files that mutations begin with, as they are and as data."""

    texts: tuple[str, ...]
    data: tuple[bytes, ...]
    sound: tuple[bytes, ...]
    pool: Pool


def corpus() -> Corpus:
    """Read the corpus."""
    texts = _texts(*FOLDERS)
    data = [
        parsed for text in texts if isinstance(parsed := _data(text), dict) and _is_small(parsed)
    ]
    values = [slot for mission in data for slot in slots(mission)]
    pool = Pool(
        tuple(slot.value for slot in values if is_node(slot.value)),
        tuple(dict.fromkeys(slot.key for slot in values if isinstance(slot.key, str))),
        frozenset(name for mission in data for name in names_in(mission)),
        tuple(slot.value for slot in values if not isinstance(slot.value, dict)),
    )
    sound = [parsed for text in _texts(*FOLDERS[:-1]) if isinstance(parsed := _data(text), dict)]
    return Corpus(
        tuple(texts),
        tuple(pickle.dumps(mission) for mission in data),
        tuple(pickle.dumps(mission) for mission in sound),
        pool,
    )


def _texts(*folders: Path) -> list[str]:
    paths = [path for folder in folders for path in sorted(folder.glob("*.yaml"))]
    texts = [path.read_text(encoding="utf-8", errors="replace") for path in paths]
    return [text for text in texts if len(text) <= LARGEST_START]


def _is_small(data: Any) -> bool:
    """Return whether data without its aliases is no larger than a file."""
    try:
        return len(json.dumps(data)) <= LARGEST_START
    except (ValueError, TypeError):  # contains itself, or has a key that is none
        return False


def _data(text: str) -> Any:
    try:
        return yaml.load(text, Loader=_LOADER)  # noqa: S506 - a safe loader
    except (yaml.YAMLError, ValueError, RecursionError):
        return None


def prepare(folder: Path) -> None:
    """Put what missions of the corpus include and import beside them, and some traps."""
    for path in sorted(COMPANIONS.iterdir()):
        if path.is_file():
            shutil.copy(path, folder)
    (folder / "folder.yaml").mkdir()
    (folder / "loop.yaml").symlink_to("loop.yaml")
    (folder / "outside.yaml").symlink_to(ROOT / "pyproject.toml")


def samples(known: Corpus) -> Iterator[Case]:
    """Yield what is sound."""
    yield from (Case("m.yaml", text.encode()) for text in known.texts)


def case(known: Corpus, seed: int, number: int) -> Case:
    """Return a mutated mission file."""
    rng = Random(f"{seed}/{number}")
    if rng.random() < LARGE_SHARE:
        return Case("m.yaml", large(rng).encode())
    if rng.random() < 0.65:
        text = _structural(rng, known)
        if rng.random() < 0.1:
            text = _textual(rng, text)
    else:
        text = _textual(rng, rng.choice(known.texts))
    contents = text.encode("utf-8", "surrogatepass")
    return Case("m.yaml", with_bytes(rng, contents) if rng.random() < 0.02 else contents)


def _structural(rng: Random, samples: Corpus) -> str:
    gently = rng.random() < 0.6
    data = pickle.loads(rng.choice(samples.sound if gently else samples.data))  # noqa: S301 - as above
    for _ in range(rng.choice((1, 1, 1, 2, 2, 3, 5))):
        change(rng, data, samples.pool, gently=gently)
    if gently:
        supply(rng, data, samples.pool)
    return _RAW.sub(lambda match: match[2], _dumped(rng, data)[:LARGEST])


def _dumped(rng: Random, data: Any) -> str:
    try:
        if rng.random() < 0.6:
            return json.dumps(data, ensure_ascii=False, indent=rng.choice((None, 1, 2)))
        return str(yaml.dump(data, Dumper=_DUMPER, allow_unicode=True, sort_keys=False, width=90))
    except (ValueError, TypeError, RecursionError):  # contains itself, or has a key that is none
        try:
            return str(yaml.dump(data, Dumper=_DUMPER))
        except (yaml.YAMLError, ValueError, TypeError, RecursionError):
            return "mission: m\ntree: {wait: 1}\n"


def _textual(rng: Random, text: str) -> str:
    for _ in range(rng.choice((1, 1, 2, 3, 4))):
        if rng.random() < 0.6:
            text = edited(rng, text, _PIECES, _WORD)
        else:
            text = "\n".join(_with_lines(rng, text.split("\n")))
    return text


def edited(rng: Random, text: str, pieces: tuple[str, ...], words: re.Pattern[str]) -> str:
    """Return a text with a piece more, a part less, a part repeated, or another word."""
    start = rng.randrange(len(text) + 1)
    stop = min(len(text), start + rng.randint(0, 30))
    match rng.randrange(4):
        case 0:
            return text[:start] + rng.choice(pieces) + text[start:]
        case 1:
            return text[:start] + text[stop:]
        case 2:
            return text[:start] + text[start:stop] * rng.choice((2, 3, 50)) + text[stop:]
    spans = [match.span() for match in words.finditer(text)] or [(start, stop)]
    (a, b), (c, d) = rng.choice(spans), rng.choice(spans)
    return text[:a] + rng.choice((text[c:d], rng.choice(pieces))) + text[b:]


def _with_lines(rng: Random, lines: list[str]) -> list[str]:
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    match rng.randrange(4):
        case 0:
            lines[i], lines[j] = lines[j], lines[i]
        case 1:
            lines.insert(j, lines[i])
        case 2:
            del lines[i]
        case _:
            lines[i] = " " * rng.randint(0, 8) + lines[i].lstrip()
    return lines


def with_bytes(rng: Random, contents: bytes) -> bytes:
    """Return contents with some other bytes."""
    spoilt = bytearray(contents)
    for _ in range(rng.randint(1, 4)):
        if spoilt:
            spoilt[rng.randrange(len(spoilt))] = rng.randrange(256)
    return bytes(spoilt)


TARGET = Target(corpus, samples, case, verdict.judge, prepare)
