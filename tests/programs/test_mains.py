"""Whole programs: files that run as ``python FILE`` runs them, on the virtual clock."""

from __future__ import annotations

import gc
import json
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from greenlet import greenlet
from rclpy.node import Node

from bt_mission.base.diagnostics import InputError
from bt_mission.programs.calls import Call
from bt_mission.programs.mains import MainProgram
from bt_mission.sessions.drive import drive
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage

SERVER = """\
import sys
import time
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from numbers_of import add


class Server(Node):
    def __init__(self):
        super().__init__("server")
        self.server = ActionServer(
            self, Fibonacci, "fib", self.execute, callback_group=ReentrantCallbackGroup(),
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def execute(self, goal):
        numbers = [0, 1]
        for _ in range(goal.request.order):
            if goal.is_cancel_requested:
                goal.canceled()
                return Fibonacci.Result(sequence=numbers)
            numbers.append(add(*numbers[-2:]))
            goal.publish_feedback(Fibonacci.Feedback(sequence=numbers))
            time.sleep(1)
        goal.succeed()
        return Fibonacci.Result(sequence=numbers)


def main():
    rclpy.init()
    node = Server()
    if "several" in sys.argv:
        executor = MultiThreadedExecutor()
        executor.add_node(node)
        executor.spin()
    else:
        rclpy.spin(node)


if __name__ == "__main__":
    main()
"""
CLIENT = """\
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.node import Node


class Client(Node):
    def __init__(self):
        super().__init__("client")
        self.count = 0
        self.client = ActionClient(self, Fibonacci, "fib")
        self.client.wait_for_server()
        goal = Fibonacci.Goal(order=20)
        self.client.send_goal_async(goal, self.feedback).add_done_callback(self.accepted)

    def accepted(self, future):
        self.goal = future.result()
        self.goal.get_result_async().add_done_callback(self.done)

    def feedback(self, _):
        self.count += 1
        if self.count == 5:
            self.goal.cancel_goal_async()

    def done(self, future):
        print("status", future.result().status, "numbers", len(future.result().result.sequence))
        rclpy.shutdown()


def main():
    rclpy.init()
    rclpy.spin(Client())


if __name__ == "__main__":
    main()
"""
MODULE = (
    "def add(a, b): return a + b\n\n"
    "def run_to(end):\n    number = 0\n    while number < end:\n        number += 1\n"
)


@pytest.fixture
def run(programs: Any, tmp_path: Path) -> Callable[..., Any]:
    """Run programs until those that are waited for have ended; return what they have printed."""
    (tmp_path / "numbers_of.py").write_text(MODULE, encoding="utf-8")
    printed: list[tuple[float, str]] = []

    def started(code: str, *arguments: str, name: str = "program") -> MainProgram:
        file = tmp_path / f"{name}.py"
        file.write_text(code, encoding="utf-8")
        program = MainProgram(
            programs.host,
            f"0/{name}",
            file,
            arguments,
            lambda line: printed.append((programs.rig.now_s, line)),
        )
        programs.host.run_main(program, lambda: None)
        return program

    def run_to_end(code: str, *arguments: str, beside: Any = None) -> Any:
        printed.clear()
        if beside is not None:
            started(*beside, name="beside")
        program = started(code, *arguments)
        programs.rig.clock.run_until_quiet()
        while program.exit_code is None:
            programs.rig.step()
        programs.rig.clock.run_until_quiet()
        return program.exit_code, list(printed)

    return run_to_end


@pytest.mark.parametrize(
    ("argument", "line"),
    [("several", (5.0, "status 5 numbers 7")), ("one", (20.0, "status 4 numbers 22"))],
)
def test_a_server_and_a_client_run_as_they_are(run: Any, argument: str, line: Any) -> None:
    """The executor of the server decides when it takes the cancel request, as on a robot."""
    assert run(CLIENT, beside=(SERVER, argument)) == (0, [line])


NODE = "import rclpy\nrclpy.init()\nnode = rclpy.create_node('n')\n"
POOL = (
    "from rclpy.executors import MultiThreadedExecutor\npool = MultiThreadedExecutor(2)\n"
    "pool.add_node(node)\n"
)
ENDS = [
    ("import rclpy\nrclpy.init()\nrclpy.shutdown()\n", 0, []),
    ("import rclpy\ndef main():\n    rclpy.init()\n    print('in main')\n", 0, ["in main"]),
    ("import sys, rclpy\nrclpy.init()\nsys.exit(3)\n", 3, []),
    ("import sys, rclpy\nrclpy.init()\nsys.exit('no map')\n", 1, ["no map"]),
    ("import rclpy\nrclpy.init()\nrclpy.init()\n", 1, ["Context.init() must only be called once"]),
    (
        "import rclpy\nrclpy.init()\n1 / 0\n",
        1,
        ["(most recent call last):\n  File", "line 3", "ZeroDivisionError"],
    ),
    ("class Server: pass\n", 1, ["program.py has ended without rclpy.init(): it uses no ROS."]),
    (
        "from rclpy.node import Node\nclass Server(Node): pass\n",
        1,
        ["program.py has no main()", "nodes: [program.py:Server]"],
    ),
    ("import rclpy, cv3\n", 1, ["No module named 'cv3'", "package of the module 'cv3' is not"]),
    ("import rclpy\ndef main():\n    rclpy.init()\n    print('once')\nmain()\n", 0, ["once"]),
    (
        (f"{NODE}import threading\nthreading.Thread(target=lambda: 1 / 0, name='t').start()\n"),
        0,
        ["Exception in thread t:", 'program.py", line 5', "ZeroDivisionError"],
    ),
    (
        (
            f"{NODE}from rclpy.action import ActionServer, ActionClient\n"
            "from example_interfaces.action import Fibonacci\n"
            "server = ActionServer(node, Fibonacci, 'f', lambda goal: exit(4))\n"
            "client = ActionClient(node, Fibonacci, 'f')\n"
            "client.send_goal_async(Fibonacci.Goal())\nrclpy.spin(node)\n"
        ),
        4,
        [],
    ),
    # A node that another executor serves is taken over, as in rclpy.
    (
        (
            f"{NODE}from rclpy.executors import SingleThreadedExecutor\nimport threading\n"
            "first = SingleThreadedExecutor()\nfirst.add_node(node)\n"
            "threading.Thread(target=first.spin, daemon=True).start()\n"
            "node.create_timer(0.5, lambda: print('tick'))\nrclpy.spin_once(node)\n"
            "print(first.get_nodes())\n"
        ),
        0,
        ["tick\n[]"],
    ),
    (
        (
            "import atexit, threading, time, rclpy\nrclpy.init()\natexit.register(print, 'exit')\n"
            "threading.Thread(target=lambda: (time.sleep(1), print('thread'))).start()\n"
            "threading.Thread(target=time.sleep, args=(9,), daemon=True).start()\nprint('main')\n"
        ),
        0,
        ["main", "thread", "exit"],
    ),
    (
        (
            "import rclpy\nrclpy.init()\nnode = rclpy.create_node('n')\n"
            "def tick():\n    print('tick')\n    raise SystemExit(4)\n"
            "node.create_timer(1.0, tick)\nrclpy.spin(node)\n"
        ),
        4,
        ["tick"],
    ),
    (
        (
            "import rclpy\nrclpy.init()\nnode = rclpy.create_node('n')\n"
            "def tick():\n    rclpy.shutdown()\n"
            "node.create_timer(1.0, tick)\nrclpy.spin(node)\nprint(rclpy.ok())\n"
        ),
        0,
        ["False"],
    ),
    ("import os, rclpy\nrclpy.init()\ntry:\n    os._exit(9)\nfinally:\n    print('no')\n", 9, []),
    (
        (
            "import os, threading, time, rclpy\nrclpy.init()\nprint('a')\n"
            "threading.Timer(1, os._exit, [7]).start()\ntime.sleep(60)\n"
        ),
        7,
        ["a"],
    ),
    ("import os, rclpy\nrclpy.init()\nos.fork()\n", 1, ["OSError", "cannot fork", "subprocess"]),
    (
        "import os, sys, rclpy\nrclpy.init()\nos.execlp(sys.executable, 'a')\n",
        1,
        ["OSError", "cannot replace its process", "subprocess"],
    ),
    (
        (
            f"{NODE}node.create_timer(1.0, lambda: exec('raise KeyboardInterrupt'))\n"
            "try:\n    rclpy.spin(node)\nexcept KeyboardInterrupt:\n    print('caught')\n"
        ),
        0,
        ["caught"],
    ),
    (
        (
            f"{NODE}import threading\nthreading.Timer(1.0, rclpy.shutdown).start()\n"
            "rclpy.spin(node)\nprint('quiet', rclpy.ok())\n"
        ),
        0,
        ["quiet False"],
    ),
    (
        (
            f"{NODE}{POOL}import threading\nnode.create_timer(1.0, lambda: exit(3))\n"
            "threading.Timer(2.5, rclpy.shutdown).start()\npool.spin()\nprint('goes on')\n"
        ),
        0,
        ["goes on"],
    ),
    (
        f"{NODE}{POOL}node.create_timer(1.0, lambda: print('tick', 1 / 0))\npool.spin()\n",
        1,
        ["ZeroDivisionError: division by zero"],
    ),
    (
        (
            f"{NODE}from rclpy.wait_for_message import wait_for_message\n"
            "from std_msgs.msg import Int64\n"
            "print(wait_for_message(Int64, node, 'silent', time_to_wait=1))\n"
            "node.create_timer(1.0, lambda: exit(6))\nrclpy.spin(node)\n"
        ),
        6,
        ["(False, None)"],
    ),
]


EXACT = [
    # Events of its endpoints, also before it spins.
    (
        (
            f"{NODE}from std_msgs.msg import Empty\n"
            "from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks\n"
            "from rclpy.qos import qos_policy_name_from_kind, qos_profile_sensor_data\n"
            "def differs(info):\n"
            "    print(info.total_count, qos_policy_name_from_kind(info.last_policy_kind))\n"
            "def matched(info):\n    print('matched', info.current_count)\n"
            "node.create_subscription(Empty, 'e', print, 10, "
            "event_callbacks=SubscriptionEventCallbacks(incompatible_qos=differs))\n"
            "node.create_publisher(Empty, 'e', qos_profile_sensor_data)\n"
            "node.create_publisher(Empty, 'e', 10, "
            "event_callbacks=PublisherEventCallbacks(matched=matched))\n"
            "rclpy.spin_once(node, timeout_sec=0.5)\nrclpy.spin_once(node, timeout_sec=0.5)\n"
        ),
        [(0.0, "1 RELIABILITY"), (0.0, "matched 1")],
    ),
    # Throttled lines of the log have their time, and the first one is shown.
    (
        (
            f"{NODE}import time\nfor _ in range(9):\n"
            "    node.get_logger().info('line', throttle_duration_sec=2)\n    time.sleep(0.5)\n"
        ),
        [(time_s, "[INFO] [n]: line") for time_s in (0.0, 2.0, 4.0)],
    ),
    # What a callback in another thread changes ends a loop that does not wait.
    (
        (
            f"{NODE}{POOL}from rclpy.callback_groups import ReentrantCallbackGroup\n"
            "groups = {'callback_group': ReentrantCallbackGroup()}\nseen = []\n"
            "def wait():\n    while not seen:\n        continue\n"
            "    print('seen')\n    rclpy.shutdown()\n"
            "node.create_timer(0.5, wait, **groups)\n"
            "node.create_timer(0.75, lambda: seen.append(0), **groups)\npool.spin()\n"
        ),
        [(0.751, "seen")],
    ),
    # Also one in a module beside the program; 200 rounds take 1 ms.
    (
        "import rclpy, numbers_of\nrclpy.init()\nnumbers_of.run_to(2000)\nprint('end')\n",
        [(0.009, "end")],
    ),
    # Each program has event loops of its own, and each of its threads.
    (
        (
            f"{NODE}import asyncio, threading\nloop = asyncio.get_event_loop()\n"
            "def run():\n    asyncio.set_event_loop(asyncio.new_event_loop())\n"
            "    asyncio.get_event_loop().run_until_complete(asyncio.sleep(0.5))\n"
            "    print(asyncio.get_event_loop() is loop, threading.main_thread().name)\n"
            "thread = threading.Thread(target=run)\nthread.start()\nthread.join()\n"
            "loop.run_until_complete(asyncio.sleep(0.5))\n"
            "print(asyncio.get_event_loop() is loop, "
            "threading.current_thread() is threading.main_thread())\n"
        ),
        [(0.5, "False MainThread"), (1.0, "True True")],
    ),
    # Of the tasks that can go on, rclpy's executors run the newest first.
    (
        (
            f"{NODE}from rclpy.executors import SingleThreadedExecutor\n"
            "executor = SingleThreadedExecutor()\n"
            "tasks = [executor.create_task(print, name) for name in 'abc']\n"
            "tasks[1].cancel()\nexecutor.spin_until_future_complete(tasks[0])\n"
        ),
        [(0.0, "c"), (0.0, "a")],
    ),
    (
        (
            f"{NODE}from rclpy.executors import SingleThreadedExecutor\n"
            "executor = SingleThreadedExecutor()\n"
            "async def one():\n    print('one')\n    return 1\n"
            "async def two():\n    print('two')\n    print(await first, 'done')\n"
            "first = executor.create_task(one)\nsecond = executor.create_task(two)\n"
            "executor.spin_once(timeout_sec=0)\nexecutor.spin_once(timeout_sec=0)\n"
            "print(first.done(), second.done())\nexecutor.spin_once(timeout_sec=1)\n"
        ),
        [(0.0, "two"), (0.0, "one"), (0.0, "True False"), (0.0, "1 done")],
    ),
    # An exception in a pool is raised with the next callback.
    (
        (
            f"{NODE}{POOL}import time\ncount = []\n"
            "def tick():\n    count.append(0)\n    print('tick')\n    1 / len(count[1:])\n"
            "node.create_timer(1.0, tick)\n"
            "try:\n    pool.spin()\nexcept ZeroDivisionError:\n    print('raised')\n"
        ),
        [(1.0, "tick"), (2.0, "tick"), (2.0, "raised")],
    ),
    # Python waits for the threads of pools, also for those of executors.
    (
        (
            f"{NODE}{POOL}import time\nfrom concurrent.futures import ThreadPoolExecutor\n"
            "node.create_timer(1.0, lambda: (time.sleep(0.75), print('callback')))\n"
            "pool.spin_until_future_complete(rclpy.Future(), timeout_sec=1.5)\n"
            "ThreadPoolExecutor(2).submit(lambda: (time.sleep(0.5), print('pool')))\nprint('end')\n"
        ),
        [(1.5, "end"), (1.75, "callback"), (2.0, "pool")],
    ),
    (
        (
            "import asyncio, threading, time, rclpy\n"
            "async def wait(name, seconds):\n    await asyncio.sleep(seconds)\n    print(name)\n"
            "async def main():\n    rclpy.init()\n    loop = asyncio.get_running_loop()\n"
            "    await asyncio.gather(wait('b', 2), wait('a', 1))\n"
            "    print(await loop.run_in_executor(None, lambda: time.sleep(0.5) or 'pool'))\n"
            "    event = asyncio.Event()\n"
            "    threading.Timer(1, loop.call_soon_threadsafe, [event.set]).start()\n"
            "    await event.wait()\n    time.sleep(0.25)\n    print('event')\n"
            "    try:\n        await asyncio.wait_for(asyncio.sleep(60), 0.5)\n"
            "    except TimeoutError:\n        print('late')\nasyncio.run(main())\n"
        ),
        [(1.0, "a"), (2.0, "b"), (2.5, "pool"), (3.75, "event"), (4.25, "late")],
    ),
]


@pytest.mark.filterwarnings("ignore:There is no current event loop:DeprecationWarning")  # of 3.12
@pytest.mark.parametrize(("code", "lines"), EXACT)
def test_a_program_does_the_same_as_on_a_robot(run: Any, code: str, lines: Any) -> None:
    """In the same order, at the same times."""
    assert run(code) == (0, lines)


REMARKS = [
    # A callback that polls what another one would set.
    (
        (
            f"{NODE}import time\nfrom std_msgs.msg import Empty\n"
            "node.create_subscription(Empty, 'e', print, 10)\n"
            "publisher = node.create_publisher(Empty, 'e', 10)\n"
            "def drive():\n    for _ in range(30):\n        publisher.publish(Empty())\n"
            "        time.sleep(0.1)\n    exit()\n"
            "node.create_timer(0.5, drive)\nrclpy.spin(node)\n"
        ),
        (
            "messages of /e have waited 2 s: drive (program.py:11) sleeps in the only thread of "
            "its executor; use a MultiThreadedExecutor and a ReentrantCallbackGroup [BT-920]"
        ),
    ),
    (
        (
            f"{NODE}import threading\nseen = []\n"
            "def wait():\n    while not seen:\n        pass\n    exit()\n"
            "node.create_timer(0.5, wait)\nthreading.Timer(3, seen.append, [0]).start()\n"
            "rclpy.spin(node)\n"
        ),
        "wait (program.py:7) loops without waiting in the only thread of its executor",
    ),
    (
        (
            f"{NODE}from std_msgs.msg import Empty\nfrom rclpy.qos import qos_profile_sensor_data\n"
            "node.create_subscription(Empty, 'e', print, 10)\n"
            "node.create_publisher(Empty, 'e', qos_profile_sensor_data)\n"
            "rclpy.spin_once(node, timeout_sec=1)\n"
        ),
        "n gets no messages of /e from n: incompatible QoS, best effort publisher and reliable",
    ),
]


@pytest.mark.parametrize(("code", "line"), REMARKS)
def test_what_a_robot_would_not_do_is_logged(
    run: Any, capfd: pytest.CaptureFixture[str], code: str, line: str
) -> None:
    """It is no line of the program, and said once."""
    assert run(code) == (0, [])
    assert capfd.readouterr().err.count(line) == 1


def test_loops_of_two_programs_do_not_meet(run: Any) -> None:
    """Each thread of the system has one loop of asyncio; here programs share it."""
    code = (
        "import asyncio, rclpy\nrclpy.init()\n"
        "async def main():\n    for _ in range(3):\n        await asyncio.sleep(0.4)\n"
        "    print('end')\nasyncio.run(main())\n"
    )
    assert run(code, beside=(code,)) == (0, [(1.2, "end"), (1.2, "end")])


def test_an_execute_callback_that_raises_prints_its_traceback(run: Any) -> None:
    """Where the code of the program is; without the frames of bt-mission. Its goal is aborted."""
    server = SERVER.replace("            numbers.append", "            numbers.append(1 / 0)#")
    code, lines = run(CLIENT, beside=(server, "one"))
    assert (code, lines[-1]) == (0, (0.0, "status 6 numbers 0"))
    text = "\n".join(line for _, line in lines)
    assert 'beside.py", line 26, in execute\n' in text
    assert "ZeroDivisionError: division by zero" in text
    assert "bt_mission" not in text


@pytest.mark.parametrize(("code", "exit_code", "lines"), ENDS)
def test_a_program_ends_as_a_process_does(run: Any, code: str, exit_code: int, lines: Any) -> None:
    """With the exit code of Python; what it prints is kept. Another one runs afterwards."""
    code_, printed = run(code)
    assert code_ == exit_code
    text = "\n".join(line for _, line in printed)
    assert [line for line in lines if line not in text] == [], text
    assert "/bt_mission/" not in text, "a traceback has no frames of ours"
    code_, printed = run("import rclpy\nrclpy.init()\nprint('after')\n")
    assert (code_, [line for _, line in printed]) == (0, ["after"]), "the clock is usable"


LEVELS = [
    ("", ["INFO n", "INFO n.sub", "DEBUG n"]),
    ("--ros-args --log-level error", ["DEBUG n"]),
    (
        "--ros-args --log-level debug",
        ["DEBUG n", "INFO n", "DEBUG n.sub", "INFO n.sub", "DEBUG n"],
    ),
    (
        "--ros-args --log-level warn --log-level n.sub:=Debug",
        ["DEBUG n.sub", "INFO n.sub", "DEBUG n"],
    ),
]


@pytest.mark.parametrize(("words", "lines"), LEVELS)
def test_each_program_has_its_own_log_levels(run: Any, words: str, lines: list[str]) -> None:
    """Those of its arguments, and those that it sets; not those of the process."""
    code = (
        f"{NODE}log = node.get_logger()\n"
        "for each in (log, log.get_child('sub')):\n    each.debug('')\n    each.info('')\n"
        "log.set_level(rclpy.logging.LoggingSeverity.DEBUG)\nlog.debug('')\n"
    )
    expected = ["[{}] [{}]: ".format(*line.split()) for line in lines]
    for _ in range(2):
        assert run(code, *words.split()) == (0, [(0.0, line) for line in expected])


def test_an_unknown_log_level_is_refused(run: Any) -> None:
    """As by rclpy, with the argument."""
    code, printed = run(NODE, "--ros-args", "--log-level", "loud")
    assert code == 1
    assert "--log-level loud" in "\n".join(line for _, line in printed)


def test_each_program_has_its_own_process(run: Any) -> None:
    """Its arguments, its modules and their state, and the names of its nodes."""
    code = (
        "import sys, rclpy, numbers_of\n"
        "numbers_of.count = getattr(numbers_of, 'count', 0) + 1\n"
        "rclpy.init()\nnode = rclpy.create_node('n')\n"
        "speed = node.declare_parameter('speed', 0.1).value\n"
        "print(sys.argv[1:2], numbers_of.count, node.get_name(), speed, __name__)\n"
    )
    arguments = ("fast", "--ros-args", "-r", "__node:=m", "-p", "speed:=0.5")
    before = sys.argv, sys.stdout, sys.path[:], sys.modules["__main__"], sys.modules.keys() - ()
    expected = (0, [(0.0, "['fast'] 1 m 0.5 __main__")])
    assert run(code, *arguments) == run(code, *arguments) == expected
    after = sys.argv, sys.stdout, sys.path[:], sys.modules["__main__"], sys.modules.keys() - ()
    assert before == after


@pytest.mark.parametrize("count", [10, pytest.param(200, marks=pytest.mark.thorough)])
def test_many_runs_leave_nothing_behind(run: Any, programs: Any, count: int) -> None:
    """No greenlet, no thread, no node, no module; and no object for each run."""

    def there() -> Any:
        gc.collect()
        objects = gc.get_objects()
        suspended = sum(isinstance(each, greenlet) and not each.dead for each in objects)
        kept = sum(isinstance(each, MainProgram | Call | Node) for each in objects)
        nodes = len(programs.rig.clock.get_nodes())
        return (suspended, nodes, threading.active_count(), sorted(sys.modules)), kept

    code = (
        "import threading, time, rclpy, numbers_of\nrclpy.init()\n"
        "node = rclpy.create_node('n')\n"
        "threading.Thread(target=time.sleep, args=(9,), daemon=True).start()\n"
        "node.create_timer(0.1, rclpy.shutdown)\nrclpy.spin(node)\n"
    )
    run(code)
    run(code)
    programs.rig.clock.run_until_quiet()
    before, kept = there()
    for _ in range(count):
        run(code)
    after, kept_after = there()
    assert after == before
    assert kept_after <= kept


MISSION = """\
mission: fib
world: empty_arena
nodes: ["{program}"]
tree:
  action: {{name: fib, type: example_interfaces/action/Fibonacci, goal: {{order: 20}}}}
  cancel_when: len(sequence) >= 7
  on_cancel: success
"""


def test_a_mission_runs_with_a_program(tmp_path: Path, capsys: Any) -> None:
    """`nodes` names its file, and its arguments, as text or as a mapping."""
    (tmp_path / "numbers_of.py").write_text(MODULE, encoding="utf-8")
    (tmp_path / "server.py").write_text(SERVER, encoding="utf-8")
    path = tmp_path / "fib.yaml"
    path.write_text(MISSION.format(program="server.py several --ros-args -p a:=1"), "utf-8")
    (tmp_path / "says.py").write_text("import rclpy\nrclpy.init()\nprint('hello')\n", "utf-8")
    mapping = (
        "{program: server.py, arguments: [several, --ros-args, -p, a:=1]}, "
        "{program: says.py, name: speaker}"
    )
    other = MISSION.format(program="ENTRY").replace('"ENTRY"', mapping)
    (tmp_path / "other.yaml").write_text(other, encoding="utf-8")
    reports: list[Any] = []
    for file in (path, path, tmp_path / "other.yaml"):
        with Stage(load(file), image_folder=tmp_path) as stage:
            reports += drive(stage)
    assert [(report.status, report.virtual_s) for report in reports] == [("success", 5.05)] * 3
    first, second, _ = (report.trace_sha256 for report in reports)
    assert first == second
    assert "     0.00 s  speaker: hello\n" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("program", "code", "message"),
    [
        ("none.py", "", "no such file: none.py"),
        ("server.py", "import rospy\n", "server.py is a program for ROS 1: it imports rospy"),
        ("server.py", "import rospy\nprint 'a'\n", "is a program for ROS 1: it imports rospy"),
        ("server.py", "def main(:\n", "server.py cannot be imported: SyntaxError"),
        ("server.py 'x", "", "the arguments cannot be read: No closing quotation"),
        ({"program": "server.py", "argument": 1}, "", "unknown key 'argument' .*arguments"),
        ({"program": "server"}, "", "expected a Python file, an installed module .*'server'"),
        ({"program": 5}, "", "program: expected a file such as 'server.py', .*got .* 5"),
        ({"program": "server.py", "arguments": "a"}, "", "arguments: expected a list of words"),
        ({"program": "server.py", "name": 1}, "", "name: expected a string, got .* 1"),
    ],
)
def test_what_is_no_program_is_refused(
    tmp_path: Path, program: Any, code: str, message: str
) -> None:
    """With its place in the mission."""
    (tmp_path / "server.py").write_text(code, encoding="utf-8")
    path = tmp_path / "fib.yaml"
    entry = f'"{program}"' if isinstance(program, str) else json.dumps(program)
    path.write_text(MISSION.format(program="ENTRY").replace('"ENTRY"', entry), encoding="utf-8")
    with pytest.raises(InputError, match=message):
        Stage(load(path), image_folder=tmp_path)
