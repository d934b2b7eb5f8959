"""Our leaves and decorators tick and stop exactly as py_trees' behaviours do."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import product
from types import SimpleNamespace
from typing import Any, cast

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.decorators import Decorator

from bt_mission.executive.behaviours.hooks import HookedDecorator
from bt_mission.executive.behaviours.leaves import Leaf

STATUSES = (Status.RUNNING, Status.SUCCESS, Status.FAILURE)


class Diary:
    """Answers with the statuses given, and writes down what is called, and its status then."""

    status: Status

    def tell(self, answers: tuple[Status, ...]) -> None:
        self.answers = list(answers)
        self.calls: list[Any] = []

    def initialise(self) -> None:
        self.calls.append(("initialise", self.status))

    def update(self) -> Status:
        self.calls.append(("update", self.status))
        return self.answers.pop(0)

    def terminate(self, new_status: Status) -> None:
        self.calls.append(("terminate", self.status, new_status))


class Ours(Diary, Leaf):
    pass


class Theirs(Diary, Behaviour):
    pass


class OurDecorator(Diary, HookedDecorator):
    pass


class TheirDecorator(Diary, Decorator):
    pass


NODE: Any = SimpleNamespace(label="leaf")


def ours() -> Ours:
    """Return a leaf of ours."""
    return Ours(NODE, cast("Any", None))


def our_decorator(child: Behaviour) -> OurDecorator:
    """Return a decorator of ours."""
    return OurDecorator(NODE, cast("Any", SimpleNamespace(children=[child])))


@pytest.mark.parametrize("halted_after", [None, 1, 2, 3])
def test_the_same_calls_at_the_same_statuses(halted_after: int | None) -> None:
    """Over every sequence of three answers, with a halt in any place."""

    def calls(leaf: Any, answers: tuple[Status, ...]) -> list[Any]:
        leaf.tell(answers)
        for number in range(1, 4):
            assert [*leaf.tick()] == [leaf]
            leaf.calls.append(leaf.status)
            if number == halted_after:
                leaf.stop(Status.INVALID)
                leaf.calls.append(leaf.status)
        return list(leaf.calls)

    for answers in product(STATUSES, repeat=3):
        assert calls(ours(), answers) == calls(Theirs("leaf"), answers)


@pytest.mark.parametrize("child", STATUSES)
@pytest.mark.parametrize("halted_after", [None, 1, 2, 3])
def test_the_same_calls_of_a_decorator(halted_after: int | None, child: Status) -> None:
    """Whatever its child comes to: the same calls, the same nodes visited, the same child's end."""

    def calls(kind: Callable[[Behaviour], Any], answers: tuple[Status, ...]) -> list[Any]:
        decorated = ours()
        decorated.tell((child,) * 3)
        node = kind(decorated)
        node.tell(answers)
        for number in range(1, 4):
            node.calls += [(visited.name, visited.status) for visited in node.tick()]
            if number == halted_after:
                node.stop(Status.INVALID)
            node.calls.append(node.status)
        return [*node.calls, *decorated.calls]

    for answers in product(STATUSES, repeat=3):
        assert calls(our_decorator, answers) == calls(partial(TheirDecorator, NODE.label), answers)


def test_it_is_ready_to_be_iterated_after_a_stop() -> None:
    """As py_trees' own, a stopped leaf holds a new iterator."""
    leaf = ours()
    leaf.tell((Status.SUCCESS,))
    leaf.stop(Status.INVALID)
    assert next(leaf.iterator).status is Status.SUCCESS
