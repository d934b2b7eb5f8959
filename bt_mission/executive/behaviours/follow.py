"""Variables that follow topics. They are updated at the start of each tick."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from py_trees.behaviour import Behaviour

from bt_mission.base.stamps import NS
from bt_mission.executive.behaviours.decorators import Subtree
from bt_mission.executive.behaviours.runtime import (
    MissionFailure,
    Runtime,
    Scope,
    placed,
    read_field,
)
from bt_mission.language.expressions.values import NoValue
from bt_mission.language.follow import Follow

FIRST_VALUE_S = 5.0
"""The shortest time that a mission waits for the first value of each variable, s."""

QUIET_NS = NS
"""The time after which the wait is logged, ns."""

LOOK_NS = NS // 4
"""The interval at which the graph is searched for a latched publisher, ns."""


class FollowedVariable:
    """Sets one variable to the newest value of a field of a topic.

    A message that arrives changes nothing before the next :meth:`update`.

    Args:
        follow: The field that it follows.
        scope: The scope of the variable.
        runtime: Clock and subscriber.

    Raises:
        MissionFailure: A type is not installed, or the topic has another type.
    """

    def __init__(self, follow: Follow, scope: Scope, runtime: Runtime) -> None:
        self.place = f"{follow.file}:{follow.line}:{follow.column}"
        self.name = follow.variable
        self._settings = follow.settings
        self._values = scope.values
        self._runtime = runtime
        self._received_ns: int | None = None
        self._unread: Any = None
        self._look_ns = 0
        with placed(self.place):
            self._topic = runtime.subscriber(self._settings.topic, self._settings.type)
        initial = self._settings.initial
        missing = NoValue(f"no message of {self._topic.name} yet")
        self._values[self.name] = missing if initial is None else initial
        self._topic.listen(self._hear)

    @property
    def topic(self) -> str:
        """The full name of its topic."""
        return self._topic.name

    @property
    def why_missing(self) -> str:
        """Why it has no value, with what the graph shows; empty if it has one."""
        value = self._values[self.name]
        if not isinstance(value, NoValue):
            return ""
        return value.reason + (f", {self._topic.why_silent()}" if self._received_ns is None else "")

    @property
    def remedy(self) -> str:
        """The setting that lets a mission begin without its first value."""
        if self._received_ns is None:
            return "start its publisher, or give it an 'initial' value"
        return "give it a 'default'"

    @property
    def limit_s(self) -> float:
        """The limit of the wait for its first value, s."""
        return max(FIRST_VALUE_S, self._settings.timeout or 0.0)

    @property
    def timeout_s(self) -> float | None:
        """The age at which its newest message is too old, s; None for no such age."""
        return self._settings.timeout

    @property
    def due_ns(self) -> int | None:
        """The instant at which its newest message is too old; None where it never is."""
        if self._received_ns is None or self._settings.timeout is None:
            return None
        return self._received_ns + math.ceil(self._settings.timeout * NS)

    def is_of(self, follow: Follow, scope: Scope) -> bool:
        """Return whether it follows this field for these variables."""
        return self._settings == follow.settings and self._values is scope.values

    def leave(self) -> None:
        """Follow the topic no more."""
        self._topic.leave(self._hear)

    def is_variable_of(self, other: FollowedVariable) -> bool:
        """Return whether both set the same variable."""
        return self.name == other.name and self._values is other._values

    def forget(self) -> None:
        """Remove the variable."""
        self._values.pop(self.name, None)

    def update(self) -> None:
        """Take the newest message in, or note that it is too old."""
        now_ns, timeout_s = self._runtime.now_ns, self._settings.timeout
        if now_ns >= self._look_ns:
            self._look_ns = now_ns + LOOK_NS
            self._topic.look_around()
        if self._unread is not None:
            message, self._unread = self._unread, None
            self._take(message)
        if self._received_ns is None or timeout_s is None:
            return
        if now_ns - self._received_ns >= timeout_s * NS:
            self._set_missing(f"no message of {self._topic.name} for {timeout_s:g} s")

    def _hear(self, message: Any) -> None:
        self._unread, self._received_ns = message, self._runtime.now_ns

    def _take(self, message: Any) -> None:
        field, topic = self._settings.field, self._topic.name
        try:
            value = read_field(message, field)
        except AttributeError:
            self._set_missing(f"messages of {topic} have no field '{field}'")
            return
        if isinstance(value, float) and math.isnan(value):
            self._set_missing(f"'{field}' of {topic} is not a number")
        else:
            self._values[self.name] = value

    def _set_missing(self, reason: str) -> None:
        default = self._settings.default
        value = NoValue(reason) if default is None else default
        if self._values.get(self.name) != value:  # the same value: no condition is evaluated again
            self._values[self.name] = value


def scopes_of(root: Behaviour, scope: Scope) -> list[Scope]:
    """Return the variables of a mission, and those of each named tree below a root."""
    return [scope, *(node.inner for node in root.iterate() if isinstance(node, Subtree))]


class FollowedVariables:
    """All variables of a mission that follow topics, those of its named trees included.

    Args:
        scopes: The variables of the mission, and of each named tree.
        runtime: Its clock and subscribers.
        before: Those of the version of the mission that ran before. Common variables continue.
    """

    def __init__(
        self,
        scopes: Iterable[Scope],
        runtime: Runtime,
        before: FollowedVariables | None = None,
    ) -> None:
        self._runtime = runtime
        self.variables: list[FollowedVariable] = []
        known = [] if before is None else before.variables
        for inner in scopes:
            for follow in inner.followed:
                same = next((entry for entry in known if entry.is_of(follow, inner)), None)
                self.variables.append(same or FollowedVariable(follow, inner, runtime))
        self._awaited = [] if before is not None and before.are_known else list(self.variables)
        self._since_ns: int | None = None
        self._is_logged = False

    @property
    def are_known(self) -> bool:
        """Whether each variable has had a value."""
        return not self._awaited

    def leave_others(self, before: FollowedVariables) -> None:
        """Follow no more what only an earlier version of the mission follows."""
        for entry in before.variables:
            if entry not in self.variables:
                entry.leave()
                if not any(map(entry.is_variable_of, self.variables)):
                    entry.forget()

    @property
    def limits_due(self) -> list[tuple[FollowedVariable, int]]:
        """The instants at which a message is too old, or a first one takes too long."""
        instants = [
            (variable, due_ns)
            for variable in self.variables
            if (due_ns := variable.due_ns) is not None
        ]
        if self._since_ns is not None:
            instants += [
                (entry, self._since_ns + math.ceil(entry.limit_s * NS))
                for entry in self._awaited
                if entry.why_missing
            ]
        return instants

    def update(self) -> None:
        """Update all variables. Their values last until the next call.

        It is also called in a pause, since goals under way keep their conditions.
        """
        for variable in self.variables:
            variable.update()

    def are_there(self) -> bool:
        """Return whether each variable has had a value. A mission begins only then.

        Called until it is true.

        Raises:
            MissionFailure: The first value of a variable takes too long.
        """
        if not self._awaited:
            return True
        self._awaited = [awaited for awaited in self._awaited if awaited.why_missing]
        if not self._awaited:
            return True
        now_ns = self._runtime.now_ns
        self._since_ns = now_ns if self._since_ns is None else self._since_ns
        waited_ns = now_ns - self._since_ns
        for awaited in self._awaited:
            if waited_ns >= awaited.limit_s * NS:
                raise MissionFailure(
                    f"{awaited.place}: '{awaited.name}' has no value after {awaited.limit_s:g} s: "
                    f"{awaited.why_missing}; {awaited.remedy}"
                )
        if waited_ns >= QUIET_NS and not self._is_logged:
            self._is_logged = True
            missing = dict.fromkeys(awaited.why_missing for awaited in self._awaited)
            self._runtime.log(f"the mission waits to begin: {'; '.join(missing)}")
        return False
