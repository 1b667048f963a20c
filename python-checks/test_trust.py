"""The referee on a known answer, on answers made wrong, and on a few random scenes."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest

from conftest import ROOT
from faults.program import Program
from run_file import open_run
from trust.answers import Answer, default_answer
from trust.contact import Problem, Zone
from trust.double_double import DD
from trust.exact import Exact
from trust.judge import Judged, Verdict, judge, verdict
from trust.reference import Reference, from_start, jacobian, natural_map, zone_equations
from trust.scenes import Kind, Scene, scene

CASES = ROOT / "python-checks" / "trust" / "cases"
SOFT_BLOCK = CASES / "soft_block.toml"
EPSILONS = [1e-4, 1e-6, 1e-9, 1e-12]
# The multipliers of that scene in Pa, found with 40 digits by another program.
NORMAL = [63659.9, 236338.2, 63659.9, 236338.2]
TANGENTIAL = [1715.8, -16819.9, 58282.8, -40374.8, 1715.8, 16819.9, 58282.8, 40374.8]


@pytest.fixture(scope="module")
def tested(program) -> Program:
    """The program as the referee runs it."""
    return Program(program.resolve())


@pytest.fixture(scope="module")
def reference(tested, tmp_path_factory) -> Reference:
    """The soft block, solved from no start."""
    path = tmp_path_factory.mktemp("trust") / "run.h5"
    default_answer(tested, SOFT_BLOCK, path)
    with open_run(path) as file:
        found = Reference(Problem.of(Exact.read(file)))
    found.search([], 0.0)
    return found


def test_soft_block_has_the_known_solution(reference):
    assert len(reference.solutions) == 1
    solution = reference.solutions[0]
    known = np.array([*NORMAL, *TANGENTIAL])
    assert np.abs(solution.multiplier.hi - known).max() <= 0.05
    assert list(solution.zones) == [Zone.STICK, Zone.SLIP, Zone.STICK, Zone.SLIP]
    assert solution.violation <= 1e-22


def test_the_operator_is_symmetric_to_twenty_eight_digits(reference):
    s = reference.problem.exact.operator
    assert np.abs((s - s.T).hi).max() <= 1e-28 * np.abs(s.hi).max()


def test_solutions_do_not_depend_on_the_start(reference):
    true = reference.solutions[0].multiplier
    random_numbers = np.random.default_rng(1)
    start = true.hi * (1.0 + 0.05 * random_numbers.normal(size=true.shape))
    again = from_start(reference.problem, start)
    assert np.abs((again.multiplier - true).hi).max() <= 1e-18 * np.abs(true.hi).max()


def answer(multiplier: np.ndarray, epsilon: float = 1e-12, code: int = 0) -> Answer:
    """An answer that says it has converged."""
    status = "converged" if code == 0 else "max_newton_steps"
    return Answer("", epsilon, code, status, 0.0, 5, 0, multiplier, 0.0)


def test_the_error_is_area_weighted(reference):
    true = reference.solutions[0].multiplier.hi
    assert verdict(reference, answer(true)).error <= 1e-15
    wrong = true.copy()
    wrong[4:] *= 1.0 + 1e-4
    off = verdict(reference, answer(wrong))
    assert 0.5e-4 < off.error <= 1.0001e-4
    assert off.ratio == pytest.approx(off.error / 1e-12)
    assert verdict(reference, answer(wrong, code=1)).ratio == 0.0
    honest = replace(answer(wrong), accuracy=2e-4)
    assert verdict(reference, honest).ratio < 1.0


def test_wrong_zones_are_seen(reference):
    """The multipliers of a stalled Newton method: pane 0 sticks elsewhere."""
    problem, solution = reference.problem, reference.solutions[0]
    wrong = DD.of(solution.multiplier.hi * np.where(np.arange(12) == 4, 0.6, 1.0))
    violations = problem.violations(wrong, solution.zones)
    assert violations["slip of sticking panes"] > 1e-3
    flipped = np.array([Zone.STICK] * 4)
    violations = problem.violations(solution.multiplier, flipped)
    assert violations["slip of sticking panes"] > 1e-3


def test_a_body_that_lifts_off_has_no_multipliers(tested, tmp_path):
    text = SOFT_BLOCK.read_text().replace("-1e5]", "1e5]")
    one = Scene(0, Kind.SOFT_SPRINGS, False, text)
    found = judge(tested, one, [], None, tmp_path)
    assert found.wrong == []
    assert found.default.error == 0.0
    solution = found.reference.solutions[0]
    assert not solution.multiplier.hi.any() and not solution.zones.any()
    pressed = answer(np.full(12, 1e-9))
    assert verdict(found.reference, pressed).error == np.inf


def test_what_is_no_number_is_no_solution(reference):
    problem, zones = reference.problem, reference.solutions[0].zones
    for bad in (np.zeros(12), np.full(12, np.nan)):
        assert max(problem.violations(DD.of(bad), zones).values()) > 1e-3


def test_an_epsilon_that_fails_below_one_that_succeeds_is_named():
    one = scene(1, 0)
    answers = [answer(np.zeros(3), e, c) for e, c in ((1e-4, 1), (1e-6, 0), (1e-9, 1))]
    answers[0] = replace(answers[0], asked="epsilon 1e-04")
    judged = Judged(one, [Verdict(a, 0.0) for a in answers])
    assert judged.not_monotone == ["epsilon 1e-04"]


@pytest.fixture(scope="module")
def judged(tested, tmp_path_factory) -> list[Judged]:
    """Two scenes of each kind, with panes and nodal."""
    folder = tmp_path_factory.mktemp("scenes")
    scenes = [scene(1, number) for number in range(12)]
    return [judge(tested, one, [1e-4], None, folder) for one in scenes]


def test_random_scenes_are_judged(judged):
    assert {(j.scene.kind, j.scene.nodal) for j in judged} == {
        (kind, nodal) for kind in Kind for nodal in (False, True)
    }
    for one in judged:
        assert one.fault is None, one.scene.name
        assert one.reference.solutions, one.scene.name


def test_random_scenes_are_answered(judged):
    """No answer is worse than it says, and none fails."""
    assert [f"{j.scene.name}: {j.wrong}" for j in judged if j.wrong] == []


@pytest.mark.parametrize("name", ["soft_block", "looser_11", "looser_43"])
def test_bodies_on_soft_springs_are_answered(tested, tmp_path, name):
    """Wrong zones passed for an answer here, or a looser epsilon failed."""
    one = Scene(0, Kind.SOFT_SPRINGS, False, (CASES / f"{name}.toml").read_text())
    found = judge(tested, one, EPSILONS, None, tmp_path)
    assert found.wrong == []
    assert len(found.verdicts) == 1 + len(EPSILONS)
    assert all(v.answer.newton_steps <= 20 for v in found.verdicts)


def test_derivatives_agree_with_differences(judged):
    """Of the natural map and of the zones' equations, where friction follows the slip."""
    follows = [j for j in judged if j.reference.problem.law.follows_slip]
    assert follows
    for one in follows:
        problem, solution = one.reference.problem, one.reference.solutions[0]
        rho = problem.own_stiffness
        at = solution.multiplier.hi * 1.01
        state = natural_map(problem, at, rho)
        matrix = jacobian(problem, state, rho)
        equations = zone_equations(problem, DD.of(at), solution.zones)[1]
        size = np.abs(at).max()
        for direction in np.random.default_rng(3).normal(size=(3, at.size)):
            step = 1e-7 * size * direction
            difference = natural_map(problem, at + step, rho).residual - state.residual
            worst = np.abs(difference - matrix @ step).max()
            assert worst <= 1e-5 * np.abs(matrix @ step).max()
            ahead = zone_equations(problem, DD.of(at) + step, solution.zones)[0]
            behind = zone_equations(problem, DD.of(at) - step, solution.zones)[0]
            change = (ahead - behind).hi / 2.0
            scale = np.abs(equations).max(axis=1) * np.abs(step).max()
            assert np.abs((change - equations @ step) / scale).max() <= 1e-5


def test_scenes_depend_on_seed_and_number_alone():
    first, again, other = scene(3, 17), scene(3, 17), scene(4, 17)
    assert first == again
    assert first.text != other.text
    texts = {scene(1, number).text for number in range(60)}
    assert len(texts) == 60
    for text in texts:
        tomllib.loads(text)
