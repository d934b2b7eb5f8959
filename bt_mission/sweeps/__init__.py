"""Many scenarios of one mission: which, carried out where, and what came out.

- ``ranges``: what may vary, as a file or an option says it
- ``bundle``: all files that the scenarios need, as texts
- ``concrete``: :class:`ConcreteScenario`, what a worker carries out
- ``base``: the mission or scenario that is varied
- ``plan``: the scenarios of a sweep, by number
- ``work``: carries a concrete scenario out
- ``runner``: carries many out; the protocol of pools
- ``row``: what one scenario came to
- ``store``: all rows, in SQLite
- ``summary``: what the rows come to, added up one by one
"""
