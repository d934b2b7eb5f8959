"""Mutated mission files: checked, and run where they are sound."""

from __future__ import annotations

from collections.abc import Iterator

from tests.support.fuzz import cases, verdict
from tests.support.fuzz.finding import Case
from tests.support.fuzz.targets import Target


def _samples(samples: cases.Corpus) -> Iterator[Case]:
    for name, texts in (("m.yaml", samples.texts), ("m.xml", samples.xml)):
        yield from (Case(name, text.encode()) for text in texts)


TARGET = Target(cases.corpus, _samples, cases.case, verdict.judge, cases.prepare)
