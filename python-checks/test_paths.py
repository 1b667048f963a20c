"""`branches --all` beside all solutions of small random problems, and scenes on which an earlier search failed."""

import pytest

from conftest import ROOT
from faults.program import Program
from paths.compare import compare, found_by_program
from paths.scenes import GRIDS, Case, constant
from paths.solutions import Problem, all_solutions

CASES = ROOT / "python-checks" / "paths" / "cases"
RESIDUAL = "friction.coefficient.ramp.residual"
CONSTANT = "friction.coefficient.constant"


@pytest.fixture(scope="module")
def tested(program) -> Program:
    """The program, on one thread."""
    return Program(program.resolve())


@pytest.mark.parametrize(
    ("name", "key", "span", "count"),
    [
        ("ramp_one_node", RESIDUAL, (0.105, 0.21), 3),
        ("orthotropic_one_node", "friction.coefficient_1.constant", (0.153, 1.153), 3),
        # Seven of the nine have signs that add up to 1.
        ("two_nodes_sum_one", CONSTANT, (0.1, 2.203), 9),
    ],
)
def test_solutions_between_narrow_angles_are_found(
    tested, tmp_path, name, key, span, count
):
    for file in ("s.toml", "s.msh"):
        (tmp_path / file).write_bytes((CASES / name / file).read_bytes())
    unused = Problem(None, None, None, constant(1.0, 1.0), GRIDS[1])
    found, said, code = found_by_program(tested, Case(tmp_path / "s.toml", key, span, unused))
    assert (len(found), said["followed"], code) == (count, True, 0)
    assert all(end["degree"] == 1 for end in said["solutions"])


@pytest.mark.parametrize(
    ("nodes", "law", "scenes"),
    [
        (1, "ramp", 6),
        (1, "two ramps", 2),
        (1, "orthotropic", 2),
        (2, "constant", 1),
        (2, "ramp", 1),
        (2, "two ramps", 1),
    ],
)
def test_no_solution_of_random_problems_is_missed(tested, tmp_path, nodes, law, scenes):
    for seed in range(scenes):
        assert compare(tested, tmp_path / str(seed), nodes, law, seed).is_good


def test_the_reference_finds_the_closed_form():
    """One node that slips: h = (-0.2, -1), S_nt = 0.6; open, stick and slip from F = 5/2.5 on."""
    import numpy as np

    S = np.array([[1.0, 0.6, 0.0], [0.6, 1.0, 0.0], [0.0, 0.0, 1.0]])
    h = np.array([-0.2, -1.0, 0.0])
    stick = np.linalg.solve(S, h)
    least = np.abs(stick[1]) / stick[0]
    for friction, count in ((0.9 * least, 1), (1.1 * least, 3)):
        law = constant(friction, friction)
        assert len(all_solutions(Problem(S, h, np.ones(1), law, GRIDS[1]))) == count
