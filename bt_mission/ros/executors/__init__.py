"""The executors that serve the nodes of a process: one callback after the other.

- ``serving``: :class:`ServingExecutor`, what the executors of live runs and of virtual time share
- ``live``: :class:`LiveExecutor`, on the clock that the nodes have
- ``arrivals``: the arrivals that the middleware reports
- ``entities``: what a node can be woken by, and which of it is ready
- ``callbacks``: one callback of each kind
- ``coroutines``: what was begun and has not ended
- ``process``: :class:`RobotNode`, a node with options and parameters, and its life as a process
- ``parameter_file``: values of parameters, read with their places
- ``taps``: :class:`Taps`, which change what passes between nodes
"""
