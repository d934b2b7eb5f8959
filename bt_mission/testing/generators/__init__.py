"""Worlds and missions that are drawn: from a seed, or by hypothesis, which shrinks them.

- ``draws``: :class:`Draws`, where choices come from
- ``worlds``: :func:`drawn_world`
- ``missions``: :func:`drawn_mission`
- ``scenarios``: :class:`DrawnScenario`, with faults at their times
- ``strategies``: hypothesis strategies over these (imports hypothesis)
"""
