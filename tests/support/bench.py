"""The servers over real rclpy, on the virtual clock, with a fake robot and two clients."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from unique_identifier_msgs.msg import UUID

from action_servers.core.maneuver import ZERO
from action_servers.server.node import ServerOptions, ServersNode
from bt_mission.base.geometry import Twist2D
from tests.support.rig import Rig
from tests.support.robot_node import LATCHED, PERIOD_NS, START_NS, RobotNode
from tests.support.served import SERVED, goal

STATUS = {
    GoalStatus.STATUS_SUCCEEDED: "succeeded",
    GoalStatus.STATUS_CANCELED: "canceled",
    GoalStatus.STATUS_ABORTED: "aborted",
}


class Sent:
    """One goal, as its client sees it."""

    def __init__(self, name: str, number: int, events: list[Any]) -> None:
        self.name = name
        self.id = UUID(uuid=[number % 256] * 8 + [number // 256] * 8)
        self.events = events
        self.accepted: bool | None = None
        self.feedback: list[Any] = []
        self.status: str | None = None
        self.result: Any = None

    @property
    def code(self) -> int | None:
        """The error code of the result; None for a type without one."""
        return getattr(self.result, "error_code", None)

    @property
    def text(self) -> str | None:
        """The text beside it."""
        string = getattr(self.result, "error_string", None)
        return getattr(self.result, "error_msg", string)

    def answered(self, future: Any) -> None:
        """Take the answer to the goal, and ask for the result."""
        handle = future.result()
        self.accepted = handle.accepted
        if handle.accepted:
            handle.get_result_async().add_done_callback(self.ended)

    def ended(self, future: Any) -> None:
        """Take the result."""
        response = future.result()
        self.status, self.result = STATUS[response.status], response.result
        self.events.append((self.name, self.status))


class Bench(Rig):
    """The servers, a fake robot and two clients in one process on one virtual clock.

    The clients are served first, so that a result would overtake a command that was sent after it.
    `events` lists commands and ends in the order in which they arrive.
    """

    def __init__(
        self,
        fake: Any,
        image_folder: Path,
        parameters: Mapping[str, Any] | None = None,
        *,
        lean: bool = True,
        ros_args: Sequence[str] = (),
        without: Collection[str] = (),
    ) -> None:
        super().__init__(ros_args, START_NS)
        self.clients = [self.node(f"client_{number}") for number in (1, 2)]
        self.robot = self.clock.world = self.add(RobotNode(fake, self.context))
        options = ServerOptions(
            image_folder=image_folder,
            lean=lean,
            context=self.context,
            parameters=parameters or {},
            without=without,
        )
        self.servers = self.add(ServersNode(fake.robot, options))
        self.events: list[Any] = []
        self.robot.on_command = self.events.append
        self._actions: dict[tuple[int, str], ActionClient] = {}
        self._sent = 0
        self._cancels: dict[str, Any] = {}
        self._triggers: dict[str, Any] = {}
        self._motors: Any = None

    def _client(self, name: str, number: int) -> ActionClient:
        key = (number, name)
        if key not in self._actions:
            self._actions[key] = ActionClient(self.clients[number], SERVED[name].type, name)
        return self._actions[key]

    def send(self, name: str, message: Any = None, *, client: int = 0) -> Sent:
        """Send a goal; it arrives with the next step."""
        self._sent += 1
        sent = Sent(f"{name} {self._sent}", self._sent, self.events)
        self._client(name, client).send_goal_async(
            goal(name) if message is None else message,
            feedback_callback=lambda message: sent.feedback.append(message.feedback),
            goal_uuid=sent.id,
        ).add_done_callback(sent.answered)
        return sent

    def cancel(self, name: str, goal_id: UUID | None = None) -> Any:
        """Ask for a cancel by goal id, or of all; the answer's future."""
        request = CancelGoal.Request()
        if goal_id is not None:
            request.goal_info.goal_id = goal_id
        if name not in self._cancels:
            service = f"{name}/_action/cancel_goal"
            self._cancels[name] = self.clients[0].create_client(CancelGoal, service)
        return self._cancels[name].call_async(request)

    def trigger(self, service: str) -> Any:
        """Call `stop` or `release`; the answer's future."""
        if service not in self._triggers:
            self._triggers[service] = self.clients[0].create_client(Trigger, service)
        return self._triggers[service].call_async(Trigger.Request())

    def set_motors(self, *, on: bool) -> None:
        """Tell that the motors are on, or off."""
        if self._motors is None:
            self._motors = self.clients[0].create_publisher(Bool, "motors_on", LATCHED)
        self._motors.publish(Bool(data=on))

    def repeat_the_last_id(self) -> None:
        """Give the next goal the id of the last one."""
        self._sent -= 1

    def steps(self, count: int) -> None:
        """Let some control steps pass."""
        self.run_for(count * PERIOD_NS / 1e9)

    def until(self, done: Callable[[], bool], limit: int = 2000) -> None:
        """Let control steps pass until something holds."""
        for _ in range(limit):
            if done():
                return
            self.steps(1)
        raise AssertionError(f"not within {limit} control steps")

    @property
    def commands(self) -> list[Twist2D]:
        """The commands that reached the robot."""
        return [event for event in self.events if isinstance(event, Twist2D)]

    @property
    def moved(self) -> bool:
        """Whether the robot was ever told to move."""
        return any(command != ZERO for command in self.commands)

    @property
    def before_the_last_end(self) -> Any:
        """What arrived just before the last end of a goal."""
        ends = [index for index, event in enumerate(self.events) if isinstance(event, tuple)]
        return self.events[ends[-1] - 1]
