"""A mission's tree on a clock that the test moves, against servers that the test plays."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

from py_trees.behaviour import Behaviour

from bt_mission.executive.behaviours.builder import build_tree
from bt_mission.executive.behaviours.runtime import Scope
from bt_mission.executive.executive import Executive
from bt_mission.executive.goals.ledger import Ledger
from bt_mission.executive.revision import RevisionPlan
from bt_mission.executive.trace import Trace
from bt_mission.language.mission import Mission
from bt_mission.language.revision import Revision
from bt_mission.sessions.load import load

S = 1_000_000_000
TICK_NS = S // 20


def message(**fields: Any) -> Any:
    """Something that looks like a ROS message with these fields."""
    return SimpleNamespace(get_fields_and_field_types=lambda: dict.fromkeys(fields, ""), **fields)


class ScriptedService:
    """A client of a service whose server answers when the test says so."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.ready = True
        self.requests: list[Any] = []
        self.forgotten = 0
        self._callbacks: list[Callable[[Any], None]] = []

    def is_ready(self) -> bool:
        return self.ready

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        return fields

    def call(self, request: Any, on_answer: Callable[[Any], None]) -> Callable[[], None]:
        self.requests.append(request)
        self._callbacks.append(on_answer)

        def forget() -> None:
            self.forgotten += 1

        return forget

    def answer(self, call: int = -1, **fields: Any) -> None:
        """Answer a call, by default the newest."""
        self._callbacks[call](message(**fields))


class ScriptedTopic:
    """A topic on which the test publishes."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.latched: Any = None
        self.listeners: list[Callable[[Any], None]] = []

    def listen(self, listener: Callable[[Any], None]) -> None:
        self.listeners.append(listener)
        if self.latched is not None:
            listener(self.latched)

    def leave(self, listener: Callable[[Any], None]) -> None:
        self.listeners = [known for known in self.listeners if known != listener]

    def look_around(self) -> None:
        pass

    def why_silent(self) -> str:
        return "it has no publisher"

    def publish(self, **fields: Any) -> None:
        for listener in tuple(self.listeners):
            listener(message(**fields))


class ScriptedSpeech:
    """A topic on which a mission publishes, with as many subscriptions as the test says."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.readers = 1
        self.published: list[Any] = []

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        return fields

    def count_readers(self) -> int:
        return self.readers

    def publish(self, message: Any) -> None:
        self.published.append(message)


class Play:
    """An executive without ROS."""

    def __init__(self, text: str, server_type: Callable[[str], Any], goal_seed: str = "") -> None:
        mission = self.mission = load(text)
        self.now_ns = S
        self.servers: dict[str, Any] = {}
        self.logged: list[str] = []
        self.warned: list[str] = []
        self.services: dict[str, ScriptedService] = {}
        self.topics: dict[str, ScriptedTopic] = {}
        self.speeches: dict[str, ScriptedSpeech] = {}
        self._server_type = server_type
        self.scope = Scope(dict(mission.inputs), mission.seed)
        self.ledger = Ledger(goal_seed or mission.seed, 3 * S)
        self.trace = Trace()
        self.root = build_tree(mission, self.scope)
        self.executive = Executive(self.root, self, self.trace)

    def revise(self, text: str, *, dry_run: bool = False, keep_goals: bool = False) -> Revision:
        """Continue with another version of the mission."""
        after = load(text)

        def accept(mission: Mission) -> None:
            self.mission = mission

        plan = RevisionPlan(self.executive, self, self.mission, after, keep_goals=keep_goals)
        plan.build()
        revision = plan.preview() if dry_run else plan.apply(lambda _: None, accept)
        self.root = self.executive.root
        return revision

    def goal_client(self, action: str, type_name: str) -> Any:
        name = f"/{action.removeprefix('/')}"  # there is no namespace here
        if name not in self.servers:
            self.servers[name] = self._server_type(name)
        return self.servers[name]

    def service_client(self, service: str, type_name: str) -> ScriptedService:
        return self.services.setdefault(service, ScriptedService(service))

    def subscriber(self, topic: str, type_name: str) -> ScriptedTopic:
        return self.topics.setdefault(topic, ScriptedTopic(topic))

    def publisher(self, topic: str, type_name: str) -> ScriptedSpeech:
        return self.speeches.setdefault(topic, ScriptedSpeech(topic))

    def warn(self, text: str) -> None:
        self.warned.append(text)

    def log(self, text: str) -> None:
        self.logged.append(text)

    def tick(self, count: int = 1) -> str:
        """Tick; gives the statuses of all nodes from the root down, one letter each."""
        for _ in range(count):
            self.now_ns += TICK_NS
            self.executive.tick()
        return self.statuses

    @property
    def statuses(self) -> str:
        def walk(node: Behaviour) -> str:
            return node.status.value[0] + "".join(walk(child) for child in node.children)

        return walk(self.root)

    @property
    def status(self) -> str:
        return str(self.executive.status)

    @property
    def turn(self) -> Any:
        return self.servers["/turn"]
