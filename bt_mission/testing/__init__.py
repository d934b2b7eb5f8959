"""What tests of missions are made of, and the pytest plugin that hands it to them.

- ``plugin``: the fixtures, on by themselves where the package is installed
- ``stages``: :class:`Stages`, the fixture ``stage``
- ``run``: :class:`Run`, a mission under test
- ``moment``: :class:`Moment`, one control step, for conditions
- ``assertions``: what can be claimed of a run: always, never, eventually, whenever
- ``seeds``, ``pass_rates``, ``scenarios``: ``@pytest.mark.scenario``, a test for each seed
- ``coverage/``: ``--mission-cov``, what no test has reached
- ``results``: what a test tells and leaves when it is over
- ``live_graph``, ``processes``: sim, servers and executive as processes of their own
- ``history``, ``recorded``: what happened
- ``scripted_server``: :class:`ScriptedServer`, an action server that a test plays
"""
