"""Constants and bounds of HKL section 3 for a scene, and what successive approximations really do.

    >>> from contact3d.theory import measure
    >>> theory = measure("pipelines/newton.toml", set={"body.brick.cells": [24, 8, 8]})
    >>> theory.table                 # all figures of n_div = 2, 4 and 8
    >>> theory.plot()

Source: J. Haslinger, R. Kucera, T. Ligursky, J. Comput. Appl. Math. 235 (2011) 3464; numbers of equations and constants are theirs.
"""

import math
import tempfile
from collections.abc import Callable, Iterator, Mapping as Changes, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .._program import BadInput, NotConverged
from .._run import Run
from .._scene_input import SceneLike, given
from .._studies import StrPath, friction_law as bounds_of_law, run as solve
from .._tree import open as open_run
from ._contraction import ScaledLaws, contraction, friction_functional, from_zero, observed_rate
from ._mapping import Mapping
from ._multipliers import multiplier_spaces
from ._norms import DisplacementNorm
from ._problem import NotCovered, Problem, require_covered
from ._results import Contraction, FaceConstants, LawConstants, Level, MultiplierSpace, NormConstants, ScaledSolution, Theory

__all__ = ["Contraction", "FaceConstants", "LawConstants", "Level", "MultiplierSpace", "NormConstants", "NotCovered",
           "ScaledSolution", "Theory", "measure"]

#: Parts in which the sides of contact triangles are cut for c_r.
FINER = (2, 4, 8)
#: A dense S in double precision. How the scene is solved does not matter: solutions are improved to rounding.
SETTINGS = {"assemble": {"dual_operator": "explicit", "factor": "double"}, "solve": {}}


def measure(
    scene: SceneLike,
    *,
    set: Changes[str, Any] | None = None,
    coarsest: int = 2,
    finest: int | None = None,
    meshes: Sequence[StrPath] = (),
    threads: int | None = None,
    tell: Callable[[str], None] = lambda words: None,
) -> Theory:
    """Measures everything on every mesh.

    :param set: keys of the scene to change.
    :param coarsest: the least n_div of the nested meshes of a brick; :param finest: the largest, a multiple of the scene's own,
        which it is by default.
    :param meshes: Gmsh files of the body, relative to the scene, in place of its own; they need not be nested.
    :param tell: is given a few words on each mesh.
    :raises NotCovered: a scene beyond HKL sections 2 and 3. :raises BadInput: one that the program refuses.
    """
    bounds = bounds_of_law(scene, set=set).bounds
    if not bounds:
        raise NotCovered("friction: expected Coulomb friction on a contact face")
    law = LawConstants(*(bounds[key]["value"] for key in ("f_min", "f_max", "lipschitz", "kappa")), bounds["estimated"])
    levels: list[Level] = []
    norm_on_finest = None
    with tempfile.TemporaryDirectory() as folder:

        def solved(name: str, mesh: Changes[str, Any]) -> Run:
            file = Path(folder) / f"{name}.h5"
            try:
                return solve(scene, file, set={**SETTINGS, **(set or {}), **mesh}, threads=threads, progress=False)
            except NotConverged:
                return open_run(file)

        for name, run in _runs(scene, coarsest, finest, meshes, solved):
            level, norm = _level(name, run, law, norm_on_finest)
            if "brick" in run.scene["body"]:
                norm_on_finest = norm_on_finest or norm
            levels.insert(0, level)
            tell(f"{name}: uniqueness is proven for the law times less than {1 / level.energy.q_composed:.2e}")
    return Theory(law, tuple(sorted(levels, key=lambda level: level.unknowns)))


def _runs(scene: SceneLike, coarsest: int, finest: int | None, meshes: Sequence[StrPath],
          solved: Callable[[str, Changes[str, Any]], Run]) -> Iterator[tuple[str, Run]]:
    """The solved meshes with their names, those of a brick from the finest on, against which the others are measured."""
    own = solved("own", {})
    require_covered(own)
    brick = own.scene["body"].get("brick")
    if brick is None:
        is_file = given(scene)[0] is not None
        for number, mesh in enumerate(meshes):
            file = str(mesh if is_file else Path(mesh).absolute())
            yield str(mesh), solved(f"mesh{number}", {"body.gmsh.file": file})
        if not meshes:
            yield str(own.scene["body"]["gmsh"]["file"]), own
        return
    if meshes:
        raise NotCovered("body: mesh files are for bodies from mesh files; the coarser meshes of a brick are made of its own cells")
    n_div = min(brick["cells"])
    fine = [cells * (finest or n_div) // n_div for cells in brick["cells"]]
    is_graded = bool({"grading", "coordinates"} & brick.keys())
    if min(fine) % n_div or is_graded and fine != brick["cells"]:
        wanted = "the n_div of the scene, whose cells are graded" if is_graded else "a multiple of the n_div of the scene"
        raise NotCovered(f"finest: expected {wanted}, {n_div}, found {finest}")
    parts = math.gcd(*fine)
    for merged in (1,) if is_graded else range(1, parts + 1):
        cells = [count // merged for count in fine]
        if parts % merged or min(cells) < min(coarsest, n_div):
            continue
        try:
            yield f"n_div = {min(cells)}", own if cells == brick["cells"] else solved(f"brick{merged}", {"body.brick.cells": cells})
        except BadInput:
            # Cells that make no panes.
            if min(cells) > n_div:
                raise


def _level(name: str, run: Run, law: LawConstants, norm_on_finest: DisplacementNorm | None) -> tuple[Level, DisplacementNorm]:
    """Everything on one mesh, and its norm of H1."""
    problem = Problem.of(run)
    face = problem.face
    h1 = DisplacementNorm(problem, problem.sobolev, problem.factor(problem.sobolev))
    energy = DisplacementNorm(problem, problem.stiffness, problem.solve_stiffness)
    of_face = FaceConstants(
        face.h, problem.big_h, face.c_inv_10(), face.c_inv_infinity(), face.c_t(problem.frame[:, 1:]), face.c_r_absolute(),
        tuple(face.c_r(parts, clement=False) for parts in FINER), tuple(face.c_r(parts, clement=True) for parts in FINER))
    try:
        constants = h1.constants(of_face, law), energy.constants(of_face, law)
    except np.linalg.LinAlgError as error:
        raise NotCovered("contact: (3.1) fails; choose panes wider than the triangles, or nodal multipliers") from error
    mapping = Mapping.of(problem, energy)
    stored = [run[f"solve/multiplier_{part}"].values.ravel() for part in ("normal", "tangential")]
    solution = mapping.solution(np.concatenate(stored))
    steps, lemma = from_zero(mapping, energy, constants[1])
    scaled = ScaledLaws(mapping, (h1, energy))
    return Level(
        name, len(problem.load), len(problem.areas), of_face, *constants,
        multipliers=multiplier_spaces(h1, norm_on_finest) if "brick" in run.scene["body"] else (),
        contraction=None if solution is None else contraction(mapping, (h1, energy), solution),
        observed_rate=None if solution is None else observed_rate(mapping, solution),
        steps_from_zero=steps,
        lemma=lemma,
        functional=None if solution is None else friction_functional(mapping, solution),
        scaled=tuple(scaled.points),
        norm_thresholds=tuple(scaled.first(lambda local, k=k: local.norms[k] >= 1) for k in range(2)),
        radius_threshold=scaled.first(lambda local: local.spectral_radius >= 1),
        sign_threshold=scaled.first(lambda local: local.sign <= 0),
    ), h1
