"""Execute callbacks of action servers: their exceptions and results."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Coroutine, Sequence
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionServer
from rclpy.executors import await_or_execute
from rclpy.node import Node

from bt_mission.base.clock_watch import CONTAINED, Interrupted, LeftError, refuse_leaving
from bt_mission.base.diagnostics import describe, quoted
from bt_mission.base.errors import BtMissionError, described, place_of
from bt_mission.base.ros_log import log_of

UNENDED = "returned without goal.succeed(), canceled() or abort()"


def is_execute_callback(task: Any) -> bool:
    """Return whether a task is the execution of a goal by an action server of rclpy."""
    return getattr(task, "__func__", None) is ActionServer._execute_goal


class ExecuteCallbacks:
    """Calls execute callbacks as rclpy does, and keeps their exceptions.

    A goal whose callback raises is aborted with an empty result, as by rclpy. The log of the node
    has one line in place of a traceback.
    """

    def __init__(self) -> None:
        self._raised: dict[bytes, str] = {}

    def take_raised(self, goal_id: bytes) -> str:
        """Return once what was wrong with the callback of a goal (its UUID); empty if nothing."""
        return self._raised.pop(goal_id, "")

    async def call(
        self,
        actions_of: Callable[[ActionServer], tuple[str, ...]],
        execute_goal: Callable[..., Coroutine[Any, Any, None]],
        callback: Callable[[Any], Any],
        goal: Any,
        *,
        show: Callable[[BaseException], None] | None = None,
    ) -> None:
        """Execute a goal.

        Args:
            actions_of: Returns the full names of the actions that a server can be of.
            execute_goal: The server's method that calls the callback and ends the goal.
            callback: The server's execute callback.
            goal: The handle of the goal.
            show: Prints what the callback of a whole program raises, as rclpy does. It may end its
                process.

        Raises:
            BtMissionError: The callback returns no result of the action. The exception of rclpy
                names neither the node nor the callback.
            BtMissionError: The callback raises an exception after the goal has succeeded. Its
                client receives an empty result as a success.
            BtMissionError: The callback would end the process.
            Interrupted: When the callback was interrupted.
        """
        server: ActionServer = execute_goal.__self__
        expected = server.action_type
        wrong: BtMissionError | Interrupted | None = None
        called = callback if show else _contained(callback)

        async def result_of(goal: Any) -> Any:
            nonlocal wrong
            try:
                result = await await_or_execute(called, goal)
            except (LeftError, Interrupted) as error:  # the goal ends first, then the mission
                wrong = error
            except Exception as error:  # noqa: BLE001 - whatever a user's code raises
                named = _named(callback, actions_of(server), server._node)
                wrong = self._note(error, named, goal, show)
            else:
                if isinstance(result, expected.Result):
                    if goal.is_active:  # rclpy aborts it, and logs its UUID as 16 numbers
                        self._raised[bytes(goal.goal_id.uuid)] = UNENDED
                        named = _named(callback, actions_of(server), server._node)
                        log_of(server._node).warning(f"{named} {UNENDED}; the goal is aborted")
                        goal.abort()
                    return result
                named = _named(callback, actions_of(server), server._node)
                wrong = BtMissionError(
                    f"{named} returned {_kind_of(result)}, expected {expected.__name__}.Result",
                    code="BT-903",
                )
                return expected.Result()
            if goal.is_active:
                goal.abort()
            return expected.Result()

        await execute_goal(result_of, goal)
        if wrong:
            raise wrong

    def _note(
        self, error: Exception, named: str, goal: Any, show: Callable[[BaseException], None] | None
    ) -> BtMissionError | None:
        """Note what a callback has raised. Return an error if its goal has lost its result."""
        cause = described(error)
        self._raised[bytes(goal.goal_id.uuid)] = cause
        if show:
            show(error)
        elif goal.status == GoalStatus.STATUS_SUCCEEDED:
            return BtMissionError(
                f"{named} raised {cause}, after goal.succeed(); the result is empty", code="BT-903"
            )
        log_of(goal._action_server._node).error(f"{named} raised {cause}")
        return None


def _kind_of(result: Any) -> str:
    return "nothing" if result is None else describe(result)


def _contained(callback: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Return a callback of the same kind that cannot end the process."""

    def call(goal: Any) -> Any:
        with CONTAINED:
            return callback(goal)

    async def call_and_await(goal: Any) -> Any:
        try:
            return await callback(goal)
        except GeneratorExit:
            raise  # of whoever closes the coroutine
        except BaseException as error:
            refuse_leaving(error)
            raise

    return call_and_await if inspect.iscoroutinefunction(callback) else call


def _named(callback: Callable[[Any], Any], actions: Sequence[str], node: Node) -> str:
    """Name a callback, its action and its node, for people."""
    name = getattr(callback, "__qualname__", type(callback).__name__)
    place = place_of(callback)
    where = f" ({place})" if place else ""
    of = f"{' or '.join(map(quoted, actions))} of node" if actions else "node"
    return f"{name}(){where}, for {of} {quoted(node.get_fully_qualified_name())},"
