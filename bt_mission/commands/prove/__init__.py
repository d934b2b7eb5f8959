"""Runs a mission through every answer that its servers may give, and says what follows.

The tree, the executive, the attempts and the ledger are the real ones. Their servers, services
and topics are replaced by clients that offer each answer in turn, and the clock by one that jumps
from one limit to the next.

- ``choices``: one way through what may happen, and the other ways
- ``values``: the values of messages that conditions can tell apart
- ``answers``: the answers, as rows, and which of them are considered
- ``limits``: the limits that are running in a state
- ``goal_servers``, ``clients``: what the leaves talk to
- ``environment``: the mission with these clients; one step, and the key of the state after it
- ``memento``: the state of the real objects, taken and put back
- ``known_steps``: what steps do, so that no step is taken twice
- ``explorer``: all states, breadth first
- ``claims``: what is proved of the states
- ``proof``: the result and the findings, as text and as JSON
- ``timelines``: the messages, responses and statuses of leaves on a way, as faults of a scenario
- ``played``: the answers of a way with their times, as a scenario has them
- ``confirm``: a finding as a scenario and a test, and its run on the stage
"""
