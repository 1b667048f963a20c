"""Scenes with their exact data and solutions in a folder, for work on solvers outside the program."""

from pathlib import Path

import numpy as np

from trust.judge import Judged


def keep(judged: Judged, folder: Path) -> None:
    """Write the text of a scene and, in an .npz file, S, h, G, areas, 1/F and all solutions."""
    folder.mkdir(parents=True, exist_ok=True)
    name = judged.scene.name
    (folder / f"{name}.toml").write_text(judged.scene.text)
    if judged.reference is None:
        return
    problem = judged.reference.problem
    exact = problem.exact
    solutions = judged.reference.solutions
    np.savez_compressed(
        folder / f"{name}.npz",
        S=exact.operator.hi,
        S_low=exact.operator.lo,
        h=exact.rhs.hi,
        h_low=exact.rhs.lo,
        area=exact.area,
        pane_average=exact.pane_average,
        slip_free=exact.slip_free.hi,
        compliance=exact.compliance.hi,
        local_stiffness=problem.stiffness,
        friction_inverse=np.array(
            [problem.friction(s.multiplier)[0].hi for s in solutions]
        ),
        solutions=np.array([s.multiplier.hi for s in solutions]),
        zones=np.array([s.zones for s in solutions]),
        answers=np.array([v.answer.multiplier for v in judged.verdicts]),
        epsilons=np.array([v.answer.epsilon for v in judged.verdicts]),
        errors=np.array([v.error for v in judged.verdicts]),
    )
