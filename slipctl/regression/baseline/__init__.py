"""What a baseline holds: which metrics, how far each number may move, and where the runs drove.

Tolerances are measured: `spread` runs a scenario from moved starts, `tolerance` makes them of what it saw.
"""
