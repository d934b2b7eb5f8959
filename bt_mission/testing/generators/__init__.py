"""Worlds and missions that are drawn: from a seed, or by hypothesis, which shrinks them.

- ``worlds``: :func:`drawn_world`
- ``missions``: :func:`drawn_mission`
- ``scenarios``: :class:`DrawnScenario`, with faults at their times
- ``strategies``: hypothesis strategies over these (imports hypothesis)
"""
