"""A behaviour that a user has written in Python, wired to the variables of a mission."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.base.clock_watch import CONTAINED, LeftError
from bt_mission.base.diagnostics import describe
from bt_mission.base.errors import BtMissionError, described, place_of
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.behaviours import snapshot
from bt_mission.executive.behaviours.evaluator import Evaluator
from bt_mission.executive.behaviours.hooks import Hooked
from bt_mission.executive.behaviours.runtime import MissionFailure, Runtime, placed
from bt_mission.language.expressions.values import WORDS, fits, type_of
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.language.plugins import attributes_of, find_class

RUNNING, INVALID = Status.RUNNING, Status.INVALID

MOST_WALL_S = 2.0
"""The wall time of a tick above which a warning is logged, s."""

_STATUSES = ("SUCCESS", "FAILURE", "RUNNING")


class PythonLeaf(Hooked):
    """Represents a user's behaviour in the tree, with its name, status, message and attributes.

    Inputs are set at each entry, outputs read at each end. The children of the behaviour are in the
    tree as well.

    Raises:
        MissionFailure: The class does not exist, or its constructor raises.
    """

    def __init__(self, node: PythonNode, values: Evaluator) -> None:
        self.behaviour = _made(node, values)
        message = self.behaviour.feedback_message
        super().__init__(self.behaviour.name)
        self.feedback_message = message
        self.children = self.behaviour.children
        for child in self.children:
            child.parent = self
        self._values = values
        self._is_noted = False

    def __getattr__(self, name: str) -> Any:
        return getattr(self.__dict__["behaviour"], name)

    @property
    def status(self) -> Status:
        """Of the user's behaviour."""
        return self.behaviour.status

    @status.setter
    def status(self, status: Status) -> None:
        self.behaviour.status = status

    @property
    def feedback_message(self) -> str:
        """Of the user's behaviour."""
        return self.behaviour.feedback_message

    @feedback_message.setter
    def feedback_message(self, message: str) -> None:
        self.behaviour.feedback_message = message

    def setup(self, **kwargs: Any) -> None:
        """Hand the runtime on."""
        self._runtime: Runtime = kwargs["runtime"]
        self.behaviour.parent = self.parent
        with self._blamed("setup() raised "):
            self.behaviour.setup(**kwargs)

    @property
    def _named(self) -> str:
        """The place in the mission, and the label."""
        return f"{self._values.place}: '{self._node.label}'"

    @contextmanager
    def _blamed(self, what: str = "") -> Iterator[None]:
        """Around a call of the user's code: what it raises names the place in the mission.

        Raises:
            MissionFailure: The code raises, or would end the process.
        """
        try:
            with CONTAINED:
                yield
        except LeftError as error:
            raise MissionFailure(f"{self._named}: {error}") from error
        except BtMissionError:
            raise
        except Exception as error:
            raise MissionFailure(f"{self._named}: {what}{described(error)}") from error

    def walk(self) -> Iterator[Behaviour]:
        """Set the inputs at entry; tick; read the outputs at the end.

        Raises:
            MissionFailure: The user's code raises; the message has the place in the mission.
        """
        walk = self._walk()
        while True:
            # Around each piece of the walk, not around a yield: whoever drops a walk closes it.
            with self._blamed():
                node = next(walk, None)
            if node is None:
                return
            yield node

    def _walk(self) -> Iterator[Behaviour]:
        ours = self.behaviour
        if ours.status is not RUNNING:
            self.run_call_hooks("initialise")
            for attribute, value in self._values.resolve(self._node.inputs).items():
                setattr(ours, attribute, value)
        given = self.run_call_hooks("update")
        is_leaf = given is not None or type(ours).tick is Behaviour.tick
        watch = Stopwatch()
        for node in self._tick_of_leaf(given) if is_leaf else ours.tick():
            if node is not ours:
                yield node
        self._note_wall_time(watch.elapsed_s)
        if ours.status is not RUNNING:
            try:
                self.run_call_hooks("terminate")
                self._read_outputs()
            except Exception:
                ours.stop(INVALID)
                raise
        yield self

    def _tick_of_leaf(self, given: Status | None) -> Iterator[Behaviour]:
        """Tick a behaviour without children as py_trees does; refuse an invalid status.

        Args:
            given: The status of a hook, which replaces `update`.

        Raises:
            MissionFailure: With the file and the line of the method.
        """
        ours = self.behaviour
        if ours.status is not RUNNING:
            ours.initialise()
        status: object = ours.update() if given is None else given
        if not isinstance(status, Status) or status is INVALID:
            ours.stop(INVALID)
            raise MissionFailure(self._no_status(status))
        if status is not RUNNING:
            ours.stop(status)
        ours.status = status
        yield ours

    def _no_status(self, status: object) -> str:
        """Return the error of an `update` that does not return a status."""
        kind = type(self.behaviour)
        name = str(status).rpartition(".")[2].upper()
        expected = "Status.SUCCESS, Status.FAILURE or Status.RUNNING"
        hint = f"; write Status.{name}" if name in _STATUSES else ""
        got = "nothing" if status is None else describe(status)
        if isinstance(status, Status):
            got = f"Status.{status.name}"
        return (
            f"{self._named}: {kind.__name__}.update() ({place_of(kind.update)}) "
            f"returned {got}, expected {expected}{hint}"
        )

    def _note_wall_time(self, elapsed_s: float) -> None:
        """Warn of a tick that blocks: nothing else happens meanwhile. Once for each leaf."""
        if elapsed_s >= MOST_WALL_S and not self._is_noted:
            self._is_noted = True
            leaf = f"{self._named} ({self._node.target})"
            blocked = f"{leaf} blocked a tick for {elapsed_s:.1f} s of wall time"
            self._runtime.warn(f"{blocked}; return Status.RUNNING and continue at the next tick")

    def update(self) -> Status:
        """Return the status of the user's behaviour; :meth:`walk` ticks it."""
        return self.status

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """Halt the user's behaviour."""
        self.note_reset(new_status)
        self.run_call_hooks("terminate")
        with CONTAINED:
            self.behaviour.stop(new_status)

    def tip(self) -> Behaviour | None:
        """Return the deepest node that was ticked."""
        tip = self.behaviour.tip()
        return self if tip is self.behaviour else tip

    def save_state(self, now_ns: int) -> dict[str, Any]:
        """Return what the user's behaviour saves."""
        return snapshot.save(self.behaviour, now_ns)

    def restore_state(self, state: dict[str, Any], now_ns: int) -> None:
        """Restore the user's behaviour; if it cannot save its state, it starts again."""
        self.status = INVALID
        snapshot.load(self.behaviour, RUNNING, state, now_ns)

    def _read_outputs(self) -> None:
        if self.status is INVALID:
            return
        kind = type(self.behaviour)
        for attribute, variable in self._node.outputs.items():
            if not hasattr(self.behaviour, attribute):
                raise MissionFailure(f"{self._named} has no attribute '{attribute}' for its output")
            value = getattr(self.behaviour, attribute)
            wanted, actual = attributes_of(kind).get(attribute), type_of(value)
            is_nan = isinstance(value, float) and math.isnan(value)
            if is_nan or (wanted is not None and (actual is None or not fits(actual, wanted))):
                got = "NaN" if is_nan else describe(value)
                raise MissionFailure(
                    f"{self._named}: output '{attribute}' of {kind.__name__} "
                    f"({place_of(kind.update)}): expected {WORDS[wanted]}, got {got}"
                )
            self._values.scope.values[variable] = value


def _made(node: PythonNode, values: Evaluator) -> Behaviour:
    with placed(values.place):
        kind = find_class(node.target, values.file)
    try:
        with CONTAINED:
            return kind(node.label)
    except LeftError as error:
        raise MissionFailure(f"{values.place}: {error}") from error
    except Exception as error:
        raise MissionFailure(
            f"{values.place}: {kind.__name__}({node.label!r}) raised {described(error, kind)}"
        ) from error
