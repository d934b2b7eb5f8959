"""Searches for a scenario that breaks a mission, and makes what it finds small.

- ``material``: what the mission gives to draw from; ``probing``: what of that is there
- ``candidate``: one scenario that may be tried, in parts that can be left out or rounded
- ``space``: all candidates: a world, a start, inputs, obstacles and faults that are drawn
- ``guide``: what counts as found, and how near a run came to it
- ``reference``: a good mission; what breaks it as well is no find
- ``strategies``: which candidates are tried next
- ``search``: tries them, until one breaks the mission
- ``simplify``: makes a candidate small, each step checked by running it
- ``cover``: drives towards what of the tree was not reached
- ``sentence``: what breaks, in a sentence
- ``result``: the folder with the scenario, its test, its recording and its report
"""
