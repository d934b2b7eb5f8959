"""Searches for a scenario that breaks a mission, and minimizes the counterexamples.

- ``candidate``: one scenario that may be tried, in parts that can be left out or rounded
- ``material``: what the mission gives to draw from
- ``space``: all candidates: a world, a start (``starts``), inputs, obstacles and faults
- ``guide``: the failures that count, and the score of a run
- ``reference``: a good mission; what breaks it as well is no find
- ``strategies``: which candidates are tried next
- ``search``: tries them, until one breaks the mission
- ``simplify``: minimizes a candidate, each step checked by running it
- ``session``: a search, or a drive towards what of the tree was not reached, from its files on
- ``result``: what breaks in a sentence; the folder with scenario, test, recording and report
"""
