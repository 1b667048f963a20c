"""A referee of the solver: random scenes, answers in extended precision, and a verdict.

    python3 python-checks/trust --scenes 504 --seed 1

`scenes` makes scenes of six kinds. `exact` takes the rounded A, B, l and gap integrals of a run
file and finds S and h to some 28 digits; `reference` solves the contact problem with them and
verifies every condition of its solutions. `judge` runs the program and measures how far its answers
are from the nearest of these. Nothing here shares code with the program.
"""
