"""``@pytest.mark.scenario``: which seeds a test runs with, and in which order."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import pytest

from bt_mission.testing.options import MARKER

USAGE = "@pytest.mark.scenario(seeds=range(50), at_least=0.9)"
FAILING = "bt_mission/failing_seeds"
"""Where pytest's cache keeps the seeds that failed, by the test's node id."""


class MarkerError(Exception):
    """A marker that cannot be understood; it says what was expected, and what was got."""


@dataclass(frozen=True)
class ScenarioMark:
    """The seeds of a marker.

    Args:
        seeds: One test for each.
        at_least: The share of seeds that has to pass; None is all.
    """

    seeds: tuple[int, ...]
    at_least: float | None = None


@dataclass(frozen=True)
class SeededTest:
    """One test of a scenario.

    Args:
        seed: Of this one.
        test: Node id of the test without its seed.
        function: Node id of the test without any parameter.
    """

    seed: int
    test: str
    function: str
    at_least: float | None


def read_marker(mark: pytest.Mark) -> ScenarioMark:
    """Return the seeds of a test's marker.

    Raises:
        MarkerError: When it is not as in :data:`USAGE`.
    """
    if mark.args:
        raise MarkerError(f"seeds are given by name: {USAGE}")
    unknown = [name for name in mark.kwargs if name not in ("seeds", "at_least")]
    if unknown:
        raise MarkerError(f"unknown argument '{unknown[0]}': {USAGE}")
    if "seeds" not in mark.kwargs:
        raise MarkerError(f"the seeds are missing: {USAGE}")
    return ScenarioMark(_seeds(mark.kwargs["seeds"]), _at_least(mark.kwargs.get("at_least")))


def _seeds(given: Any) -> tuple[int, ...]:
    if _is_whole(given):
        if given < 1:
            raise MarkerError(f"seeds={given}: at least one seed is needed")
        return tuple(range(given))
    if not isinstance(given, Sequence) or isinstance(given, str | bytes):
        what = f"{given!r}, of type {type(given).__name__}"
        raise MarkerError(f"seeds is a number of seeds, a range or a list of seeds, not {what}")
    for seed in given:
        if not _is_whole(seed) or seed < 0:
            raise MarkerError(f"a seed is an integer from 0, not {seed!r}")
    if not given:
        raise MarkerError(f"seeds={given!r}: at least one seed is needed")
    if len(set(given)) < len(given):
        twice = next(seed for seed in given if list(given).count(seed) > 1)
        raise MarkerError(f"the seed {twice} appears twice")
    return tuple(given)


def _at_least(given: Any) -> float | None:
    if given is None:
        return None
    if isinstance(given, bool) or not isinstance(given, int | float) or not 0 < given <= 1:
        raise MarkerError(
            f"expected the share of seeds that must pass as at_least, such as 0.9, got {given}"
        )
    return float(given)


def _is_whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def so_many(seeds: tuple[int, ...], count: int) -> tuple[int, ...]:
    """The first `count` seeds; after the last, they continue from the greatest."""
    more = range(max(seeds) + 1, max(seeds) + 1 + max(count - len(seeds), 0))
    return (*seeds[:count], *more)


def name_of(seed: int) -> str:
    """The name of a seed in the id of its test."""
    return f"seed{seed}"


def asked_for(arguments: Iterable[str], function: str) -> list[int]:
    """The seeds of a test function that stand on the command line, as in ``a.py::test[seed7]``."""
    seeds = []
    for argument in arguments:
        match = re.search(r"::([^:\[\]]+)\[(.*)\]$", argument)
        if match and match[1] == function:
            parts = match[2].split("-")
            seeds += [int(part[4:]) for part in parts if re.fullmatch(r"seed\d+", part)]
    return seeds


def parametrize(metafunc: pytest.Metafunc) -> None:
    """Make one test for each seed: those first that failed last time, or are asked for by name.

    Raises:
        pytest.Collector.CollectError: For a marker that cannot be understood.
    """
    definition, config = metafunc.definition, metafunc.config
    mark = definition.get_closest_marker(MARKER)
    if mark is None:
        return
    for other in definition.iter_markers("parametrize"):
        if other.args and "seed" in re.split(r"[\s,]+", _joined(other.args[0])):
            text = "@pytest.mark.scenario gives the argument 'seed', and so does parametrize"
            raise pytest.Collector.CollectError(f"{definition.nodeid}: {text}")
    try:
        seeds = read_marker(mark).seeds
    except MarkerError as error:
        text = f"{definition.nodeid}: @pytest.mark.scenario: {error}"
        raise pytest.Collector.CollectError(text) from error
    count = config.getoption("scenario_seeds")
    if count is not None:
        seeds = so_many(seeds, count)
    first = [
        *failing_seeds(getattr(config, "cache", None)).get(definition.nodeid, ()),
        *asked_for(config.args, definition.name),
    ]
    if "seed" not in metafunc.fixturenames:
        metafunc.fixturenames.append("seed")
    metafunc.parametrize("seed", list(dict.fromkeys([*first, *seeds])), ids=name_of)


def _joined(names: Any) -> str:
    return names if isinstance(names, str) else ",".join(names)


def failing_seeds(cache: pytest.Cache | None) -> dict[str, list[int]]:
    """The seeds that failed and have not passed since, by the test's node id."""
    seeds = {} if cache is None else cache.get(FAILING, {})
    return seeds if isinstance(seeds, dict) else {}


def seeded(item: pytest.Item) -> SeededTest | None:
    """The role of a test among those of a scenario, or None."""
    mark = item.get_closest_marker(MARKER)
    call = getattr(item, "callspec", None)
    if mark is None or call is None or "seed" not in call.params:
        return None
    seed: int = call.params["seed"]
    function = item.nodeid.removesuffix(f"[{call.id}]")
    rest = call.id.split("-")
    rest.remove(name_of(seed))
    others = f"[{'-'.join(rest)}]" if rest else ""
    return SeededTest(seed, function + others, function, read_marker(mark).at_least)


def line_to_repeat(config: pytest.Config, nodeid: str) -> str:
    """The command that runs one test again, in the folder where pytest started."""
    path, colons, name = nodeid.partition("::")
    here = os.path.relpath(config.rootpath / path, config.invocation_params.dir)
    return f"pytest {shlex.quote(here + colons + name)}"
