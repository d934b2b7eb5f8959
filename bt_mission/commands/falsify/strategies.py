"""Which candidates are tried next."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import partial
from typing import Any, Protocol

from bt_mission.base.errors import BtMissionError
from bt_mission.commands.falsify.candidate import Candidate
from bt_mission.commands.falsify.space import PartDraws
from bt_mission.scenarios.draws import SeededDraws

BATCH = 16
"""The number of candidates in a batch, independent of the number of workers, so that a search can
be repeated.
"""


class Space(Protocol):
    """The source of candidates."""

    def draw(self, parts: PartDraws, /) -> Candidate:
        """Draw a candidate; equal draws give equal candidates."""


class Strategy(Protocol):
    """Chooses candidates, and learns from the scores of their runs."""

    def ask(self, count: int) -> Sequence[Candidate]:
        """Return the next candidates."""

    def learn(self, scores: Sequence[float]) -> None:
        """Learn the scores of the last candidates, in order: from 1, far, to -1, a failure."""


class RandomStrategy:
    """Draws each candidate independently.

    Args:
        space: All candidates.
        seed: The same seed gives the same candidates.
    """

    def __init__(self, space: Space, seed: int) -> None:
        self._space = space
        self._seed = seed
        self._count = 0

    def ask(self, count: int) -> Sequence[Candidate]:
        """Return the next candidates."""
        first, self._count = self._count, self._count + count
        return [
            self._space.draw(lambda part, n=n: SeededDraws(f"{self._seed}/{n}/{part}"))  # type: ignore[misc]
            for n in range(first, self._count)
        ]

    def learn(self, scores: Sequence[float]) -> None:
        """Ignore the scores."""


class OptunaStrategy:
    """Draws by optuna's TPE: more often where runs came near to a failure.

    J. Bergstra, R. Bardenet, Y. Bengio, B. Kégl: "Algorithms for Hyper-Parameter Optimization",
    NeurIPS 2011.

    Args:
        space: All candidates.
        seed: The same seed and scores give the same candidates.
    """

    def __init__(self, space: Space, seed: int) -> None:
        try:
            import optuna
        except ImportError as error:
            raise BtMissionError(
                f"the package optuna cannot be imported ({error}); pip install 'bt-mission[sweep]'",
                code="BT-905",
            ) from error
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of what is experimental in it
            sampler = optuna.samplers.TPESampler(seed=seed % 2**32, constant_liar=True)
        self._study = optuna.create_study(sampler=sampler)
        self._space = space
        self._trials: list[Any] = []

    def ask(self, count: int) -> Sequence[Candidate]:
        """Return the next candidates."""
        self._trials = [self._study.ask() for _ in range(count)]
        return [self._space.draw(partial(_TrialDraws, trial)) for trial in self._trials]

    def learn(self, scores: Sequence[float]) -> None:
        """Learn the scores of the last candidates."""
        for trial, score in zip(self._trials, scores, strict=False):
            self._study.tell(trial, score)


FEW = 30
"""Up to this number of choices, they count as names rather than as neighbouring numbers."""


class _TrialDraws:
    """Draws a part by the trial of a study; a part with other choices is another parameter."""

    def __init__(self, trial: Any, part: str) -> None:
        self._trial = trial
        self._part = part
        self._count = 0

    def whole(self, low: int, high: int) -> int:
        self._count += 1
        name = f"{self._part}/{self._count}/{low}..{high}"
        if high - low < FEW:
            return int(self._trial.suggest_categorical(name, list(range(low, high + 1))))
        return int(self._trial.suggest_int(name, low, high))
