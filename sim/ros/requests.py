"""Requests of the standard interfaces of simulators: offers, answers and refusals."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from rclpy.node import Node

from bt_mission.base.errors import BtMissionError
from bt_mission.base.text import escape_control
from sim.ros.run_control import RunControl, RunState
from sim.ros.topics import REQUESTS

_MOST_TEXT = 2000
"""Characters of a response's text."""


class Code(IntEnum):
    """The result of a request: simulation_interfaces/Result."""

    FEATURE_UNSUPPORTED = 0
    OK = 1
    NOT_FOUND = 2
    INCORRECT_STATE = 3
    OPERATION_FAILED = 4


class Feature(IntEnum):
    """The features of a simulator: simulation_interfaces/SimulatorFeatures."""

    SPAWNING = 0
    DELETING = 1
    NAMED_POSES = 2
    POSE_BOUNDS = 3
    ENTITY_TAGS = 4
    ENTITY_BOUNDS = 5
    ENTITY_BOUNDS_BOX = 6
    ENTITY_CATEGORIES = 8
    SPAWNING_RESOURCE_STRING = 9
    ENTITY_STATE_GETTING = 10
    ENTITY_STATE_SETTING = 11
    ENTITY_INFO_GETTING = 12
    ENTITY_INFO_SETTING = 13
    SPAWNABLES = 14
    SIMULATION_RESET = 20
    SIMULATION_RESET_TIME = 21
    SIMULATION_RESET_STATE = 22
    SIMULATION_RESET_SPAWNED = 23
    SIMULATION_STATE_GETTING = 24
    SIMULATION_STATE_SETTING = 25
    SIMULATION_STATE_PAUSE = 26
    STEP_SIMULATION_SINGLE = 31
    STEP_SIMULATION_MULTIPLE = 32
    STEP_SIMULATION_ACTION = 33
    WORLD_INFO_GETTING = 44
    AVAILABLE_WORLDS = 45
    SPAWNING_ENTITIES = 50


class RefusedError(BtMissionError):
    """A request that is refused.

    Args:
        code: One of `Code`, or of the service's own codes.
        text: Why, and what to do.
    """

    code = "BT-808"

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.result_code = int(code)


@dataclass(frozen=True, slots=True)
class Offer:
    """A service: its type in simulation_interfaces, and the function that fills its response.

    Args:
        kind: The name of the type; that of the service is the same in small letters.
        answer: Gets request and response; `result` is OK unless it raises.
        features: The features of the simulator that it provides.
    """

    kind: str
    answer: Callable[[Any, Any], None]
    features: tuple[Feature, ...] = ()


def offer(node: Node, control: RunControl, types: Any, offers: Iterable[Offer]) -> list[Feature]:
    """Create the services whose types are in the module `types`, and return their features."""
    features: list[Feature] = []
    for service in offers:
        kind = getattr(types, service.kind, None)  # an older release has fewer
        if kind is not None:
            name = service_name(service.kind)
            node.create_service(kind, name, _guarded(control, service.answer), qos_profile=REQUESTS)
            features += service.features
    return features


def service_name(kind: str) -> str:
    """Return a service's name among those of the node, such as ~/get_entities.

    >>> service_name("GetEntities")
    '~/get_entities'
    """
    return "~/" + re.sub("(?<!^)(?=[A-Z])", "_", kind).lower()


def refuse_while_quitting(control: RunControl) -> None:
    """Raise RefusedError where the simulator is about to end."""
    if control.state is RunState.QUITTING:
        raise RefusedError(Code.INCORRECT_STATE, "the simulator is ending")


def fill_result(result: Any, code: int, text: str = "") -> Any:
    """Fill a Result with what may be shown anywhere, and return it."""
    result.result = int(code)
    result.error_message = escape_control(text)[:_MOST_TEXT]
    return result


def _guarded(control: RunControl, answer: Callable[[Any, Any], None]) -> Callable[[Any, Any], Any]:
    def call(request: Any, response: Any) -> Any:
        try:
            refuse_while_quitting(control)
            response.result.result = int(Code.OK)
            answer(request, response)
        except BtMissionError as error:
            code = error.result_code if isinstance(error, RefusedError) else Code.OPERATION_FAILED
            response = type(response)()
            fill_result(response.result, code, str(error))
        return response

    return call
