"""Sweeps: the scenarios of a mission, the workers that run them, and the results.

- ``ranges``: what may vary, as a file or an option says it
- ``bundle``: all files that the scenarios need, as texts
- ``concrete``: :class:`ConcreteScenario`, what a worker carries out
- ``base``: the mission or scenario that is varied
- ``plan``: the scenarios of a sweep, by number
- ``work``: carries concrete scenarios out in this process
- ``pool``: workers of Dask that carry them out
- ``sweep``: checks a plan, carries it out, and records the worst
- ``row``: the result of one scenario
- ``store``: all rows, in SQLite and as CSV
- ``summary``: the totals of rows; ``columns``: the rows as arrays, and the worst of them
- ``repeat``: what a sweep was made from, and how one row is carried out again
- ``report``: the tables of the terminal and the page
"""
