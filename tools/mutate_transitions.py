"""Changes the table of a goal's life, one transition at a time; a test must fail each time.

Each mutant drops a transition, leads it to another phase, or takes or adds a request. The tests of
tests/goals run against it in a process of its own. Run it as: python tools/mutate_transitions.py
"""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
TESTS = ("test_goal.py", "test_ledger.py", "test_attempt.py", "test_model.py")

Table = Mapping[Any, Any]

UNCHANGED = "the table as it is"
"""The first of the mutants, which must survive."""


def mutants(table: Table) -> Iterator[tuple[str, Table]]:
    """Yield the table, and every one that differs from it in one transition, with what it is."""
    from bt_mission.goals.goal import Command, Phase  # noqa: PLC0415 - imported where it is mutated

    yield UNCHANGED, table
    for pair, (then, commands) in table.items():
        name = f"{pair[0]} + {pair[1]}"
        rest = {key: value for key, value in table.items() if key != pair}
        yield f"{name}: dropped", rest
        for phase in Phase:
            if phase is not then:
                yield f"{name}: to {phase} instead of {then}", {**rest, pair: (phase, commands)}
        for command in Command:
            if command in commands:
                fewer = tuple(one for one in commands if one is not command)
                yield f"{name}: does not {command}", {**rest, pair: (then, fewer)}
            else:
                more = (*commands, command)
                yield f"{name}: does {command}, too", {**rest, pair: (then, more)}


def survives(number: int) -> bool:
    """Run the tests against a mutant; true where none of them fails."""
    import pytest  # noqa: PLC0415 - in the process of the mutant

    from bt_mission.goals import goal  # noqa: PLC0415 - as above

    _, table = list(mutants(goal.TRANSITIONS))[number]
    goal.TRANSITIONS = MappingProxyType(dict(table))
    sys.stdout = sys.stderr = Path("/dev/null").open("w", encoding="utf-8")  # noqa: SIM115 - to the end
    chosen = [str(ROOT / "tests" / "goals" / name) for name in TESTS]
    return pytest.main(["-q", "-x", "-p", "no:cacheprovider", f"--rootdir={ROOT}", *chosen]) == 0


def main() -> int:
    """Try all; gives the exit code, 0 when no mutant survives."""
    from bt_mission.goals.goal import TRANSITIONS  # noqa: PLC0415 - as above

    names = [name for name, _ in mutants(TRANSITIONS)]
    # One process a mutant: what pytest imports once must not outlive the table it was run with.
    with multiprocessing.get_context("spawn").Pool(2, maxtasksperchild=1) as pool:
        alive = pool.map(survives, range(len(names)), chunksize=1)
    if not alive.pop(0):
        print(f"the tests fail with {names[0]}")
        return 1
    for name, lives in zip(names[1:], alive, strict=True):
        if lives:
            print(f"no test fails: {name}")
    count = f"{alive.count(False)} of {len(alive)}"
    print(f"{count} mutants of {len(TRANSITIONS)} transitions fail a test")
    return 1 if any(alive) else 0


if __name__ == "__main__":
    sys.exit(main())
