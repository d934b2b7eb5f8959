"""Missions as py_trees trees; no ROS is needed to build, draw or check one.

- ``runtime``: what leaves are given when the mission starts (time, ledger, variables)
- ``action_leaf``: a leaf that sees one goal of an action through
- ``service_leaf``, ``topic_leaves``: a call of a service; a message that is sent or waited for
- ``leaves``: the leaves that speak to nobody
- ``decorators``: repeat and retry, whose counts are known only when they start
- ``builder``: nodes of the mission language to behaviours
"""
