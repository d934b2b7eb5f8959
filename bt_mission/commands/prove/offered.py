"""The clients that a mission's leaves talk to, whose counterparts may answer anything."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.commands.prove.answers import AnswerSet
from bt_mission.commands.prove.choices import Choices
from bt_mission.commands.prove.clients import Draw, Service, Speech, Topic
from bt_mission.commands.prove.goal_servers import GoalServer, ServedGoal
from bt_mission.commands.prove.values import ValueCases
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.client_leaves import PublishLeaf, ServiceLeaf, WaitFor
from bt_mission.executive.behaviours.evaluator import Evaluator
from bt_mission.language.mission import Mission


class OfferedClients:
    """Makes the clients of a mission, one for each name; a part of ``Runtime``.

    Args:
        mission: Whose leaves use them.
        answers: Which answers are considered.
        choices: Decides.
        cases: The values of messages.
    """

    def __init__(
        self, mission: Mission, answers: AnswerSet, choices: Choices, cases: ValueCases
    ) -> None:
        self.mission, self.answers, self.choices, self.cases = mission, answers, choices, cases
        self._used: list[Any] = []
        """The servers that the last step has used."""
        self._goal_servers: dict[str, GoalServer] = {}
        self._services: dict[str, Service] = {}
        self._topics: dict[str, Topic] = {}
        self._speeches: dict[str, Speech] = {}
        self._evaluators: dict[Behaviour, Evaluator] = {}
        self._services_called: list[ServiceLeaf] = []
        self._waits: list[WaitFor] = []

    @property
    def goal_servers(self) -> tuple[GoalServer, ...]:
        """The servers of the actions."""
        return tuple(self._goal_servers.values())

    @property
    def services(self) -> tuple[Service, ...]:
        """The services that the mission calls."""
        return tuple(self._services.values())

    @property
    def topics(self) -> tuple[Topic, ...]:
        """The topics that the mission reads."""
        return tuple(self._topics.values())

    @property
    def publishers(self) -> tuple[Speech, ...]:
        """The topics on which the mission publishes."""
        return tuple(self._speeches.values())

    def goal_client(self, action: str, type_name: str) -> GoalServer:
        """The client of an action."""
        name = full_name(action)
        if name not in self._goal_servers:
            self._goal_servers[name] = GoalServer(
                name,
                type_name,
                self.choices,
                self.answers,
                self.cases,
                lambda leaf: self._evaluators[leaf],
                self._used.append,
            )
        return self._goal_servers[name]

    def service_client(self, service: str, type_name: str) -> Service:
        """The client of a service."""
        name = full_name(service)
        if name not in self._services:
            self._services[name] = Service(
                name,
                type_name,
                self.choices,
                self.answers,
                self.cases,
                lambda: self._services_called,
                lambda leaf: self._evaluators[leaf],
                self._used.append,
            )
        return self._services[name]

    def subscriber(self, topic: str, type_name: str) -> Topic:
        """The messages of a topic."""
        name = full_name(topic)
        if name not in self._topics:
            follows = [
                follow
                for tree in self.mission.all_trees
                for follow in tree.follow
                if full_name(follow.settings.topic) == name
            ]
            self._topics[name] = Topic(
                name,
                type_name,
                self.answers,
                self.cases,
                self._waiting,
                lambda leaf: self._evaluators[leaf],
                follows,
            )
        return self._topics[name]

    def publisher(self, topic: str, type_name: str) -> Speech:
        """The publisher of a topic."""
        name = full_name(topic)
        if name not in self._speeches:
            self._speeches[name] = Speech(name, type_name, self.choices, self.answers)
        return self._speeches[name]

    def log(self, text: str) -> None:
        """Nobody watches."""

    def warn(self, text: str) -> None:
        """Nobody watches."""

    def draw(self, name: str) -> Draw:
        """Return the generator of a node or of one of its conditions."""
        node = self.mission.node_at(name.partition("/")[0])
        label = f"'{node.label}'" if node is not None else name
        return Draw(label, self.choices, partial(self.cases.of_draw, node))

    def subscriptions_wanted(self, publisher: Speech) -> int:
        """Return for how many subscriptions a leaf waits at most before it publishes."""
        written = [
            values.node
            for leaf, values in self._evaluators.items()
            if isinstance(leaf, PublishLeaf)
        ]
        return max(
            int(node.readers) for node in written if full_name(node.ros_name) == publisher.name
        )

    @property
    def open_at_parts(self) -> dict[str, list[tuple[str, str]]]:
        """The open goals at each part, as its servers see it: their actions and leaves."""
        parts: dict[str, list[tuple[str, str]]] = {}
        for server in self._goal_servers.values():
            for served in server.goals:
                for part in self._moved_parts(served.leaf) if served.is_live else ():
                    parts.setdefault(part, []).append((server.name, served.goal.owner))
        return parts

    def _moved_parts(self, leaf: ActionLeaf | None) -> Iterable[str]:
        return () if leaf is None else self._evaluators[leaf].node.known_parts or ()

    def _waiting(self, topic: Topic) -> list[WaitFor]:
        return [
            node
            for node in self._waits
            if node.status is Status.RUNNING
            and full_name(self._evaluators[node].node.ros_name) == topic.name
        ]

    @property
    def delayed(self) -> list[str]:
        """The servers whose answers might have been later than they were."""
        return [client.name for client in self._answering if client.is_cut]

    @property
    def _answering(self) -> list[GoalServer | Service]:
        return [*self._goal_servers.values(), *self._services.values()]

    @property
    def owing(self) -> list[ServedGoal | Service]:
        """Goals and services that owe an answer, which comes before nothing more happens."""
        served: list[ServedGoal | Service] = [
            entry for server in self._goal_servers.values() for entry in server.goals
        ]
        served += self._services.values()
        return [entry for entry in served if entry.is_owed]


def full_name(name: str) -> str:
    """Return the name of a topic, service or action with the slash at its beginning."""
    return name if name.startswith("/") else f"/{name}"
