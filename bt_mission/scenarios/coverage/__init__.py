"""Coverage of missions: which nodes, outcomes and branches runs reach.

- ``places``: what there is to reach in a mission
- ``watch``: counts what a run of it reaches
- ``record``: the counts of a mission's runs as a bitmap, and of files over tests and processes
- ``report``: as text, and as HTML
"""
