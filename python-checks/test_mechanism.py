"""Proofs that no contact forces hold a body, on both sides of limit loads found by another algorithm."""

from collections import Counter

from faults.program import Program
from floating.limit_load import judge


def test_random_bodies_are_mechanisms_beyond_their_limit_loads_only(program, tmp_path):
    """Floors, walls, corners and ceilings; isotropic, orthotropic, given and no friction."""
    found = [judge(Program(program), 11, number, tmp_path) for number in range(12)]
    wrong = [words for _, faults in found for words in faults]
    assert not wrong, wrong
    # Scenes that say something of both sides.
    assert Counter(kind for kind, _ in found)["limit"] >= 4
