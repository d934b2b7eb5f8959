"""Small random trees, and all their runs by plain enumeration: nothing merged, nothing put back."""

from __future__ import annotations

import random
from dataclasses import dataclass, field

from bt_mission.commands.prove.choices import Script
from bt_mission.commands.prove.claims import Broken, Claims
from bt_mission.commands.prove.environment import Environment
from bt_mission.commands.prove.explorer import explore
from bt_mission.commands.prove.known_steps import DivergedError
from bt_mission.language.mission import Mission
from bt_mission.sessions.load import load

HEAD = "mission: small\ntree:\n"
MOST_NODES = 8
_LIMITS = ("server_timeout: 0.1", "acceptance_timeout: 0.1", "cancel_timeout: 0.1")


class TooManyRunsError(Exception):
    """More runs than are worth it."""


@dataclass
class Verdicts:
    """What the runs of a mission come to."""

    ends: set[tuple[str, str]] = field(default_factory=set)
    broken: set[tuple[str, str]] = field(default_factory=set)
    given_up: set[tuple[str, str]] = field(default_factory=set)

    def note_end(self, environment: Environment) -> None:
        """Note how a run ends."""
        self.ends.add((str(environment.executive.verdict), environment.reason))


class _Ends(Claims):
    def __init__(self, verdicts: Verdicts) -> None:
        super().__init__()
        self.verdicts = verdicts

    def look(self, environment: Environment) -> tuple[Broken, ...]:
        if environment.is_done:
            self.verdicts.note_end(environment)
        return super().look(environment)


def explored(mission: Mission, faults: float, *, with_interrupts: bool = False) -> Verdicts:
    """Return the verdicts of an exploration; as `prove`, without known steps if those diverge."""

    def verdicts_of(*, learns: bool) -> Verdicts:
        verdicts = Verdicts()
        claims = _Ends(verdicts)
        environment = Environment(mission, faults=faults, has_interrupts=with_interrupts)
        assert explore(environment, claims, learns=learns).is_exhaustive
        verdicts.broken, verdicts.given_up = set(claims.broken), set(claims.given_up)
        return verdicts

    try:
        return verdicts_of(learns=True)
    except DivergedError:
        return verdicts_of(learns=False)


def enumerated(
    mission: Mission, faults: float, *, with_interrupts: bool = False, most: int = 4000
) -> Verdicts:
    """Return the verdicts of all runs, each from its beginning.

    Raises:
        TooManyRunsError: When there are more runs.
    """
    verdicts = Verdicts()
    claims = _Ends(verdicts)
    waiting: list[tuple[Script, ...]] = [((),)]
    count = 0
    while waiting:
        way = waiting.pop()
        environment = Environment(mission, faults=faults, has_interrupts=with_interrupts)
        for script in way[:-1]:
            environment.step(script)
        script = way[-1]
        while True:
            is_allowed = environment.step(script)
            others = list(environment.choices.others())
            waiting += [(*way[:-1], other) for other in others]
            count += 1
            if count > most:
                raise TooManyRunsError
            if not is_allowed:
                break
            claims.take(claims.look(environment), 0, environment.choices.faults_left)
            if environment.is_done or environment.is_stuck:
                break
            way = (*way[:-1], environment.choices.taken, ())
            script = ()
    verdicts.broken, verdicts.given_up = set(claims.broken), set(claims.given_up)
    return verdicts


def small_mission(seed: int) -> Mission:
    """Return a random mission with few nodes and short limits."""
    draw = random.Random(seed)
    lines = _Writer(draw).node(1, draw.randint(2, MOST_NODES))
    return load(HEAD + "\n".join(lines) + "\n")


def looping_mission(seed: int) -> Mission:
    """Return a random mission in which a deadline runs while a loop of three rounds turns."""
    draw = random.Random(seed)
    limit = draw.choice((0.1, 0.25, 0.4))
    is_beside = draw.random() < 0.5
    lines = (
        [f"  parallel:\n    - wait: {limit}\n    -"]
        if is_beside
        else [f"  timeout: {limit}\n  do:"]
    )
    depth = 3 if is_beside else 2
    pad = "  " * depth
    body = _Writer(draw).node(depth + 1, draw.randint(1, 3))
    lines += [f"{pad}repeat: {{count: 3}}", f"{pad}do:", *body]
    lines += [f"  succeed_when: {draw.choice(('any', 'all'))}"] if is_beside else []
    return load(HEAD + "\n".join(lines) + "\n")


class _Writer:
    def __init__(self, draw: random.Random) -> None:
        self._draw = draw
        self._count = 0

    def node(self, depth: int, size: int) -> list[str]:
        """Return the lines of a node with about so many nodes in it."""
        if size <= 1:
            return self._leaf(depth)
        kind = self._draw.choice(("sequence", "fallback", "parallel", "decorator"))
        if kind == "decorator":
            return self._decorator(depth, size)
        count = self._draw.randint(2, 3)
        pad = "  " * depth
        lines = [f"{pad}{kind}:"]
        for _ in range(count):
            child = self.node(depth + 2, max(1, (size - 1) // count))
            lines += [f"{pad}  - {child[0].lstrip()}", *child[1:]]
        if kind == "parallel":
            lines.append(f"{pad}succeed_when: {self._draw.choice(('any', 'all'))}")
        return lines

    def _decorator(self, depth: int, size: int) -> list[str]:
        pad = "  " * depth
        kind = self._draw.choice(
            ("repeat: {count: 2}", "retry: {attempts: 2}", "timeout: 0.15", "invert", "finally")
        )
        child = self.node(depth + 1, size - 1)
        if kind == "invert":
            return [f"{pad}invert:", *child]
        if kind == "finally":
            leaf = self._leaf(depth + 1)
            return [f"{pad}finally: {{timeout: 0.2}}", f"{pad}do:", *child, f"{pad}then:", *leaf]
        return [f"{pad}{kind}", f"{pad}do:", *child]

    def _leaf(self, depth: int) -> list[str]:
        pad = "  " * depth
        self._count += 1
        kind = self._draw.choice(("goal", "goal", "wait", "check", "service"))
        name = f"name: n{self._count}"
        if kind == "wait":
            return [f"{pad}wait: {self._draw.choice((0.05, 0.1, 0.2))}", f"{pad}{name}"]
        if kind == "check":
            return [f"{pad}check: {self._draw.choice(('true', 'false'))}", f"{pad}{name}"]
        if kind == "service":
            service = "{name: stop, type: std_srvs/srv/Trigger}"
            limits = ("timeout: 0.1", "server_timeout: 0.1")
            return [f"{pad}service: {service}", f"{pad}{name}", *(pad + entry for entry in limits)]
        goal = self._draw.choice(("turn: {angle: 90}", "move: {secs: 1, linear_velocity: 0.1}"))
        bounds = (*_LIMITS, f"timeout: {self._draw.choice((0.1, 0.2))}")
        return [f"{pad}{goal}", f"{pad}{name}", *(pad + entry for entry in bounds)]
