"""Missions as py_trees trees; no ROS is needed to build, draw or check one.

- ``runtime``: what leaves are given when the mission starts (time, ledger, variables)
- ``evaluator``: what a behaviour is built from; computes the values of its node
- ``action_leaf``: the leaf that sends goals of an action
- ``client_leaves``: a call of a service; a message that is sent or waited for
- ``leaves``: the leaves that use no interface
- ``control``, ``decorators``, ``cleanup``: nodes with others below them
- ``builder``: nodes of the mission language to behaviours
"""
