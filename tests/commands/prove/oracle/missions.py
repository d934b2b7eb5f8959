"""Random missions over the whole language: every kind of node, with small limits.

Each fourth one has a form in which the moment of an answer matters (``races``).
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from random import Random
from typing import Any, NamedTuple

from bt_mission.base.diagnostics import InputError
from bt_mission.base.yaml.dump import to_yaml
from bt_mission.language.mission import Mission
from bt_mission.sessions.load import load
from tests.commands.prove.oracle.races import race

Data = dict[str, Any]
LEAF = "tests.commands.prove.oracle.leaf:Answering"
CONSTANTS = (0.2, 0.3, 0.5, 0.9, 1.0, 2.0, 3.5, 4.0, 7.25, 20.0, 50.0, 90.0)
WHOLE = (0, 1, 2, 3, 5, 8, 901, 906)
LIMITS = (0.15, 0.2, 0.3, 0.5, 0.8, 1.0, 2.0)
BATTERY = {"topic": "battery_state", "type": "sensor_msgs/msg/BatteryState"}
SCAN = {"topic": "scan", "type": "sensor_msgs/msg/LaserScan"}
MOTORS = {"topic": "motors_on", "type": "std_msgs/msg/Bool"}
COUNTED = {"topic": "counted", "type": "std_msgs/msg/Int32"}


class GoalKind(NamedTuple):
    """A goal: its node, and the types of the fields of its result and feedback."""

    node: Data
    result: dict[str, str]
    feedback: dict[str, str]


COUNT = {"name": "/count", "type": "example_interfaces/action/Fibonacci", "goal": {"order": 5}}
GOALS = (
    GoalKind(
        {"explore_forward": {"fwd_velocity": 0.2, "stopping_distance": 0.5}},
        {
            "closest_obstacle": "float",
            "total_distance_travelled": "float",
            "closest_obstacle_angle": "float",
            "error_code": "int",
        },
        {"current_distance_travelled": "float", "closest_obstacle": "float"},
    ),
    GoalKind(
        {"turn": {"angle": 90}},
        {"angle_turned": "float", "error_code": "int", "error_msg": "text"},
        {"current_angle": "float", "remaining_angle": "float"},
    ),
    GoalKind(
        {"find_colour": {"colour": "blue"}},
        {"share": "float", "angle": "float", "error_code": "int"},
        {"share": "float"},
    ),
    GoalKind(
        {"camera_sweep": {"sweep_angle": 90, "image_count": 2}},
        {"image_path": "text", "image_paths": "texts", "error_code": "int"},
        {"current_image": "int"},
    ),
    GoalKind(
        {"record_distance": {"seconds": 5}},
        {"status": "bool", "total_dist": "float"},
        {"current_dist": "float"},
    ),
    GoalKind(
        {"move": {"secs": 1, "linear_velocity": 0.1}}, {"status": "text", "error_code": "int"}, {}
    ),
    GoalKind({"action": COUNT}, {"sequence": "numbers"}, {"sequence": "numbers"}),
)
SENT_TO_TURN = ("{}", "clamp({}, -90, 90)", "90 if {} > 1 else -90", "{} / 2")


def random_mission(seed: int) -> tuple[Data, str, Mission]:
    """Return a random mission: as data, as text and loaded."""
    attempt = 0
    while True:
        draw = Random(f"{seed}/{attempt}")
        data = {"mission": "m"} | race(draw) if seed % 4 == 3 else _Writer(draw).mission()
        text = to_yaml(data)
        try:
            return data, text, load(text)
        except InputError:
            attempt += 1


class _Writer:
    def __init__(self, draw: Random) -> None:
        self._draw = draw
        self._count = 0
        self._names: list[str] = []
        self._leaves: list[str] = []
        self._goals: list[str] = []
        self._types: dict[str, str] = {}
        self._inputs: Data = {}
        self._followed: set[str] = set()
        self._fresh: tuple[str, ...] = ()
        """The variables that the leaf before writes."""
        self._trees: Data = {}

    def mission(self) -> Data:
        """Return a mission as data."""
        draw = self._draw
        self._inputs = {"legs": draw.choice(WHOLE), "speed": draw.choice(CONSTANTS)}
        self._types = {"legs": "int", "speed": "float"}
        follow = self._follows() if draw.random() < 0.35 else []
        if draw.random() < 0.15:
            self._named_tree()
        tree = self._node(draw.randint(3, 9))
        data: Data = {"mission": "m", "inputs": self._inputs}
        if follow:
            data["follow"] = follow
        if self._trees:
            data["trees"] = self._trees
        requirements = {
            f"r{number}": self._requirement() for number in range(draw.choice((0, 1, 2, 3)))
        }
        if requirements:
            data["requirements"] = requirements
        data["tree"] = tree
        return data

    # ---- heads ------------------------------------------------------------------------------

    def _follows(self) -> list[Data]:
        draw = self._draw
        rows = [
            ({**BATTERY, "field": "percentage"}, "charge", "float", 60.0),
            ({**BATTERY, "field": "voltage"}, "volts", "float", 12.0),
            ({**MOTORS, "field": "data"}, "powered", "bool", True),
            ({**COUNTED, "field": "data"}, "counted", "int", 3),
            ({**SCAN, "field": "ranges"}, "ranges", "numbers", [1.0]),
        ]
        follows = []
        for settings, name, kind, value in draw.sample(rows, draw.choice((1, 1, 2))):
            entry: Data = {**settings, "as": name}
            if draw.random() < 0.6:
                entry["initial"] = value
            if draw.random() < 0.4:
                entry["timeout"] = draw.choice((0.5, 1.0, 2.0))
            if draw.random() < 0.6:
                entry["default"] = value if draw.random() < 0.5 else self._other(value)
            follows.append(entry)
            self._types[name] = kind
            self._followed.add(name)
        return follows

    def _other(self, value: Any) -> Any:
        match value:
            case bool():
                return not value
            case int():
                return value + 1
            case float():
                return self._draw.choice(CONSTANTS)
        return []

    def _named_tree(self) -> None:
        outer, self._types = self._types, {"given": "float"}
        body = self._node(self._draw.randint(2, 4))
        written = [name for name in self._types if name not in outer and name != "given"]
        kinds = {"float": "number", "int": "integer", "bool": "bool", "text": "text"}
        outputs = {
            name: kinds[self._types[name]] for name in written[:1] if self._types[name] in kinds
        }
        self._tree_types = {name: self._types[name] for name in outputs}
        self._trees["part"] = {"inputs": {"given": 1.0}, "outputs": outputs, "do": body}
        self._trees["part"] = {k: v for k, v in self._trees["part"].items() if v}
        self._types = outer

    # ---- nodes ------------------------------------------------------------------------------

    def _named(self, node: Data) -> Data:
        self._count += 1
        node["name"] = f"n{self._count}"
        self._names.append(node["name"])
        return node

    def _node(self, size: int) -> Data:
        draw = self._draw
        if size <= 1:
            return self._leaf()
        makers: list[Callable[[int], Data]] = [
            *[self._probe] * 6,
            self._sequence,
            self._sequence,
            self._fallback,
            self._parallel,
            self._when,
            self._decorator,
            self._decorator,
            self._choose,
        ]
        return self._named(draw.choice(makers)(size))

    def _children(self, size: int) -> list[Data]:
        count = self._draw.randint(2, min(4, max(2, size)))
        return [self._node(max(1, (size - 1) // count)) for _ in range(count)]

    def _probe(self, size: int) -> Data:
        """A leaf that writes a variable, and what reads it."""
        draw, before = self._draw, set(self._types)
        while True:
            source = draw.choice(
                (
                    self._goal,
                    self._goal,
                    self._goal,
                    self._wait_for,
                    self._set,
                    self._python,
                    self._service,
                )
            )
            leaf = self._named(source())
            if set(self._types) - before:
                break
        self._leaves.append(leaf["name"])
        children = [leaf]
        self._fresh = tuple(name for name in self._types if name not in before)
        form = draw.random()
        if form < 0.4:
            children.append(self._named(self._when(max(2, size - 2))))
        elif form < 0.6:
            check = self._named({"check": self._condition()})
            children.append(self._named({"fallback": [check, self._node(max(1, size - 3))]}))
        elif form < 0.8:
            children.append(self._node(max(1, size - 2)))
        else:
            body = self._named(
                {
                    "sequence": [
                        self._named({"force": "success", "do": leaf}),
                        self._node(max(1, size - 3)),
                    ]
                }
            )
            return {"repeat": {"until": self._condition(), "count": 3}, "do": body}
        self._fresh = ()
        if draw.random() < 0.4:
            children[0] = self._named({"force": "success", "do": leaf})
        return {"sequence": children}

    def _sequence(self, size: int) -> Data:
        node: Data = {"sequence": self._children(size)}
        return node | ({"memory": False} if self._draw.random() < 0.1 else {})

    def _fallback(self, size: int) -> Data:
        node: Data = {"fallback": self._children(size)}
        return node | ({"memory": False} if self._draw.random() < 0.1 else {})

    def _parallel(self, size: int) -> Data:
        draw = self._draw
        node: Data = {"parallel": self._children(size)}
        node["succeed_when"] = draw.choice(("all", "any"))
        if draw.random() < 0.4:
            node["fail_when"] = "impossible"
        if draw.random() < 0.2:
            node["rest"] = "finish"
        return node

    def _choose(self, size: int) -> Data:
        children = self._children(size)
        node: Data = {"choose": children}
        if self._draw.random() < 0.3:
            node["weights"] = [self._draw.choice((0, 1, 3)) for _ in children[1:]] + [1]
        return node

    def _when(self, size: int) -> Data:
        node: Data = {"when": self._condition(), "do": self._node(max(1, size // 2))}
        if self._draw.random() < 0.5:
            node["else"] = self._node(max(1, size // 3))
        return node

    def _decorator(self, size: int) -> Data:
        draw = self._draw
        if draw.random() < 0.1:
            return self._for_each(size)
        body = self._node(size - 1)
        makers: list[Callable[[], Data]] = [
            lambda: {"repeat": {"count": draw.choice((2, 3, 12))}, "do": body},
            lambda: {"repeat": {"until": self._condition(), **self._at_most()}, "do": body},
            lambda: {"repeat": {"while": self._condition(), "count": 3}, "do": body},
            lambda: {"retry": {"attempts": draw.choice((2, 3)), **self._pause()}, "do": body},
            lambda: {"timeout": draw.choice(LIMITS), "do": body},
            lambda: {"guard": self._condition(), "do": body},
            lambda: {
                "finally": {"timeout": draw.choice((0.3, 1.0))},
                "do": body,
                "then": self._leaf(),
            },
            lambda: {"invert": body},
            lambda: {"force": draw.choice(("success", "failure")), "do": body},
        ]
        return draw.choice(makers)()

    def _at_most(self) -> Data:
        return {"count": self._draw.choice((2, 4))} if self._draw.random() < 0.5 else {}

    def _pause(self) -> Data:
        return {"pause": self._draw.choice((0.1, 0.5))} if self._draw.random() < 0.5 else {}

    def _for_each(self, size: int) -> Data:
        draw = self._draw
        lists = [name for name, kind in self._types.items() if kind in ("numbers", "texts")]
        if lists and draw.random() < 0.7:
            over: Any = f"${draw.choice(lists)}"
            kind = self._types[over[1:]].removesuffix("s").replace("number", "float")
        else:
            over, kind = [draw.choice(CONSTANTS) for _ in range(draw.choice((0, 1, 2)))], "float"
        item = f"item{self._count}"
        self._types[item] = kind
        self._followed.add(item)
        body = self._node(size - 1)
        del self._types[item]
        return {"for_each": {item: over}, "do": body}

    # ---- leaves -----------------------------------------------------------------------------

    def _leaf(self) -> Data:
        makers: list[Callable[[], Data]] = [
            *[self._goal] * 5,
            self._service,
            self._publish,
            *[self._wait_for] * 2,
            *[self._check] * 2,
            *[self._set] * 2,
            self._wait,
            *[self._log] * 2,
            self._python,
        ]
        if self._trees:
            makers += [self._tree] * 3
        node = self._named(self._draw.choice(makers)())
        self._leaves.append(node["name"])
        return node

    def _goal(self) -> Data:
        draw = self._draw
        kind = draw.choice(GOALS)
        node: Data = copy.deepcopy(kind.node)
        numbers = self._of("float")
        if "turn" in node and numbers and draw.random() < 0.2:
            node["turn"] = {"angle": draw.choice(SENT_TO_TURN).format(f"${draw.choice(numbers)}")}
        if draw.random() < 0.93:
            node["timeout"] = draw.choice((*LIMITS, 5.0, 10.0))
            if numbers and draw.random() < 0.1:
                node["timeout"] = f"0.2 + clamp(abs(${draw.choice(numbers)}), 0, 2)"
        for name, share in (
            ("server_timeout", 0.7),
            ("acceptance_timeout", 0.5),
            ("cancel_timeout", 0.5),
            ("feedback_timeout", 0.15),
        ):
            if draw.random() < share:
                node[name] = draw.choice(LIMITS)
        if kind.feedback and draw.random() < 0.3:
            name, of = draw.choice(list(kind.feedback.items()))
            node["cancel_when"] = self._about(name, of)
            if draw.random() < 0.5:
                node["on_cancel"] = "success"
        if "action" in node:
            node["uses"] = draw.choice(([], "base"))
        if draw.random() < 0.6:
            node["outputs"] = self._outputs(kind.result)
        self._goals.append(f"n{self._count + 1}")
        return node

    def _outputs(self, fields: dict[str, str]) -> dict[str, str]:
        outputs = {}
        for name in self._draw.sample(list(fields), min(len(fields), self._draw.choice((1, 1, 2)))):
            outputs[name] = self._new(fields[name])
        return outputs

    def _new(self, kind: str) -> str:
        """Return a variable to write: a new one, or one of this type."""
        written = [
            name for name in self._of(kind) if name not in (*self._inputs, *self._followed, "given")
        ]
        if written and self._draw.random() < 0.3:
            return self._draw.choice(written)
        name = f"{kind[0]}{len(self._types)}"
        self._types[name] = kind
        return name

    def _of(self, kind: str) -> list[str]:
        return [name for name, known in self._types.items() if known == kind]

    def _service(self) -> Data:
        draw = self._draw
        node: Data = {"service": {"name": "stop", "type": "std_srvs/srv/Trigger"}}
        fields = {"message": "text"}
        if draw.random() < 0.3:
            request = {"a": 1, "b": 2}
            node = {
                "service": {
                    "name": "add",
                    "type": "example_interfaces/srv/AddTwoInts",
                    "request": request,
                }
            }
            fields = {"sum": "int"}
        node |= {"timeout": draw.choice(LIMITS), "server_timeout": draw.choice(LIMITS)}
        if draw.random() < 0.6:
            node["outputs"] = self._outputs(fields)
        return node

    def _publish(self) -> Data:
        message = {"topic": "lamp", "type": "std_msgs/msg/Bool", "message": {"data": True}}
        return {"publish": message, "readers": self._draw.choice((0, 1)), "server_timeout": 0.3}

    def _wait_for(self) -> Data:
        draw = self._draw
        settings, fields = draw.choice(
            (
                (BATTERY, {"percentage": "float", "voltage": "float"}),
                (MOTORS, {"data": "bool"}),
                (COUNTED, {"data": "int"}),
            )
        )
        name = draw.choice(list(fields))
        node: Data = {"wait_for": {**settings, "until": self._about(name, fields[name])}}
        if draw.random() < 0.9:
            node["timeout"] = draw.choice(LIMITS)
        if draw.random() < 0.6:
            node["outputs"] = self._outputs(fields)
        return node

    def _check(self) -> Data:
        return {"check": self._condition()}

    def _set(self) -> Data:
        draw = self._draw
        numbers = self._of("float")
        source = f"${draw.choice(numbers)}"
        kind, value = draw.choice(
            (
                ("float", "uniform(1, 5)"),
                ("float", "uniform(0, 1) * 10"),
                ("float", f"choice({', '.join(map(str, draw.sample(CONSTANTS, 5)))})"),
                ("float", f"{source} + 1"),
                ("float", f"abs({source})"),
                ("float", f"min({source}, 2.0)"),
                ("float", source),
                ("int", draw.choice(WHOLE)),
                ("int", "choice(1, 2, 3, 4, 5, 6)"),
                ("bool", f"{source} > {draw.choice(CONSTANTS)}"),
                ("text", "'blue'"),
            )
        )
        return {"set": {self._new(kind): value}}

    def _wait(self) -> Data:
        draw, numbers = self._draw, self._of("float")
        if draw.random() < 0.2:
            return {"wait": "uniform(0.1, 1.5)"}
        if numbers and draw.random() < 0.2:
            return {"wait": f"clamp(${draw.choice(numbers)}, 0.1, 2)"}
        return {"wait": draw.choice(LIMITS)}

    def _log(self) -> Data:
        return {"log": f"${self._draw.choice(list(self._types))}"}

    def _python(self) -> Data:
        node: Data = {"python": LEAF}
        if self._draw.random() < 0.7:
            fields = {"amount": "float", "flag": "bool", "word": "text", "number": "int"}
            node["outputs"] = self._outputs(fields)
        return node

    def _tree(self) -> Data:
        numbers = self._of("float")
        settings: Data = {"name": "part"}
        if numbers and self._draw.random() < 0.6:
            settings["inputs"] = {"given": f"${self._draw.choice(numbers)}"}
        node: Data = {"tree": settings}
        for name, kind in self._tree_types.items():
            node["outputs"] = {name: self._new(kind)}
        return node

    # ---- conditions -------------------------------------------------------------------------

    def _condition(self) -> str:
        """Return a condition on variables, preferably not on inputs alone."""
        names = [name for name in self._types if name not in self._inputs] or list(self._types)
        fresh = [name for name in self._fresh if name in self._types]
        if fresh and self._draw.random() < 0.8:
            names = fresh
        name = self._draw.choice(names)
        text = self._about(f"${name}", self._types[name])
        if self._draw.random() < 0.15:
            other = self._draw.choice(names)
            joint = self._draw.choice((" and ", " or "))
            return f"({text}){joint}({self._about(f'${other}', self._types[other])})"
        return text

    def _about(self, name: str, kind: str) -> str:
        draw = self._draw
        low, high = sorted(draw.sample(CONSTANTS, 2))
        first, second = sorted(draw.sample(WHOLE, 2))
        match kind:
            case "float":
                forms = [
                    f"{name} > {low}",
                    f"{name} <= {low}",
                    f"{name} > {low} and {name} < {high}",
                    f"{name} > {low} and {name} < {high}",
                    f"{low} < {name} < {low + 0.1:g}",
                    f"{name} == {low}",
                    f"{name} != {low}",
                    f"abs({name}) < {low}",
                    f"{name} + 1 < {low}",
                    f"2 * {name} >= {low}",
                    f"{name} < {low} or {name} > {high}",
                    f"{name} < -{low}",
                ]
            case "int":
                forms = [
                    f"{name} == {first}",
                    f"{name} != {first}",
                    f"{name} > {first} and {name} < {second}",
                    f"{name} >= {second}",
                    f"{name} % 2 == 1",
                ]
            case "bool":
                forms = [name, f"not {name}"]
            case "text":
                forms = [f"{name} == 'blue'", f"{name} != 'blue'", f"{name} == ''"]
            case "texts":
                forms = [f"len({name}) > {draw.choice((0, 1, 2))}", f"len({name}) == 1"]
            case _:
                forms = [
                    f"len({name}) > {draw.choice((0, 1, 2))}",
                    f"len({name}) > 0 and {name}[0] > {low}",
                    f"{name}[0] < {low}",
                ]
        return draw.choice(forms)

    def _requirement(self) -> str:
        draw, names = self._draw, self._names
        node, other = draw.choice(names), draw.choice(names)
        forms = [
            f'never running("{node}")',
            f'never succeeded("{node}")',
            f'never failed("{node}")',
            f'never running("{node}") and running("{other}")',
            f'whenever running("{node}"): previously succeeded("{other}")',
            f'whenever failed("{node}"): previously failed("{other}")',
            f'always count(starts(running("{node}"))) <= {draw.choice((1, 2))}',
            f'eventually succeeded("{node}")',
            f'not failed("{node}") until running("{other}")',
            "never open_goals > 1",
            "never goals_at_base > 1",
        ]
        if self._goals:
            goal = draw.choice(self._goals)
            forms += [
                f'never accepted("{goal}") and running("{other}")',
                f'whenever accepted("{goal}"): running("{other}")',
                f'never outcome("{goal}") = aborted',
                f'whenever running("{node}"): outcome("{goal}") = succeeded',
            ]
        variables = [name for name in self._types if name not in self._inputs]
        for name in draw.sample(variables, min(2, len(variables))):
            if self._types[name] in ("float", "int", "bool"):
                forms += [f"never {self._about(f'${name}', self._types[name])}"]
        return draw.choice(forms)
