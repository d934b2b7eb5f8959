"""The units of the fields of ROS interfaces: what `10 cm` becomes there.

Only comments of this project count. A changed comment of somebody else's changes no mission.

ROS itself is not needed: the files are those that interface packages install.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache

from bt_mission.base.interface_files import file_text, share_folders
from bt_mission.language.interface_comments import InterfaceText, read_interface

SI = "SI"
"""The unit of a field in a package that keeps to REP 103."""

REP_103 = frozenset(
    ("control_msgs", "geometry_msgs", "nav2_msgs", "nav_msgs", "sensor_msgs", "trajectory_msgs")
)
"""Packages whose numbers are in metres, seconds and radians by default."""

OWN = "bt_mission_interfaces"
"""The package whose comments begin with the unit of the field."""

_IN_DEGREES = frozenset(
    (("sensor_msgs/msg/NavSatFix", "latitude"), ("sensor_msgs/msg/NavSatFix", "longitude"))
)
"""Fields of packages of REP 103 whose angles are in degrees."""

PARTS = {"goal": 0, "result": 1, "feedback": 2, "request": 0, "response": 1, "message": 0}
"""The sections of interface files."""

_TIMES = frozenset(("builtin_interfaces/Duration", "builtin_interfaces/Time", "duration", "time"))
POSE = "geometry_msgs/PoseStamped"
POSE_AXES = ("x", "y", "yaw")
"""The keys of a pose that is written as a mapping of numbers."""

_LISTS = {
    POSE: ("m", "m", "deg"),
    "geometry_msgs/Point": ("m", "m", "m"),
}
"""Messages that missions write as lists, with the units of the numbers there."""
_TEXTS = ("string", "wstring")


@dataclass(frozen=True)
class FieldType:
    """The type of a field in an interface file.

    Attributes:
        name: Its type, such as `float32` or `geometry_msgs/PoseStamped[]`; empty if unknown.
        unit: The unit that its own file declares; empty without one.
        interface: The full name of the type of its file.
    """

    name: str
    unit: str
    interface: str


@lru_cache(maxsize=4096)
def type_of_field(type_name: str, part: str, path: tuple[str | int, ...]) -> FieldType:
    """Return the type of a field, by its path.

    Args:
        type_name: Such as `bt_mission_interfaces/action/Turn`.
        part: One of `PARTS`.
        path: The names that lead to the field, and the indices in lists.
    """
    interface, section, unit = type_name, PARTS[part], ""
    written = ""
    for step in path:
        name, is_list, _ = written.partition("[")
        if isinstance(step, int):
            if not is_list and name in _LISTS and step < 3:
                return FieldType("float64", _LISTS[name][step], interface)
            written = name
            continue
        if name == POSE and not is_list and step in POSE_AXES:
            return FieldType("float64", _LISTS[POSE][POSE_AXES.index(step)], interface)
        if written:
            interface, section = _message(name, interface), 0
        part_section = interface_of(interface).section(section)
        written = _full(part_section.types.get(step, ""), interface)
        if interface.partition("/")[0] == OWN:
            unit = part_section.remark(step).unit or unit
        elif (interface, step) in _IN_DEGREES:
            unit = "deg"
    return FieldType(written, unit, interface)


def unit_of_field(type_name: str, part: str, path: tuple[str | int, ...]) -> str | None:
    """Return the unit of a field: `SI` by REP 103, empty if it is not known.

    The arguments are those of `type_of_field`. A text field has None.
    """
    found_type = type_of_field(type_name, part, path)
    name, interface, unit = found_type.name.partition("[")[0], found_type.interface, found_type.unit
    if name.partition("<")[0] in _TEXTS:
        return None
    if name in _TIMES:
        return "s"
    is_si = interface.partition("/")[0] in REP_103 or name.partition("/")[0] in REP_103
    return unit or (SI if is_si else "")


@cache
def interface_of(name: str) -> InterfaceText:
    """Return the comments in the file of an interface, by its full name; empty without it."""
    text = file_text(name, share_folders()) if name.count("/") == 2 else None
    return InterfaceText("", ()) if text is None else read_interface(text)


def _full(written: str, interface: str) -> str:
    """Return the type of a field with its package: `Vector3` in geometry_msgs is of there."""
    is_message = written[:1].isupper() and "/" not in written
    return f"{interface.partition('/')[0]}/{written}" if is_message else written


def _message(name: str, interface: str) -> str:
    """Return the full name of a message; raises if a field is not a message."""
    package, _, short = name.partition("/")
    return f"{package}/msg/{short}" if short else interface.partition("/")[0]
