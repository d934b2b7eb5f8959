"""The server accepts a cancel request while it executes a goal."""


def test_a_goal_is_canceled_at_the_fifth_feedback(stage):
    stage.program("sleepy_server.py", arguments=["--threads"])
    client = stage.program("impatient_client.py")
    assert client.until_done(within=60) == 0
    (goal,) = client.goals
    assert (goal.status, goal.cancel_s, goal.ended_s) == ("canceled", 4.0, 5.0)
    assert len(goal.result.sequence) == 7


def test_ctrl_c_ends_the_server(stage):
    server = stage.program("sleepy_server.py")
    stage.until(lambda s: s.t >= 1)
    server.interrupt()
    assert server.until_done(within=1) == 0
