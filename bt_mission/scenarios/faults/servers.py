"""Faults of servers themselves, of services, and exceptions in code."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from py_trees.common import Status
from rclpy.node import Node

from bt_mission.base.errors import described
from bt_mission.executive.behaviours.hooks import CallHook, Hooked
from bt_mission.ros.graph import REQUESTS
from bt_mission.ros.interface_types import fill
from bt_mission.ros.virtual_time import Passing, ServiceResponse, Side
from bt_mission.scenarios.draws import Draws, one_of
from bt_mission.scenarios.faults.drawable import Drawable
from bt_mission.scenarios.faults.effects import late, lose, mistakes_of_test, on, passed, service
from bt_mission.scenarios.faults.errors import ScenarioError, no_such
from bt_mission.scenarios.faults.fault import Fates, FaultInstance, Tap
from bt_mission.scenarios.faults.kind import Arguments, Effect, FaultKind
from bt_mission.scenarios.faults.parameters import (
    ACTION,
    ERROR,
    ON,
    SERVICE,
    Parameter,
    always,
    any_of,
    period,
    seconds,
    whole,
)

# ---- servers -----------------------------------------------------------------------------------


def _abort(fault: FaultInstance, given: Arguments) -> None:
    name, when = fault.action(given["action"]), given["when"]
    played = fault.run.scripted.get(name)
    if played is not None:
        if when is not None:
            raise ScenarioError(f"abort_goal: {name} is played by the test, which says when")
        if not played.goals:
            raise ScenarioError(f"abort_goal: {name} has no goal yet")
        played.goal.abort(error_code=given["code"], error_msg=given["message"])
        return

    def before(method: str, feedback: Mapping[str, Any]) -> tuple[int, str] | None:
        if method != "step" or (when is not None and not _holds(fault, when, feedback)):
            return None
        fault.end()
        return given["code"], given["message"]

    fault.undo(_our_servers(fault, name).interpose(name, before))


def _holds(fault: FaultInstance, when: Callable[[Any], Any], feedback: Mapping[str, Any]) -> bool:
    if not feedback:
        return False
    try:
        return bool(when(SimpleNamespace(**feedback)))
    except Exception as error:  # noqa: BLE001 - whatever a test's function raises is the test's
        fault.run.blame_test(ScenarioError(f"abort_goal: `when` raised {described(error)}"))
        return False


def _kill(fault: FaultInstance, given: Arguments) -> None:
    stage, name = fault.run.stage, fault.action(given["action"])
    played = fault.run.scripted.get(name)
    if played is None:
        _our_servers(fault, name)
        run = fault.run.robot_run
        stage.kill_servers(run)
        fault.undo(lambda: stage.start_servers(run))
        return
    node_name = played.node.get_name()
    stage.clock.remove_node(played.node)
    played.node.destroy_node()

    def restart() -> None:
        played.forget()
        played.offer(fault.run.make_node(node_name))
        stage.add_node(played.node)

    fault.undo(restart)


def _our_servers(fault: FaultInstance, name: str) -> Any:
    """Return our servers, if it is they that offer an action."""
    servers = fault.run.robot_run.servers
    if name not in servers.actions:
        raise no_such("shipped action", name, list(servers.actions))
    return servers


def _fail(fault: FaultInstance, given: Arguments) -> Tap:
    name, kind = fault.service(given["service"])
    with mistakes_of_test(f"{fault.fault.what}: {name}"):
        fill(kind.Response(), given["fields"])
    return lambda *_: (ServiceResponse(fill(kind.Response(), given["fields"])),)


def _serve(fault: FaultInstance, given: Arguments) -> None:
    node, nodes = fault.run.robot_run.node, fault.run.stage.clock.get_nodes()
    name = node.resolve_service_name(given["service"])
    if any(name == service.service_name for each in nodes for service in each.services):
        return
    called = {client.service_name: client.srv_type for each in nodes for client in each.clients}
    if name not in called:
        raise no_such("service", name, sorted(called))
    kind: Any = called[name]
    with mistakes_of_test(f"{fault.fault.what}: {name}"):
        fill(kind.Response(), given["fields"])

    def answer(*_: Any) -> Any:
        return fill(kind.Response(), given["fields"])

    service = node.create_service(kind, name, answer, qos_profile=REQUESTS)
    fault.undo(lambda: node.destroy_service(service))


# ---- code --------------------------------------------------------------------------------------


def _error(given: Arguments) -> Exception:
    error: Exception = given["error"] or RuntimeError("made by a fault")
    return error


def _raise_in_maneuver(fault: FaultInstance, given: Arguments) -> None:
    name = fault.action(given["action"])

    def before(called: str, _feedback: Mapping[str, Any]) -> None:
        if called == given["method"] and fault.ends_at_call(given["on"]):
            raise _error(given)

    fault.undo(_our_servers(fault, name).interpose(name, before))


def _raise_in_leaf(fault: FaultInstance, given: Arguments) -> None:
    def hook(called: str) -> None:
        if called == given["method"] and fault.ends_at_call(given["on"]):
            raise _error(given)

    _hook(fault, given["leaf"], hook)


def _return_status(fault: FaultInstance, given: Arguments) -> None:
    status = Status[given["status"].upper()]

    def hook(called: str) -> Status | None:
        if called != "update":
            return None
        for name, value in given["fields"].items():
            setattr(getattr(node, "behaviour", node), name, value)
        return status

    node = _hook(fault, given["leaf"], hook)


def _hook(fault: FaultInstance, leaf: str, hook: CallHook) -> Hooked:
    """Call a hook before each method of a leaf, until the end of a fault; return the leaf."""
    node = fault.run.find(leaf)
    if node.children:
        leaves = [
            tree_node.name
            for tree_node in fault.run.robot_run.executive.nodes
            if not tree_node.children
        ]
        raise no_such("leaf", leaf, leaves)
    if not isinstance(node, Hooked):
        raise ScenarioError(
            f"{fault.fault.what}: '{leaf}' is inside a behaviour written in Python; name that"
        )
    node.call_hooks = (hook, *node.call_hooks)
    fault.undo(lambda: node.remove_call_hook(hook))
    return node


def _raise_in_callback(fault: FaultInstance, given: Arguments) -> None:
    node = fault.node(given["node"])
    name, side = _callback(node, given["name"])

    def tap(fault: FaultInstance, passing: Passing) -> Fates:
        if fault.ends_at_call(given["on"]):
            raise _error(given)
        return passed(fault, passing)

    fault.tap(name, side, tap, node.get_fully_qualified_name())


def _callback(node: Node, name: str) -> tuple[str, Side]:
    """Find what wakes a node under a name."""
    full = node.resolve_topic_name(name)
    topics = {subscription.topic_name for subscription in node.subscriptions}
    services = {service.service_name for service in node.services}
    if full not in topics | services:
        what = f"topic or service of {node.get_fully_qualified_name()}"
        raise no_such(what, full, sorted(topics | services))
    return full, Side.MESSAGE if full in topics else Side.REQUEST


def _drawn_status(draws: Draws, drawable: Drawable) -> Arguments:
    status = one_of(draws, ("failure", "success", "running"))
    return {"leaf": one_of(draws, drawable.leaves), "status": status}


def _drawn_leaf(draws: Draws, drawable: Drawable) -> Arguments:
    method = one_of(draws, ("update", "initialise", "terminate"))
    return {"leaf": one_of(draws, drawable.leaves), "method": method}


# ---- rows --------------------------------------------------------------------------------------


def _service(name: str, text: str, effect: Effect, *own: Parameter, **options: Any) -> FaultKind:
    return FaultKind(name, text, effect, (SERVICE, *own), "Services", "servers", **options)


def _code(name: str, text: str, effect: Effect, *declared: Parameter, **options: Any) -> FaultKind:
    return FaultKind(name, text, effect, declared, "Code", "code", **options)


def _method(usual: str, *choices: str) -> Parameter:
    return Parameter("method", "text", default=usual, choices=choices, by_name=True)


LEAF = Parameter("leaf", "text", "Its name or path.", names="leaf")

ROWS = (
    FaultKind(
        "abort_goal",
        "The running goal, or else the next, is aborted. The shipped servers stop the robot first.",
        _abort,
        (
            ACTION,
            Parameter("code", "integer", "The `error_code` of the result.", 0),
            Parameter("message", "text", "The `error_msg` of the result.", ""),
            Parameter("when", "python", default=None, by_name=True, takes=Callable),
        ),
        "Action servers",
        "servers",
    ),
    FaultKind(
        "kill_server",
        "The node disappears from the graph. At the end of the fault it returns without its goals.",
        _kill,
        (ACTION,),
        "Action servers",
        "servers",
    ),
    _service(
        "delay_service",
        "Responses are late, the work is done in time.",
        on(service(Side.RESPONSE), late),
        seconds("by", drawn=period(0.1, 1.5, 0.1)),
    ),
    _service("ignore_service", "Requests are lost.", on(service(Side.REQUEST), lose)),
    _service(
        "fail_service",
        "Nothing is done, and the response has these fields.",
        on(service(Side.REQUEST), _fail),
        takes_fields=True,
    ),
    FaultKind(
        "serve",
        "The service has a server that returns these fields, if it has no other.",
        _serve,
        (replace(SERVICE, names=""),),
        "Services",
        "scripts",
        takes_fields=True,
    ),
    _code(
        "raise_in_leaf",
        "An exception is raised in a leaf of the tree.",
        _raise_in_leaf,
        LEAF,
        ERROR,
        _method("update", "initialise", "update", "terminate"),
        ON,
        draw=_drawn_leaf,
        waits=True,
    ),
    FaultKind(
        "return_status",
        "A leaf returns this status, and its `update` is not called. Fields are attributes of a "
        "leaf in Python, such as its outputs.",
        _return_status,
        (LEAF, Parameter("status", "text", choices=("success", "failure", "running"))),
        "Code",
        "scripts",
        takes_fields=True,
        draw=_drawn_status,
    ),
    _code(
        "raise_in_maneuver",
        "An exception is raised in the maneuver of one of the shipped action servers.",
        _raise_in_maneuver,
        ACTION,
        ERROR,
        _method("step", "step", "feedback", "result"),
        replace(ON, drawn=whole(1, 20)),
    ),
    _code(
        "raise_in_callback",
        "An exception is raised in a callback of a node, which ends the mission on the stage.",
        _raise_in_callback,
        Parameter("node", "text", names="node", drawn=always("bt_mission_servers")),
        Parameter(
            "name",
            "text",
            "Of a topic that the node subscribes to, or of a service that it offers.",
            drawn=any_of("scan", "odom", "stop"),
        ),
        ERROR,
        replace(ON, drawn=whole(1, 20)),
    ),
)
