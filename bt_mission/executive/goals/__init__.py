"""The life of a goal: pure modules, no ROS.

- ``goal``: one goal as its server sees it, a state machine with its table written once
- ``ledger``: every goal sent, until its server confirms the end
- ``attempt``: one goal as its leaf sees it, with limits and an outcome
- ``outcome``: the closed list of ways in which an attempt ends
"""
