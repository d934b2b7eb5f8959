"""A Python leaf that answers as the run of the oracle says."""

from __future__ import annotations

from typing import Any, ClassVar

from py_trees.behaviour import Behaviour
from py_trees.common import Status


class Answering(Behaviour):
    """Ends, continues or raises an exception at random; its attributes are random, too.

    Attributes:
        source: The run that answers.
    """

    source: ClassVar[Any] = None

    amount: float = 0.0
    flag: bool = False
    word: str = ""
    number: int = 0

    def update(self) -> Status:
        """Ask the run."""
        values = self.source.values
        self.amount, self.number = values.of("double"), values.of("int32")
        self.flag, self.word = values.of("boolean"), values.of("string")
        status: Status = self.source.answer_of_leaf()
        return status
