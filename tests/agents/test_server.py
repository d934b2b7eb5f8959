"""The door as a client of the SDK sees it."""

from __future__ import annotations

from tests.support.agents import TURN, Played


def test_a_mission_is_proposed_proved_simulated_and_driven_with_a_permit(played: Played) -> None:
    """Each answer names what is missing next."""
    proposed = played.call("propose", name="look", text=TURN)
    assert proposed["missing"][0] == "no proof of this version: call prove"
    assert "+mission: look" in proposed["diff"]
    assert played.call("prove", name="look")["missing"] == [
        "no simulated runs of this version: call simulate (2 runs)"
    ]
    assert played.call("simulate", name="look")["missing"] == []
    assert "has no permit" in played.call("drive", name="look")
    played.approve()
    assert played.call("drive", name="look") == {"is_driving": True, "why": ""}
    (mission,) = played.robot.driven
    halting = {each.name for each in mission.requirements if each.on_violation == "halt"}
    assert halting == {"keeps clear", "is slow"}
    # `clearance` is true room, which no sensor of a robot measures.
    assert played.call("site")["only_simulated"] == ["keeps clear"]
