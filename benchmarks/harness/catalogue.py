"""All benchmarks: how each is started, what its figures are called, and what they must come to."""

from __future__ import annotations

from benchmarks.harness.campaigns import CAMPAIGNS, COMMANDS, SAFETY
from benchmarks.harness.runs import EXECUTIVE, ON_THE_STAGE, RECORDINGS

CATALOGUE = (*ON_THE_STAGE, *COMMANDS, *EXECUTIVE, *RECORDINGS, *CAMPAIGNS, *SAFETY)
