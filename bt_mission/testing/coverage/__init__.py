"""What no test has reached of the missions that it ran: ``--mission-cov``.

- ``places``: what there is to reach in a mission: nodes, outcomes, branches
- ``watch``: sees what a run of it reaches
- ``tally``: adds runs, tests, missions and processes up, by place in the file
- ``table``, ``page``: as text, and as HTML
- ``hooks``: the part of the pytest plugin
"""
