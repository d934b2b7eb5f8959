"""What runs reach of their missions: nodes, outcomes of them, and branches.

- ``places``: what there is to reach in a mission
- ``watch``: sees what a run of it reaches
- ``record``: what one run has reached as a bitmap, to be kept for very many runs
- ``tally``: adds runs, tests, missions and processes up, by place in the file
- ``table``, ``page``: as text, and as HTML
"""
