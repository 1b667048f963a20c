"""Fault tests of contact3d-pipe: kills, hostile surroundings, damaged files.

    python3 python-checks/faults kills --count 300
    python3 python-checks/faults environment
    python3 python-checks/faults files --flips 4000 --truncate-every 1024

Each prints a Markdown table and ends with exit code 1 if any line of it holds something wrong.
"""
