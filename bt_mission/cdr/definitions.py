"""Message definitions as bags carry them, gathered from the installed interface packages.

A definition is the text of the message's ``.msg`` file and, after a line of 80 ``=`` and one that
names it (``MSG: package/Type``), the text of each nested message; MCAP calls this encoding
``ros2msg``. The messages of ``.srv`` and ``.action`` files have no files: their text is put
together here as ``rosidl`` does it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from bt_mission.base.errors import BtMissionError
from bt_mission.base.interface_files import file_text, share_folders

SEPARATOR = "=" * 80

BASIC = frozenset(
    f"{kind}{bits}" for kind in ("int", "uint", "float") for bits in (8, 16, 32, 64)
) | {"bool", "byte", "char", "string", "wstring"}
"""Types that are made of no others."""

_FIELD = re.compile(
    r"^\s*(?P<type>[A-Za-z][\w/]*)(?:<=\d+)?(?P<array>\[(?P<most><=)?(?P<size>\d*)\])?"
    r"\s+(?P<name>[A-Za-z]\w*)\s*(?P<constant>=)?"
)
_MADE_TYPE = re.compile(r"\b([a-z]\w*/)([A-Z][A-Za-z0-9]*(?:_[A-Z][A-Za-z0-9]*)+)\b")
MOST_DIGITS = 18
"""Of the length of an array."""

_DIVIDER = re.compile(r"^---\s*$", re.MULTILINE)
_GOAL_ID = "unique_identifier_msgs/UUID goal_id\n"

_ACTION_PARTS: dict[str, Callable[[str, str], str]] = {
    "_FeedbackMessage": lambda p, n: f"{_GOAL_ID}{p}/{n}_Feedback feedback\n",
    "_SendGoal_Request": lambda p, n: f"{_GOAL_ID}{p}/{n}_Goal goal\n",
    "_SendGoal_Response": lambda _p, _n: "bool accepted\nbuiltin_interfaces/Time stamp\n",
    "_GetResult_Request": lambda _p, _n: _GOAL_ID,
    "_GetResult_Response": lambda p, n: f"int8 status\n{p}/{n}_Result result\n",
}
_SECTIONS = {"srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}


@dataclass(frozen=True)
class Field:
    """A field of a message; `size` is None for one value, -1 for any number of them."""

    name: str
    type: str
    size: int | None


class NoDefinitionError(BtMissionError):
    """The files of a type are not installed here."""

    code = "BT-501"


class Definitions:
    """Finds definitions in some folders of interface packages.

    Args:
        folders: Each has one folder a package, with ``msg``, ``srv`` and ``action``.
    """

    def __init__(self, folders: Sequence[Path]) -> None:
        self._folders = folders
        self._text = cache(self._find)

    def of(self, type_name: str) -> str:
        """The whole definition of a type, such as ``nav_msgs/msg/Odometry``.

        Also of what services and actions are made of: ``nav2_msgs/action/Spin_FeedbackMessage``,
        ``nav2_msgs/action/Spin_SendGoal_Event``, ``std_srvs/srv/Trigger_Request``.

        Raises:
            NoDefinitionError: When a file that is needed is not there.
        """
        outer = _short(type_name)
        parts = [self._text(outer).rstrip("\n")]
        seen = {outer}
        queue = _references(parts[0], outer)
        while queue:
            inner = queue.pop(0)
            if inner in seen:
                continue
            seen.add(inner)
            text = self._text(inner).rstrip("\n")
            parts.append(f"{SEPARATOR}\nMSG: {inner}\n{text}")
            queue += _references(text, inner)
        return "\n".join(parts) + "\n"

    def _find(self, type_name: str) -> str:
        package, _, name = type_name.partition("/")
        text = file_text(f"{package}/msg/{name}", self._folders)
        if text is None:
            text = self._made(package, name)
        if text is None:
            raise NoDefinitionError(f"the definition of {type_name} is not installed")
        return text

    def _made(self, package: str, name: str) -> str | None:
        """The text of a message that rosidl makes of a service or of an action."""
        if name.endswith("_Event"):
            base = name.removesuffix("_Event")
            return (
                "service_msgs/ServiceEventInfo info\n"
                f"{package}/{base}_Request[<=1] request\n{package}/{base}_Response[<=1] response\n"
            )
        for suffix, make in _ACTION_PARTS.items():
            if name.endswith(suffix):
                return make(package, name.removesuffix(suffix))
        base, _, part = name.rpartition("_")
        for folder, parts in _SECTIONS.items():
            if part in parts:
                text = file_text(f"{package}/{folder}/{base}", self._folders)
                if text is not None:
                    return _DIVIDER.split(text)[parts.index(part)].lstrip("\n")
        return None


@cache
def _installed() -> Definitions:
    return Definitions(share_folders())


@cache
def definition_of(type_name: str) -> str:
    """Return the whole definition of an installed type, such as ``nav_msgs/msg/Odometry``.

    Raises:
        NoDefinitionError: It is not installed.
    """
    return _installed().of(type_name)


def with_plain_names(type_name: str, definition: str) -> tuple[str, str]:
    """Name a type, and those that it is made of, as every reader of definitions takes it.

    What rosidl makes of services and actions has names with ``_`` in ``srv`` and ``action``.
    Parsers of message definitions take ``[A-Z][A-Za-z0-9]*`` in ``msg`` alone, so
    ``nav2_msgs/action/Spin_FeedbackMessage`` becomes ``nav2_msgs/msg/SpinFeedbackMessage``. The
    messages stay the same, byte for byte.
    """
    package, _, name = type_name.partition("/")
    if "_" not in name:
        return type_name, definition
    plain = name.rpartition("/")[2].replace("_", "")
    text = _MADE_TYPE.sub(lambda match: match[1] + match[2].replace("_", ""), definition)
    return f"{package}/msg/{plain}", text


def action_of(type_name: str) -> str:
    """Return the action whose goals an event of ``send_goal`` is about, however it is named."""
    if type_name.endswith("_SendGoal_Event"):
        return type_name.removesuffix("_SendGoal_Event")
    return type_name.removesuffix("SendGoalEvent").replace("/msg/", "/action/")


def parse(type_name: str, definition: str) -> dict[str, list[Field]]:
    """Return the fields of each message of a definition, by ``package/Name``; the first is "".

    Types are ``package/Name``, too, or basic ones.
    """
    package = type_name.partition("/")[0]
    definitions: dict[str, list[Field]] = {}
    for part in definition.split(f"\n{SEPARATOR}\n"):
        first, _, rest = part.partition("\n")
        name, text = "", part
        if first.startswith("MSG: "):
            name, text = _short(first.removeprefix("MSG: ").strip()), rest
        here = name.partition("/")[0] or package
        definitions[name] = [field for line in text.splitlines() for field in _fields(line, here)]
    return definitions


def _fields(line: str, package: str) -> list[Field]:
    match = _FIELD.match(line)
    if match is None or match["constant"]:
        return []
    kind = match["type"]
    if kind not in BASIC:
        kind = _short(kind) if "/" in kind else _local(kind, package)
    size = None
    if match["array"]:
        size = -1 if match["most"] or not match["size"] else _length(match["size"])
    return [Field(match["name"], kind, size)]


def _length(digits: str) -> int:
    if len(digits) > MOST_DIGITS:
        raise ValueError(f"an array of a length of {len(digits)} digits")
    return int(digits)


def _local(name: str, package: str) -> str:
    return "std_msgs/Header" if name == "Header" else f"{package}/{name}"


def _short(name: str) -> str:
    """`package/Name` of `package/msg/Name`."""
    return f"{name.partition('/')[0]}/{name.rpartition('/')[2]}"


def _references(text: str, type_name: str) -> list[str]:
    """Return the types of the fields of a message's text, as ``package/Name``."""
    package = type_name.partition("/")[0]
    fields = [field for line in text.splitlines() for field in _fields(line, package)]
    return [field.type for field in fields if field.type not in BASIC]
