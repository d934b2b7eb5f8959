"""The common part of all kinds of node: their written values, and the facts about a kind.

A kind of node is one class. Its fields are what a person writes, the key that names the kind as
the alias of one of them, and its methods tell what else is to be known of it: the values that it
reads, the variables that it writes, how it can end, and what it is called. Checks, drawings and
the builder of behaviours ask the class; `registry.KINDS` lists them all.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from operator import attrgetter
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Literal,
    NamedTuple,
    Self,
    TypeAlias,
    TypeVar,
    get_args,
    get_origin,
)

from pydantic import BaseModel, ConfigDict, Field, WithJsonSchema
from pydantic.json_schema import SkipJsonSchema
from pydantic_core.core_schema import CoreSchema, any_schema
from typing_extensions import override

from bt_mission.base.diagnostics import MOST_DIAGNOSTICS, Diagnostic
from bt_mission.base.yaml.document import Document
from bt_mission.language.expressions.expression import Expression, Value, written_text
from bt_mission.language.expressions.places import Places
from bt_mission.language.expressions.values import Type
from bt_mission.language.goal_limits import GoalLimitsTable
from bt_mission.language.nodes.fields import Line, NumberRule, Reads

Key = str | int
Path = tuple[Key, ...]

Ends = frozenset[str]
"""How a node can end: "success", "failure", both, or not at all."""

EITHER: Ends = frozenset({"success", "failure"})
SUCCESS: Ends = frozenset({"success"})
FAILURE: Ends = frozenset({"failure"})

NODE_MARK, TREE_MARK = "x-node", "x-tree"
"""Placeholders in a schema for a node and the definition of a tree (`schema.py`)."""


class Unchecked:
    """Marks a field that has been read already: pydantic takes it as it is.

    Unlike its `SkipValidation` it builds nothing for the type of the field.
    """

    def __get_pydantic_core_schema__(self, _type: Any, _handler: Any) -> CoreSchema:
        """Return the schema of anything."""
        return any_schema()


NODE_SCHEMA = WithJsonSchema({NODE_MARK: True})

WrittenNode = Annotated[Any, NODE_SCHEMA]
"""A node that is not read yet: of whole files, the reader takes the nodes one by one."""

Trees = Annotated[Any, WithJsonSchema({TREE_MARK: True})]


class Written(BaseModel):
    """What all models of the mission file share: strict, frozen, no unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, defer_build=True)


@dataclass(frozen=True, slots=True)
class NodePlace:
    """Where a node stands: `line` and `column` count from 1, `path` leads there in its document."""

    line: int = 0
    column: int = 0
    path: Path = ()


class InFile:
    """A part of a file that knows its place."""

    if TYPE_CHECKING:

        @property
        def place(self) -> NodePlace:
            """Where it stands."""

    @property
    def line(self) -> int:
        """The line of its first key, from 1."""
        return self.place.line

    @property
    def column(self) -> int:
        """The column of its first key, from 1."""
        return self.place.column


class Read(NamedTuple):
    """A value of a node, which may read variables, and where it stands below the node.

    `wanted` is the rule of a number, or the type of another value; None where every type will do.
    `assigns` is the variable that the value goes to before the next one of the node is read.
    `is_behind`: it is read after the nodes below have run.
    """

    path: Path
    value: Value
    wanted: NumberRule | Type | None = None
    assigns: str | None = None
    is_behind: bool = False


class Write(NamedTuple):
    """A variable that a node writes, and where that stands below the node.

    Its type is that of the `value`, or that of a field of a message, or this `type`.
    """

    path: Path
    variable: str
    what: Literal["output", "variable"] = "output"
    value: Value | None = None
    type: Type | None = None


@dataclass
class Reading:
    """The context in which the nodes of a document are read, and their errors.

    `signatures` are the named trees that may be used (`node_reader.Signature`), `limits` what the
    mission says of goals, `places` are the named ones on the map.
    """

    document: Document
    signatures: Mapping[str, Any] = field(default_factory=dict)
    limits: GoalLimitsTable = field(default_factory=GoalLimitsTable)
    places: Places = field(default_factory=Places)
    diagnostics: list[Diagnostic] = field(default_factory=list)

    def report(
        self,
        code: str,
        path: Path,
        message: str,
        hint: str | None = None,
        *,
        key: bool = False,
        offset: int | None = None,
    ) -> None:
        """Note a diagnostic at a value, at an offset in its text, or at its key."""
        self.diagnostics.append(
            self.document.diagnostic(code, path, message, hint, key=key, offset=offset)
        )

    @property
    def is_full(self) -> bool:
        """Whether the most diagnostics that are shown have been noted."""
        return len(self.diagnostics) >= MOST_DIAGNOSTICS


Content = TypeVar("Content")

Hidden: TypeAlias = Annotated[Content, Unchecked(), SkipJsonSchema()]
"""A field that the reader fills and no person writes."""

HIDDEN = "@"
"""Begins the keys of such fields."""


class Family(StrEnum):
    """Families of kinds look alike."""

    COMPOSITE = "composite"
    DECORATOR = "decorator"
    CONDITION = "condition"
    ACTION = "action"
    MESSAGE = "message"
    SUBTREE = "subtree"
    OTHER = "other"


@dataclass(frozen=True)
class Sign:
    """How a kind of node is marked, without colour: a glyph, its form in ASCII, and a phrase."""

    glyph: str
    ascii: str
    words: str
    family: Family


class NodeModel(InFile, Written):
    """A node's modifiers that every kind takes."""

    kind: ClassVar[str]
    sign: ClassVar[Sign]
    keys: ClassVar[tuple[str, ...]] = ("name",)
    """The valid keys of a node of this kind."""
    read_fields: ClassVar[tuple[tuple[Path, Callable[[Any], Any], Reads], ...]] = ()
    """The fields that may read variables: the path of each, what gets it, and how it is marked."""
    always: ClassVar[Ends] = EITHER
    """How it can end, where that depends on nothing; a goal may always end either way."""
    takes_time: ClassVar[bool] = False
    """Whether it can take more than a tick."""
    child_keys: ClassVar[tuple[str, ...]] = ()
    """The keys that hold one node each."""
    fixed: ClassVar[tuple[str, ...]] = ()
    """The values that are fixed once its tree is built, besides kind, name and the nodes below it.

    Everything else is read when it begins.
    """

    name: Line = ""
    place: Hidden[NodePlace] = Field(NodePlace(), alias="@place", repr=False)

    # ---- the form of the kind ------------------------------------------------------------

    @classmethod
    @override
    def __pydantic_init_subclass__(cls, **_kwargs: Any) -> None:
        names = (info.alias or name for name, info in cls.model_fields.items())
        cls.keys = tuple(name for name in names if not name.startswith(HIDDEN))
        cls.read_fields = tuple(_read_fields(cls))

    @classmethod
    def is_kind(cls) -> bool:
        """Return whether it is a kind of node, rather than the base of several."""
        return getattr(cls, "kind", None) in cls.keys

    @classmethod
    def written_children(cls, data: Mapping[str, Any]) -> Iterator[tuple[Path, Any]]:
        """Yield the nodes directly inside a written node, each with its path in it."""
        for key in cls.child_keys:
            if key in data:
                yield (key,), data[key]

    def completed(self, _reading: Reading) -> Self:
        """Return the node with what the rest of the mission says of it.

        Contradictions between the parts of a node become diagnostics.
        """
        return self

    # ---- where it stands -----------------------------------------------------------------

    @property
    def path(self) -> Path:
        """The keys and indices that lead to it in its document."""
        return self.place.path

    @property
    def below(self) -> "tuple[NodeModel, ...]":
        """The nodes directly below this one."""
        return ()

    @property
    def frame(self) -> tuple[object, ...]:
        """The values of `fixed`."""
        return (self.kind, self.name, *(getattr(self, name) for name in self.fixed))

    def walk(self) -> "Iterator[NodeModel]":
        """Yield this node and all below it, in the order of the file."""
        waiting: list[NodeModel] = [self]
        while waiting:
            node = waiting.pop()
            yield node
            waiting.extend(reversed(node.below))

    # ---- what is to be known of the kind -------------------------------------------------

    def reads(self) -> Iterator[Read]:
        """Yield the values that may read variables, those for ROS messages left out."""
        for path, get, mark in self.read_fields:
            value = get(self)
            if isinstance(value, dict):
                yield from (Read((*path, key), item, mark.wanted) for key, item in value.items())
            elif value is not None:
                yield Read(path, value, mark.wanted)

    def writes(self) -> Iterator[Write]:
        """Yield the variables that it writes."""
        yield from ()

    def ends(self, _below: list[Ends]) -> Ends:
        """Return how it can end, from how those below it can."""
        return self.always

    def endless(self) -> str | None:
        """The part that can run forever without a `timeout`, as a phrase, or None."""
        return None

    @property
    def label(self) -> str:
        """Its name in the tree."""
        return self.name or self.default_label()

    def default_label(self) -> str:
        """Its name if its author gives none."""
        return self.kind

    def details(self) -> list[str]:
        """Return what it does, in order of importance, in the words of its author."""
        return []


def _read_fields(
    model: type[Written], path: Path = (), names: tuple[str, ...] = ()
) -> Iterator[tuple[Path, Callable[[Any], Any], Reads]]:
    """Yield the marked fields of a model, and of the models in it that are no nodes."""
    for name, info in model.model_fields.items():
        place, within = (*path, info.alias or name), (*names, name)
        kind: Any = info.annotation
        parts = get_args(kind)[1:] if get_origin(kind) is dict else ()
        for mark in (
            *info.metadata,
            *(metadata for part in parts for metadata in part.__metadata__),
        ):
            if isinstance(mark, Reads):
                yield place, attrgetter(".".join(within)), mark
        if isinstance(kind, type) and issubclass(kind, Written) and kind is not NodeModel:
            yield from _read_fields(kind, place, within)


Child = Annotated[NodeModel, Unchecked(), NODE_SCHEMA]
MaybeChild = Annotated[NodeModel | None, Unchecked(), NODE_SCHEMA]
Children = Annotated[tuple[Child, ...], Field(min_length=1, strict=False)]


class CompositeNode(NodeModel):
    """A node with a list of nodes below it."""

    if TYPE_CHECKING:
        children: Children

    @classmethod
    @override
    def written_children(cls, data: Mapping[str, Any]) -> Iterator[tuple[Path, Any]]:
        parts = data.get(cls.kind)
        if isinstance(parts, list):
            yield from (((cls.kind, index), part) for index, part in enumerate(parts))

    @property
    @override
    def below(self) -> tuple[NodeModel, ...]:
        return self.children


class DecoratorNode(NodeModel):
    """A node with one below it."""

    child_keys: ClassVar[tuple[str, ...]] = ("do",)

    if TYPE_CHECKING:
        child: Child

    @property
    @override
    def below(self) -> tuple[NodeModel, ...]:
        return (self.child,)

    @override
    def ends(self, below: list[Ends]) -> Ends:
        return below[0]


class ConditionalNode(NodeModel):
    """A node that asks a condition on variables; a constant holds always or never."""

    if TYPE_CHECKING:
        condition: Expression | bool

    @override
    def default_label(self) -> str:
        return f"{self.kind} {written_text(self.condition)}"

    @override
    def details(self) -> list[str]:
        return [written_text(self.condition)] if self.name else []


class OutputsNode(NodeModel):
    """A node with results; `outputs` names the variable that each of them goes to."""

    takes_time: ClassVar[bool] = True

    if TYPE_CHECKING:
        outputs: dict[str, str]

    @override
    def writes(self) -> Iterator[Write]:
        for source, variable in self.outputs.items():
            yield Write(("outputs", source), variable)

    def shown_outputs(self) -> list[str]:
        """Return the outputs as a drawing shows them."""
        return [f"{variable} := {source}" for source, variable in self.outputs.items()]


def shown_fields(values: Mapping[str, Any]) -> list[str]:
    """Return fields of a message or inputs as a drawing shows them."""
    return [f"{name} {written_text(value)}" for name, value in values.items()]


def shown_limit(timeout: Value | None) -> list[str]:
    """Return a limit in seconds as a drawing shows it."""
    return [] if timeout is None else [f"within {written_text(timeout)} s"]
