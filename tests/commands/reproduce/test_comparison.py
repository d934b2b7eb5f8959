"""Whether a simulated run repeats a recorded one."""

from __future__ import annotations

import pytest

from bt_mission.commands.reproduce.comparison import RunComparison, RunEnd, differences

FAULT = "at 5.0: drop scan"


@pytest.mark.parametrize("missing", [(), (FAULT,)])
def test_a_run_whose_faults_never_happen_repeats_nothing(missing: tuple[str, ...]) -> None:
    """Though it ends in the same way."""
    wanted = RunEnd("failure", ("sees",))
    got = RunEnd("failure", ("sees",), missing_faults=missing)
    comparison = RunComparison(None, None, (), (), (), wanted, got)
    assert comparison.is_repeated is (not missing)
    assert comparison.score == 0.5 * len(missing)
    assert differences(comparison) == [
        f"fault '{fault}' never happens in the simulation" for fault in missing
    ]
