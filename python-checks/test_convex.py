"""Convex problems of hard conditioning: a small part of the campaign, a slender beam by every method, and the judge itself."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from convex import springs
from convex.judge import answer, compared, judge
from convex.reference import Dual, by_active_sets
from convex.scenes import Kind, scene
from convex.sprung import sprung
from faults.program import Program
from run_file import open_run

BEAM = Path(__file__).parent / "convex" / "cases" / "slender_beam_floor.toml"
INCREMENTS = 20
NUMBERS = [*range(6, 18), 23, *range(24, 48, 5)]
"""Every kind without friction, linear and quadratic, with panes and nodal, and some with."""


@pytest.fixture(scope="module")
def tested(program) -> Program:
    """The program as the campaign runs it."""
    return Program(program.resolve())


def beam(tested: Program, folder: Path, *changes: str) -> tuple[int, Path]:
    """The beam with changes: exit code and run file."""
    path = folder / "beam.h5"
    arguments = [word for change in changes for word in ("--set", change)]
    return tested.run("run", BEAM, path, "--no-figures", *arguments).code, path


@pytest.fixture(scope="module")
def solved(tested, tmp_path_factory) -> tuple[Dual, np.ndarray, float]:
    """The beam by the default method."""
    code, path = beam(tested, tmp_path_factory.mktemp("beam"))
    assert code == 0
    with open_run(path) as file:
        return answer(file)


def test_scenes_of_every_kind_are_proven(tested, tmp_path):
    judged = [judge(tested, scene(1, number), tmp_path) for number in NUMBERS]
    assert {one.scene.kind for one in judged} == set(Kind)
    assert [f"{one.scene.name}: {one.wrong}" for one in judged if one.wrong] == []


def test_a_slender_beam_on_a_floor_is_solved(solved):
    dual, multiplier, accuracy = solved
    assert dual.rounding > 1e-8
    wrong, error = compared(dual, None, multiplier, accuracy)
    assert wrong is None and error < 1e-4
    assert 0 < (multiplier > 0).sum() < multiplier.size


@pytest.mark.parametrize(
    "change", ['solve.method="newton"', 'assemble.dual_operator="implicit"']
)
def test_the_beam_has_the_same_answer_otherwise(tested, tmp_path, solved, change):
    code, path = beam(tested, tmp_path, change)
    assert code == 0
    dual, expected, _ = solved
    with open_run(path) as file:
        found = file["solve/multiplier_normal"][:]
    assert dual.size(found - expected) <= 1e-7 * dual.size(expected)


def test_the_beam_is_loaded_in_increments(tested, tmp_path, solved):
    code, path = beam(tested, tmp_path, f"step=[{{increments={INCREMENTS}}}]")
    assert code == 0
    dual, expected, _ = solved
    with open_run(path) as file:
        assert len(file["history/status"]) == INCREMENTS
        found = file["solve/multiplier_normal"][:]
    assert dual.size(found - expected) <= 1e-7 * dual.size(expected)


def test_what_another_method_leaves_is_measured(tested, tmp_path, solved):
    """It was called off by its own size, since Newton's steps wandered off from it."""
    code, path = beam(
        tested, tmp_path, 'solve.method="fixed-point"', "solve.epsilon=1e-8"
    )
    assert code == 1
    with open_run(path) as file:
        dual, found, accuracy = answer(file)
    error = dual.size(found - solved[1]) / dual.size(solved[1])
    assert error < 0.1
    assert accuracy == pytest.approx(error, rel=0.01)


def test_wrong_answers_are_seen(solved):
    dual, multiplier, accuracy = solved
    assert by_active_sets(dual) is not None
    assert compared(dual, None, multiplier * 1.01, accuracy)[0]
    moved = np.roll(multiplier, 1)
    assert compared(dual, None, moved, accuracy)[0]


def test_scenes_depend_on_seed_and_number_alone():
    assert scene(3, 17) == scene(3, 17)
    assert scene(3, 17).text != scene(4, 17).text
    assert len({scene(1, number).text for number in range(80)}) == 80


BLOCKS = range(36)
"""Of seed 1: a dozen without friction, as many with Tresca's law and with Coulomb's."""


def test_blocks_on_springs_meet_their_conditions(tested, tmp_path):
    judged = [springs.judge(tested, sprung(1, number), tmp_path) for number in BLOCKS]
    assert [f"{one.scene.name}: {one.wrong}" for one in judged if one.wrong] == []
    # Hardly holding the block, and stiffer than it.
    softness = [one.softness for one in judged]
    assert max(softness) > 1e6 and min(softness) < 10.0


def test_what_breaks_a_condition_of_a_block_is_seen(tested, tmp_path):
    text, path = tmp_path / "block.toml", tmp_path / "block.h5"
    pressed = next(s for s in (sprung(1, n) for n in range(1, 200, 3)) if s.load == "pushed")
    text.write_text(pressed.text)
    tested.done("run", text, path, "--no-figures")
    for name, by in (("multiplier_normal", 1.01), ("multiplier_tangential", 1.01), ("displacement", 1.0001)):
        with h5py.File(path, "r+") as file:
            assert springs.violated(file) is None
            right = file["solve"][name][:]
            file["solve"][name][...] = right * by
            assert springs.violated(file) is not None, name
            file["solve"][name][...] = right


@pytest.mark.parametrize(("softest", "numbers"), [(1e10, range(20)), (1e18, range(20, 40))])
def test_softer_springs_are_refused_or_right(tested, tmp_path, softest, numbers):
    judged = [springs.judge(tested, sprung(2, number, softest), tmp_path) for number in numbers]
    assert [f"{one.scene.name}: {one.wrong}" for one in judged if one.wrong] == []
    assert {one.status for one in judged} > {"refused"}
