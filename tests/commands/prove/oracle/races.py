"""Random missions in which answers matter by their moments: late ones, and limits that meet.

Values and instants are drawn; the forms are those of missions that people write.
"""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

Data = dict[str, Any]
BATTERY = {"topic": "battery_state", "type": "sensor_msgs/msg/BatteryState"}
STOP = {"name": "stop", "type": "std_srvs/srv/Trigger"}
POWER = {"topic": "motors_on", "type": "std_msgs/msg/Bool", "field": "data", "as": "on"}
TURN = {"turn": {"angle": 90}}
FORWARD = {"explore_forward": {"fwd_velocity": 0.2, "stopping_distance": 0.5}}


def race(draw: Random) -> Data:
    """Return a mission, apart from its name."""
    data: Data = draw.choice(FORMS)(draw)
    return data


def _goal(draw: Random, name: str, **settings: Any) -> Data:
    """Return a goal that drives, with limits."""
    kind = draw.choice(
        (
            TURN,
            {"move": {"secs": 1, "linear_velocity": 0.1}},
            FORWARD,
        )
    )
    limits = {
        "timeout": _time(draw, 0.3, 4),
        "server_timeout": _time(draw, 0.1, 1),
        "acceptance_timeout": _time(draw, 0.1, 1),
        "cancel_timeout": _time(draw, 0.1, 1),
    }
    return kind | limits | {"name": name} | settings


def _time(draw: Random, low: float, high: float) -> float:
    return round(draw.uniform(low, high) * 20) / 20


def _wait(draw: Random, name: str, high: float = 2) -> Data:
    return {"wait": _time(draw, 0.1, high), "name": name}


def _halted(draw: Random) -> Data:
    """A goal is halted before or after its acceptance; another one follows."""
    first = _goal(draw, "a")
    if draw.random() < 0.6:
        first |= {"cancel_timeout": 0.1, "acceptance_timeout": 2.0}
    either = {"parallel": [first, _wait(draw, "w", 0.5)], "succeed_when": "any"}
    forced = {"force": "success", "do": either}
    rest = draw.choice(([_goal(draw, "b")], [_wait(draw, "v"), _goal(draw, "b")]))
    return {
        "tree": {"sequence": [forced, *rest]},
        "requirements": {
            "r0": 'never running("b") and accepted("a")',
            "r1": f"never open_goals > {draw.choice((0, 1, 2))}",
            "r2": 'never failed("b")',
        },
    }


def _guarded(draw: Random) -> Data:
    """A message halts a goal; later ones matter, too."""
    least, other = (round(draw.uniform(5, 95), 1) for _ in range(2))
    follow: Data = {**BATTERY, "field": "percentage", "as": "charge"}
    if draw.random() < 0.6:
        follow["initial"] = round(draw.uniform(0, 100), 1)
    if draw.random() < 0.5:
        follow |= {"timeout": _time(draw, 0.5, 2), "default": round(draw.uniform(0, 100), 1)}
    guarded = {"guard": f"charge > {least}", "do": _goal(draw, "a"), "name": "g"}
    after = {"when": f"charge < {other}", "do": {"log": "low", "name": "low"}, "name": "h"}
    return {
        "follow": [follow],
        "tree": {"sequence": [{"force": "success", "do": guarded}, _wait(draw, "w", 0.5), after]},
        "requirements": {
            "r0": 'never running("w") and accepted("a")',
            "r1": 'never running("low")',
            "r2": f"never $charge > {max(least, other)}",
            "r3": 'never succeeded("a") and running("h")',
        },
    }


def _orders(draw: Random) -> Data:
    """Two branches whose limits and answers come in any order."""
    first = [_goal(draw, "a"), _wait(draw, "b")]
    second = [_wait(draw, "c"), draw.choice((_wait, _goal))(draw, "d")]
    if draw.random() < 0.4:
        second.append(_goal(draw, "e"))
    last = second[-1]["name"]
    return {
        "tree": {
            "parallel": [{"sequence": first, "name": "s"}, {"sequence": second, "name": "t"}],
            "succeed_when": draw.choice(("all", "any")),
            "name": "p",
        },
        "requirements": {
            "r0": 'never running("b") and running("c")',
            "r1": f'never running("b") and running("{last}")',
            "r2": 'whenever running("d"): previously succeeded("a")',
            "r3": 'not succeeded("s") until succeeded("c")',
        },
    }


def _flags(draw: Random) -> Data:
    """A variable says what came first."""
    first = {"sequence": [_goal(draw, "a"), {"set": {"is_done": True}, "name": "f"}]}
    waits = [_wait(draw, "w"), {"set": {"early": "$is_done"}, "name": "x"}]
    waits += [_wait(draw, "v", 0.5), {"set": {"late": "$is_done"}, "name": "y"}]
    start = {"set": {"is_done": False, "early": False, "late": False}, "name": "n"}
    both = {"parallel": [first, {"sequence": waits}], "succeed_when": "any"}
    return {
        "tree": {"sequence": [start, {"force": "success", "do": both}, _wait(draw, "z", 0.3)]},
        "requirements": {
            "r0": "never $late and not $early",
            "r1": "never $early",
            "r2": 'never $is_done and running("z")',
        },
    }


def _outcomes(draw: Random) -> Data:
    """How a goal has ended matters later."""
    retried = {"retry": {"attempts": 2}, "do": _goal(draw, "a"), "name": "again"}
    first = draw.choice((_goal(draw, "a"), retried))
    rest = [_wait(draw, "w", 0.5), _goal(draw, "b")] if draw.random() < 0.5 else [_goal(draw, "b")]
    ways = ("aborted", "rejected", "server lost", "canceled by timeout", "unconfirmed")
    return {
        "tree": {"fallback": [first, {"sequence": rest, "name": "s"}]},
        "requirements": {
            f"r{number}": f'never outcome("a") = "{way}" and running("b")'
            for number, way in enumerate(draw.sample(ways, 3))
        }
        | {
            "r3": 'whenever running("b"): accepted("a")',
            "r4": 'always count(starts(running("a"))) <= 1',
            "r5": 'never failed("b")',
        },
    }


def _away(draw: Random) -> Data:
    """A server or a service that is away or mute is asked again."""
    call = {"service": STOP, "timeout": _time(draw, 0.1, 1), "server_timeout": 0.2}
    first = draw.choice((_goal(draw, "a"), {**call, "name": "a"}))
    other = draw.choice((_goal(draw, "b"), {**call, "name": "b"}))
    again = other if draw.random() < 0.3 else first | {"name": "b"}
    return {
        "tree": {
            "sequence": [
                {"fallback": [first, _wait(draw, "w", 0.5)]},
                {"fallback": [again, {"log": "no", "name": "no"}]},
            ]
        },
        "requirements": {
            "r0": 'whenever running("no"): previously failed("a")',
            "r1": 'never running("no")',
            "r2": 'never succeeded("b")',
            "r3": 'never failed("b") and previously failed("a")',
        },
    }


def _watched(draw: Random) -> Data:
    """Feedback ends a goal, by a condition on a variable that a topic or a draw gives."""
    low, high = sorted(round(draw.uniform(0, 5), 2) for _ in range(2))
    set_far = {"set": {"far": draw.choice(("uniform(1, 5)", low, "choice(1, 2, 3, 4)"))}}
    conditions = (
        f"current_distance_travelled > $far and closest_obstacle < {high}",
        f"closest_obstacle < {high} and $far > {round(draw.uniform(3.1, 4.9), 2)}",
    )
    forward = FORWARD | {
        "timeout": _time(draw, 0.3, 4),
        "feedback_timeout": _time(draw, 0.3, 2),
        "cancel_when": draw.choice(conditions),
        "on_cancel": draw.choice(("success", "failure")),
        "outputs": {"closest_obstacle": "gap"},
        "name": "a",
    }
    if draw.random() < 0.5:
        del forward["feedback_timeout"]
    near = {"when": f"gap > {low} and gap < {high}", "do": {"log": "near", "name": "near"}}
    far = {"when": "far > 3", "do": {"log": "far", "name": "b"}, "name": "k"}
    return {
        "tree": {"sequence": [set_far | {"name": "n"}, forward, near | {"name": "m"}, far]},
        "requirements": {
            "r0": 'never outcome("a") = "canceled by condition"',
            "r1": 'never running("near")',
            "r2": f"never $gap > {high}",
            "r3": 'never running("b")',
            "r4": 'never outcome("a") = "canceled by timeout"',
            "r5": 'never failed("a")',
        },
    }


def _chosen(draw: Random) -> Data:
    """One of several branches; a loop counts."""
    count = draw.randint(3, 9)
    branches = [{"log": str(number), "name": f"c{number}"} for number in range(count)]
    drawn = ", ".join(str(number) for number in range(1, count + 1))
    chosen = draw.randint(1, count)
    when = {"when": f"x == {chosen}", "do": {"log": "one", "name": "one"}, "name": "k"}
    loop = {
        "repeat": {"until": "x > 2", "count": draw.choice((2, 3, 12))},
        "do": {"sequence": [{"choose": branches, "name": "which"}, _goal(draw, "a")]},
        "name": "loop",
    }
    return {
        "tree": {"sequence": [{"set": {"x": f"choice({drawn})"}, "name": "n"}, when, loop]},
        "requirements": {
            "r0": f'never running("c{count - 1}")',
            "r1": f"never $x >= {count}",
            "r2": f'always count(starts(running("a"))) <= {draw.choice((1, 2, 3))}',
        },
    }


def _cleaned(draw: Random) -> Data:
    """A clean-up runs while an old goal is still open."""
    body = {"parallel": [_goal(draw, "a"), _wait(draw, "w", 1)], "succeed_when": "any"}
    tree = {
        "finally": {"timeout": _time(draw, 0.3, 1)},
        "do": draw.choice((body, {"timeout": _time(draw, 0.1, 1), "do": _goal(draw, "a")})),
        "then": draw.choice((_goal(draw, "b"), {"log": "clean", "name": "b"})),
        "name": "f",
    }
    return {
        "tree": tree,
        "requirements": {
            "r0": 'never running("b") and accepted("a")',
            "r1": "never open_goals > 1",
            "r2": 'never failed("b")',
        },
    }


def _compared(draw: Random) -> Data:
    """A result is compared, computed with and passed on, with numbers that are drawn."""
    scale = draw.choice((0.1, 1, 10, 100))
    low, high = sorted(round(scale * draw.uniform(0.1, 1), 3) for _ in range(2))
    conditions = (
        f"gap > {low} and gap < {high}",
        f"gap == {low}",
        f"gap > {low} and gap <= {low}",
        f"gap >= {high} and gap < {high + 0.01:g}",
        f"gap * gap > {high * high:g} and gap < {high}",
        f"abs(gap) < {low} and gap < 0",
        f"gap > 0 and 1 / gap > {10 * high:g}",
        f"{high} * gap > {low} and gap < {low}",
        f"min(gap, {high}) > {low} and gap != {high}",
        f"sqrt(abs(gap)) > {low} and gap < {high}",
    )
    passed = {"set": {"near": f"gap - {low}", "much": f"near * {high}"}, "name": "n"}
    between = f"much > {low} and much < {low + draw.choice((0.1, 1.0)):g}"
    rest: list[Data] = [
        {
            "when": draw.choice(conditions),
            "do": {"log": "x", "name": f"x{index}"},
            "name": f"h{index}",
        }
        for index in range(2)
    ]
    if draw.random() < 0.4:
        rest += [passed, {"when": between, "do": {"log": "y", "name": "y"}, "name": "k"}]
    if draw.random() < 0.2:
        rest.append({"wait": draw.choice(("gap", f"gap - {low}")), "name": "w"})
    if draw.random() < 0.2:
        rest.append({"turn": {"angle": "$gap"}, "timeout": 1, "name": "t"})
    forward: Data = FORWARD | {
        "timeout": _time(draw, 1, 4),
        "outputs": {"closest_obstacle": "gap"},
        "name": "a",
    }
    return {
        "tree": {"sequence": [forward, *rest]},
        "requirements": {
            "r0": 'never running("x0")',
            "r1": 'never running("x1")',
            "r2": f"never $gap > {low} and $gap < {high}",
            "r3": f"never $gap < -{high}",
        },
    }


def _several(draw: Random) -> Data:
    """A topic is followed and awaited: several messages come between two ticks, or none."""
    low, high = sorted(round(draw.uniform(5, 95), 1) for _ in range(2))
    follow: Data = {**BATTERY, "field": "percentage", "as": "charge"}
    if draw.random() < 0.7:
        follow["initial"] = round(draw.uniform(0, 100), 1)
    if draw.random() < 0.6:
        follow |= {"timeout": _time(draw, 0.3, 1), "default": round(draw.uniform(0, 100), 1)}
    awaited = {
        "wait_for": {**BATTERY, "until": f"percentage < {low}"},
        "timeout": _time(draw, 0.3, 2),
        "outputs": {"percentage": "left", "voltage": "volts"},
        "name": "a",
    }
    forms = (
        {"when": f"charge > {high}", "do": {"log": "x", "name": "x"}, "name": "h"},
        {"when": f"charge > {high} and left < {low}", "do": {"log": "y", "name": "y"}, "name": "k"},
        {"when": f"volts > {low} and volts < {high}", "do": {"log": "z", "name": "z"}, "name": "l"},
    )
    rest = draw.sample(forms, 2)
    if draw.random() < 0.5:
        rest.insert(draw.choice((0, 1)), _wait(draw, "w", 0.6))
    return {
        "follow": [follow],
        "tree": {"sequence": [awaited, *rest]},
        "requirements": {
            "r0": f"never $charge > {high}",
            "r1": f"never $charge > {high} and $left < {low}",
            "r2": f'whenever succeeded("a"): $charge < {high}',
        },
    }


def _open(draw: Random) -> Data:
    """The cancel of a halted goal, which was accepted long ago or not yet, is confirmed later."""
    goal, wait_s = _goal(draw, "a"), _time(draw, 0.1, 0.5)
    if draw.random() < 0.6:
        goal |= {"acceptance_timeout": _time(draw, 0.1, 0.3), "server_timeout": 0.1, "timeout": 4}
        wait_s = _time(draw, 0.5, 1)
    either = {"parallel": [goal, {"wait": wait_s, "name": "w"}], "succeed_when": "any"}
    rest = [_wait(draw, "v", 0.3), _wait(draw, "u", 0.5)]
    is_open = 'never running("u") and open_goals > 0'
    return {
        "tree": {"sequence": [{"force": "success", "do": either}, *rest]},
        "requirements": {
            "r0": 'never running("v") and open_goals > 0',
            "r1": is_open,
            "r2": f'{is_open} and previously (accepted("a") and running("w"))',
        },
    }


def _late(draw: Random) -> Data:
    """An acceptance comes behind many messages."""
    past = "not $on"
    for value in ("$on", "not $on")[: draw.choice((1, 2))]:
        past = f"({value} and previously {past})"
    tree = _goal(draw, "a", acceptance_timeout=_time(draw, 0.5, 2))
    requirement = f'never $on and previously (not $on and previously {past}) and not accepted("a")'
    return {"follow": [POWER], "tree": tree, "requirements": {"r0": requirement}}


def _quiet(draw: Random) -> Data:
    """A topic falls silent, or its first message comes before the first tick or behind it."""
    follow: Data = {**POWER, "timeout": _time(draw, 0.3, 1)}
    if draw.random() < 0.7:
        follow["initial"] = draw.random() < 0.5
    reads: list[Data] = [{"log": "$on", "name": "l"}]
    reads.append({"when": "on", "do": {"log": "on", "name": "x"}, "else": {"log": "off"}})
    draw.shuffle(reads)
    reads.insert(draw.choice((0, 1, 1, 2)), _wait(draw, "w", 1.5))
    return {"follow": [follow], "tree": {"sequence": reads}}


def _early(draw: Random) -> Data:
    """A message may come before the first tick."""
    is_on = draw.random() < 0.5
    follow = {**POWER, "initial": is_on}
    asked = "not on" if is_on else "on"
    tree = {"when": asked, "do": {"log": "x", "name": "x"}, "else": _wait(draw, "w", 0.3)}
    return {"follow": [follow], "tree": tree | {"name": "k"}}


def _accepted(draw: Random) -> Data:
    """Only a requirement asks later whether a goal was accepted."""
    rest = {"sequence": [_wait(draw, "w", 0.5), _wait(draw, "b", 0.5)]}
    forms = (
        'never accepted("a") and running("b")',
        'whenever running("b"): accepted("a")',
        'never running("b") and not accepted("a")',
    )
    requirements = {"r0": draw.choice(forms)}
    return {"tree": {"fallback": [_goal(draw, "a"), rest]}, "requirements": requirements}


def _canceled(draw: Random) -> Data:
    """A condition or a limit cancels a goal: the same answer is awaited."""
    far = round(draw.uniform(0, 3), 2)
    forward = FORWARD | {
        "timeout": _time(draw, 0.3, 2),
        "cancel_when": f"current_distance_travelled > {far}",
        "on_cancel": draw.choice(("success", "failure")),
        "name": "a",
    }
    ways = ("canceled by timeout", "canceled by condition", "aborted")
    requirements = {f"r{n}": f'never outcome("a") = "{way}"' for n, way in enumerate(ways)}
    return {"tree": forward, "requirements": requirements | {"r3": 'never failed("a")'}}


def _endless(draw: Random) -> Data:
    """A goal without a limit, beside something with one."""
    goal: Data = TURN | {"name": "a"}
    if draw.random() < 0.7:
        goal["feedback_timeout"] = _time(draw, 0.3, 1)
    if draw.random() < 0.5:
        goal = {"sequence": [goal, _wait(draw, "w", 0.5)]}
    return {"tree": draw.choice((goal, {"fallback": [goal, {"log": "no", "name": "no"}]}))}


def _remembered(draw: Random) -> Data:
    """What a result, a message or a draw has set is read much later."""
    low, high = sorted(round(draw.uniform(0.1, 9), 2) for _ in range(2))
    first = draw.choice(
        (
            _goal(draw, "a", **FORWARD, outputs={"closest_obstacle": "gap"}),
            {"set": {"gap": "uniform(0, 10)"}, "name": "a"},
        )
    )
    first = {key: value for key, value in first.items() if key not in ("turn", "move")}
    far = {
        "when": f"gap > {low} and gap < {high}",
        "do": {"set": {"n": 1}},
        "else": {"set": {"n": 2}},
    }
    near = {"when": "n == 1", "do": {"log": "x", "name": "x"}, "name": "k"}
    other = {"when": "n == 2", "do": {"log": "y", "name": "y"}, "name": "l"}
    steps = [first, far, _wait(draw, "w", 0.5), near, _wait(draw, "v", 0.3), other]
    return {
        "tree": {"sequence": steps},
        "requirements": {
            "r0": 'never running("x") and previously running("y")',
            "r1": 'never running("v") and previously $n == 2',
        },
    }


def _sampled(draw: Random) -> Data:
    """A value that is not followed through an expression decides whether a variable is set."""
    rest, low = round(draw.uniform(1.5, 6), 2), round(draw.uniform(0.1, 1.2), 2)
    forms = (f"gap % {rest} > {low} and gap % {rest} < {low + 0.2:g}", f"sin(gap * {rest}) > 0.9")
    given = {"set": {"n": 1}, "name": "n"}
    when = {"when": draw.choice(forms), "do": {"log": "x", "name": "x"}, "else": given, "name": "h"}
    forward = FORWARD | {"timeout": 2, "outputs": {"closest_obstacle": "gap"}, "name": "a"}
    return {"tree": {"sequence": [forward, when, {"log": "$n", "name": "l"}]}}


FORMS: tuple[Callable[[Random], Data], ...] = (
    _halted,
    _guarded,
    _orders,
    _flags,
    _outcomes,
    _away,
    _watched,
    _chosen,
    _cleaned,
    _compared,
    _several,
    _open,
    _late,
    _quiet,
    _early,
    _accepted,
    _canceled,
    _endless,
    _remembered,
    _sampled,
)
