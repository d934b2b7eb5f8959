"""Facts about executives that are late, back, dead and gone."""

from __future__ import annotations

import pytest

from action_servers.server.topics import ExecutiveLimits, ExecutiveWatch

LATE = "no sign of life of the executive for 0.2 s: the base is held"
DEAD = "the executive has died: no sign of life for 2 s"
GONE = "the executive has gone while its sign of life was late"
LEFT = "the executive has left"
BACK = "back"


def watched(*events: tuple[int, int] | int, **limits: float) -> list[str]:
    """Tell a watch how many executives live and are late, or let it look so often."""
    reported: list[str] = []
    watch = ExecutiveWatch(
        ExecutiveLimits(**limits), reported.append, lambda: reported.append(BACK), reported.append
    )
    for event in ((1, 0), *events):
        if isinstance(event, tuple):
            watch.update(*event)
        else:
            for _ in range(event):
                watch.look()
    return reported


GIVEN_UP = [(0, 1), 18]


@pytest.mark.parametrize(
    ("events", "expected"),
    [
        pytest.param([(0, 1), 5, (1, 0)] * 3, [LATE, BACK] * 3, id="late and back, however often"),
        pytest.param([(0, 1), 17], [LATE], id="late for less than 2 s"),
        pytest.param([*GIVEN_UP, 100], [LATE, DEAD, BACK], id="away for 2 s, given up once"),
        pytest.param([(0, 1), 1, (1, 0), 100], [LATE, BACK], id="server held up, does not look"),
        pytest.param([(0, 0)], [LEFT], id="left"),
        pytest.param([(0, 1), (0, 0)], [LATE, GONE, BACK], id="left while late"),
        pytest.param([(2, 0), (1, 1)], [LATE], id="another lives while one is late"),
        pytest.param(
            [(2, 0), (1, 1), 18], [LATE, DEAD, BACK], id="another lives while one is given up"
        ),
        pytest.param(
            [*GIVEN_UP, (1, 1), (1, 0)], [LATE, DEAD, BACK], id="given up, then forgotten by DDS"
        ),
        pytest.param(
            [*GIVEN_UP, (1, 0), *GIVEN_UP], [LATE, DEAD, BACK] * 2, id="given up, back, late again"
        ),
        pytest.param([(2, 0), (1, 0)], [], id="one of two left"),
    ],
)
def test_what_is_told_of_executives(events, expected):
    """18 looks after the 0.2 s of its lease, one counts as dead."""
    assert watched(*events) == expected


def test_limits_are_set():
    """And told in the messages."""
    limits = {"executive_lease": 0.5, "executive_timeout": 1.0}
    late = "no sign of life of the executive for 0.5 s: the base is held"
    assert watched((0, 1), 4, **limits) == [late]
    dead = "the executive has died: no sign of life for 1 s"
    assert watched((0, 1), 5, **limits) == [late, dead, BACK]
