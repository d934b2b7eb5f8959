"""What actions do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.task import Future

from tests.support.two_executors import Play

NAMES = {
    number: name.removeprefix("STATUS_").lower()
    for name, number in vars(GoalStatus).items()
    if name.startswith("STATUS_")
}


class Bench:
    """A server whose goals end when the behaviour says so, and a client, on nodes of their own."""

    def __init__(self, play: Play, **habits: Any) -> None:
        self.play = play
        self.serving, self.asking = play.node("serving"), play.node("asking")
        self.ends: list[Future] = []
        self.handles: list[Any] = []
        self.client = ActionClient(self.asking, Turn, "turn")
        execute = habits.pop("execute", self._execute)
        self.server = ActionServer(self.serving, Turn, "turn", execute, **habits)

    async def _execute(self, handle: Any) -> Any:
        self.handles.append(handle)
        self.ends.append(Future())
        angle = handle.request.angle
        self.play.say(f"server {angle:g}", f"begins at {self.play.ms(self.serving)}")
        how = await self.ends[-1]
        self.play.say(f"server {angle:g}", f"{how} at {self.play.ms(self.serving)}")
        if how is not None:
            getattr(handle, how)()
        return Turn.Result(angle_turned=angle / 2)

    def send(self, angle: float = 90.0) -> Future:
        """Send a goal, and log all that is heard of it."""
        who = f"client {angle:g}"

        def answered(future: Future) -> None:
            handle = future.result()
            self.play.say(who, f"accepted: {handle.accepted}")
            if handle.accepted:
                handle.get_result_async().add_done_callback(ended)

        def ended(future: Future) -> None:
            answer = future.result()
            turned = answer.result.angle_turned
            self.play.say(who, f"{NAMES[answer.status]}, {turned:g}")

        sent = self.client.send_goal_async(
            Turn.Goal(angle=angle),
            feedback_callback=lambda m: self.play.say(who, f"at {m.feedback.current_angle:g}"),
        )
        sent.add_done_callback(answered)
        return sent

    def end(self, how: str | None = "succeed") -> None:
        """Have the first goal end."""
        self.play.release(self.ends[0], how)

    def cancel(self, sent: Future) -> None:
        """Ask for a cancel, and log the answer."""
        self.play.settle()

        def answered(future: Future) -> None:
            response = future.result()
            count = len(response.goals_canceling)
            self.play.say("cancel", f"code {response.return_code}, {count} goals")

        sent.result().cancel_goal_async().add_done_callback(answered)
        self.play.settle()


def accept(_: Any) -> CancelResponse:
    return CancelResponse.ACCEPT


def _ended(play: Play, how: str | None, **habits: Any) -> None:
    bench = Bench(play, **habits)
    bench.send()
    play.advance(0.2)
    bench.end(how)


def a_goal_that_succeeds(play: Play) -> None:
    _ended(play, "succeed")


def a_goal_that_is_aborted(play: Play) -> None:
    _ended(play, "abort")


def a_goal_whose_server_forgets_to_say_how_it_ended(play: Play) -> None:
    _ended(play, None)


def a_result_is_kept_for_a_time(play: Play) -> None:
    bench = Bench(play, result_timeout=1)
    sent = bench.send()
    play.advance(0.2)
    bench.end()

    def ask() -> None:
        def answered(future: Future) -> None:
            play.say(
                "client", f"{NAMES[future.result().status]}: {len(bench.server._goal_handles)}"
            )

        sent.result().get_result_async().add_done_callback(answered)
        play.settle()

    play.advance(0.5)
    ask()
    play.advance(0.5)
    ask()


def a_goal_that_is_rejected(play: Play) -> None:
    bench = Bench(play, goal_callback=lambda _: GoalResponse.REJECT)
    bench.send()
    play.settle()


def a_goal_callback_that_answers_nonsense_rejects(play: Play) -> None:
    bench = Bench(play, goal_callback=lambda _: True)
    bench.send()
    play.settle()


def a_goal_callback_that_thinks_it_over(play: Play) -> None:
    gate: Future = Future()

    async def consider(_: Any) -> GoalResponse:
        play.say("server", "considers")
        await gate
        return GoalResponse.ACCEPT

    bench = Bench(play, goal_callback=consider)
    bench.send()
    bench.send(45.0)
    play.advance(0.2)
    play.release(gate)


def a_goal_callback_that_raises(play: Play) -> None:
    def fail(_: Any) -> GoalResponse:
        raise ValueError("in a goal callback")

    bench = Bench(play, goal_callback=fail)
    sent = bench.send()
    play.settle()
    play.say("client", sent.done())


def an_execute_callback_that_raises_aborts(play: Play) -> None:
    async def fail(_: Any) -> Any:
        raise ValueError("in an execute callback")

    Bench(play, execute=fail).send()
    play.settle()


def an_execute_callback_that_is_no_coroutine(play: Play) -> None:
    def execute(handle: Any) -> Any:
        handle.publish_feedback(Turn.Feedback(current_angle=1.0))
        handle.succeed()
        return Turn.Result(angle_turned=1.0)

    Bench(play, execute=execute).send()
    play.settle()


def feedback_comes_in_order(play: Play) -> None:
    bench = Bench(play)
    angles = iter(range(100))

    def report() -> None:
        for handle in bench.handles:
            handle.publish_feedback(Turn.Feedback(current_angle=float(next(angles))))

    bench.serving.create_timer(0.1, report)
    bench.send()
    play.advance(0.45)
    bench.end()


def feedback_after_the_end_is_heard(play: Play) -> None:
    bench = Bench(play)
    bench.send()
    play.settle()
    bench.end()
    bench.handles[0].publish_feedback(Turn.Feedback(current_angle=5.0))
    play.settle()


def a_cancel_that_is_accepted(play: Play) -> None:
    bench = Bench(play, cancel_callback=accept)
    sent = bench.send()
    play.advance(0.1)
    bench.cancel(sent)
    play.advance(0.1)
    play.say("server", bench.handles[0].is_cancel_requested)
    bench.end("canceled")


def a_cancel_that_is_refused(play: Play) -> None:
    bench = Bench(play)
    bench.cancel(bench.send())
    bench.end()


def a_cancel_after_the_end(play: Play) -> None:
    bench = Bench(play, cancel_callback=accept)
    sent = bench.send()
    play.settle()
    bench.end()
    bench.cancel(sent)


def a_cancel_callback_that_ends_the_goal(play: Play) -> None:
    bench: Bench

    def cancel(_: Any) -> CancelResponse:
        bench.ends[0].set_result("canceled")
        return CancelResponse.ACCEPT

    bench = Bench(play, cancel_callback=cancel)
    bench.cancel(bench.send())


def a_cancelled_goal_that_succeeds_all_the_same(play: Play) -> None:
    bench = Bench(play, cancel_callback=accept)
    bench.cancel(bench.send())
    bench.end()


def a_result_that_is_asked_for_after_the_end(play: Play) -> None:
    bench = Bench(play)
    sent = bench.client.send_goal_async(Turn.Goal(angle=90.0))
    play.settle()
    bench.ends[0].set_result("succeed")
    play.advance(0.5)
    asked = sent.result().get_result_async()
    play.settle()
    play.say("client", NAMES[asked.result().status])


def a_result_that_is_asked_for_twice(play: Play) -> None:
    bench = Bench(play)
    sent = bench.client.send_goal_async(Turn.Goal(angle=90.0))
    play.settle()
    asked = [sent.result().get_result_async() for _ in range(2)]
    play.settle()
    bench.end()
    play.say(
        "client", [NAMES[future.result().status] if future.done() else None for future in asked]
    )


def two_goals_at_once(play: Play) -> None:
    bench = Bench(play)
    bench.send(10.0)
    bench.send(20.0)
    play.advance(0.1)
    by_angle: dict[float, Callable[..., Any]] = {
        handle.request.angle: end.set_result
        for handle, end in zip(bench.handles, bench.ends, strict=True)
    }
    by_angle[20.0]("abort")
    play.advance(0.1)
    by_angle[10.0]("succeed")
    play.settle()


def a_goal_that_begins_later(play: Play) -> None:
    waiting: list[Any] = []
    bench = Bench(play, handle_accepted_callback=waiting.append)
    bench.send()
    play.advance(0.3)
    waiting[0].execute()
    play.settle()
    bench.end()


def a_coroutine_that_sends_waits_and_sends_again(play: Play) -> None:
    async def execute(handle: Any) -> Any:
        handle.succeed()
        return Turn.Result(angle_turned=handle.request.angle)

    bench = Bench(play, execute=execute, callback_group=ReentrantCallbackGroup())

    async def act() -> None:
        for angle in (10.0, 20.0, 30.0):
            handle = await bench.client.send_goal_async(Turn.Goal(angle=angle))
            answer = await handle.get_result_async()
            play.say("act", f"{NAMES[answer.status]}, {answer.result.angle_turned:g}")

    play.executor.create_task(act())
    play.settle()


def a_server_destroyed_with_a_goal(play: Play) -> None:
    bench = Bench(play)
    bench.send()
    play.settle()
    bench.server.destroy()
    play.settle()
    play.wait_for(lambda: not bench.client.server_is_ready())
    play.say("client", "the server is gone")


def a_client_destroyed_with_a_goal(play: Play) -> None:
    bench = Bench(play)
    bench.send()
    play.settle()
    bench.client.destroy()
    bench.end()


def a_client_without_a_server(play: Play) -> None:
    node = play.node("asking")
    client = ActionClient(node, Turn, "turn")
    sent = client.send_goal_async(Turn.Goal())
    play.advance(0.2)
    play.say("client", (client.server_is_ready(), sent.done()))
