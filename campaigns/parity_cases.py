"""The cases of the campaign ``parity``: programs that run together."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

PROGRAMS = Path(__file__).parent / "programs"


@dataclass(frozen=True)
class Case:
    """Programs that run together, the main one last.

    Attributes:
        programs: Files, with their arguments.
        period_s: Times may differ by it.
        interrupt_s: When the main program gets SIGINT, after all have printed a line.
        world: Of a robot with its action servers; empty for none.
    """

    programs: tuple[str, ...]
    period_s: float = 0.0
    interrupt_s: float | None = None
    world: str = ""

    @property
    def name(self) -> str:
        """Its programs."""
        return " + ".join(" ".join(words.replace(".py", "").split()) for words in self.programs)


CLIENT = "basic_client.py"
CANCELS = f"{CLIENT} --cancel-at 3"
THREADS = "basic_server.py threads reentrant"
RATE = f"{THREADS} rate"
QUEUES = ("queue_server.py", "single_goal_server.py")
ASKING = ("call threads", "await", "await threads", "spin", "spin threads")
ENDS = (
    *("raises", "exits", "says", "shutdown", "destroys", "thread", "leaves"),
    *("raises threads", "exits threads", "shutdown threads"),
)
EXPLORES = "course_explore 0.4 0.5"
CASES = (
    # Servers, and clients with callbacks.
    *(
        Case((f"basic_server.py {how}", CLIENT))
        for how in ("", "raises", "aborts", "forgets", "clock")
    ),
    *(Case((f"basic_server.py {how}", CANCELS)) for how in ("", "threads", "reentrant")),
    *(Case((f"{THREADS} {how}", CANCELS)) for how in ("", "stubborn")),
    *(Case((f"{THREADS} {how}", CLIENT)) for how in ("", "raises")),
    Case(("basic_server.py", f"{CLIENT} --order 50")),
    Case((RATE, CLIENT), 0.5),
    Case((RATE, CANCELS), 0.5),
    Case(("defer_server.py", CLIENT)),
    Case(("defer_server.py", f"{CLIENT} --cancel-at 2")),
    Case(("function_server.py", CLIENT)),
    Case(("function_server.py", CANCELS)),
    *(Case((server, f"two_goals_client.py{how}")) for server in QUEUES for how in ("", " cancel")),
    Case((THREADS, "two_goals_client.py")),
    Case(("basic_server.py", "two_goals_client.py")),
    Case(("thread_server.py", CLIENT), 0.1),
    Case(("thread_server.py", f"{CLIENT} --order 10 --cancel-at 3"), 0.4),
    *(Case(("adder.py", f"asking_server.py {how}", CLIENT)) for how in ASKING),
    # Clients of other shapes.
    Case(("basic_server.py", "fire_and_forget.py")),
    Case((THREADS, "synchronous_client.py")),
    Case((THREADS, "polling_client.py 4"), 0.1),
    Case((THREADS, "polling_client.py 20"), 0.5),
    Case((THREADS, "event_client.py")),
    Case((THREADS, "asynchronous_client.py"), 0.05),
    Case((THREADS, "patrol.py")),
    Case(("basic_server.py", "patrol.py")),
    Case(("late_client.py",)),
    Case(("lonely_client.py",)),
    # Ctrl-C.
    Case((THREADS, "interrupted_client.py"), 0.5, 1.75),
    Case(("two_goals_client.py", "basic_server.py"), 0.5, 1.7),
    Case(("two_goals_client.py", THREADS), 0.5, 1.7),
    Case(("rate_loop.py",), 0.25, 1.6),
    Case(("spin_once_loop.py",), 0.3, 1.6),
    Case(("handler.py",), 0.4, 1.0),
    # Services, topics, parameters, states.
    *(
        Case((f"adder.py {how}", "adding_client.py"))
        for how in ("", "threads", "threads reentrant")
    ),
    Case(("adder.py", "tasks.py")),
    Case(("adder.py", "nested_spin.py")),
    Case(("adder.py", "nested_spin.py threads"), 0.5, 3.0),
    Case(("listener.py", "talker.py 0.3")),
    Case(("listener.py slow", "talker.py 0.15"), 0.15),
    Case(("talker.py 0.2", "messages.py"), 0.2),
    Case(("parameters.py", "configurer.py"), 0.25),
    Case(("parameters.py --ros-args -p speed:=0.4 -r __ns:=/", "configurer.py"), 0.4),
    Case(("lifecycle_node.py", "manager.py"), 0.25),
    Case(("broadcaster.py", "frame_listener.py"), 0.1),
    # Timers, threads, and the end.
    Case(("state_machine.py",)),
    Case(("two_nodes.py",)),
    Case(("two_nodes.py threads",)),
    Case(("groups.py",)),
    Case(("groups.py reentrant",)),
    Case(("workers.py",)),
    Case(("guard.py",)),
    *(Case((f"failing.py {how}",)) for how in ENDS),
    # With a robot.
    Case(("driver.py",), 0.1, world="empty_arena"),
    Case(("turning_client.py",), 0.1, 4.0, world="empty_arena"),
    Case(("explore_client.py explore_forward 0.4 0.5",), 0.2, world="empty_arena"),
    Case(("explore_server.py", f"explore_client.py {EXPLORES}"), 0.2, world="empty_arena"),
)
