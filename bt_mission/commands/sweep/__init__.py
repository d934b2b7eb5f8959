"""Sweeps: the scenarios of a mission, the workers that run them, and the results.

- ``ranges``: what may vary, as a file or an option says it
- ``bundle``: all files that the scenarios need, as texts
- ``concrete``: :class:`ConcreteScenario`, which a worker runs
- ``base``: the mission or scenario that is varied
- ``plan``: the scenarios of a sweep, by number
- ``work``: runs concrete scenarios in this process
- ``pool``: workers of Dask that run them
- ``sweep``: checks a plan, runs it, and records the worst
- ``row``: the result of one scenario
- ``store``: all rows, in SQLite and as CSV
- ``summary``: the totals of rows; ``columns``: the rows as arrays, and the worst of them
- ``repeat``: the origin of a sweep, and the command that runs a row again
- ``report``: the tables of the terminal and the page
"""
