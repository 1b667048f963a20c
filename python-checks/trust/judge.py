"""One scene judged: how far the program's answers are from the solutions, against what they say."""

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from faults.program import Program
from run_file import open_run
from trust.answers import METHODS, Answer, answer_at, answer_by, default_answer
from trust.contact import Problem
from trust.exact import Exact, Unsettled
from trust.reference import Reference
from trust.scenes import Scene

NEAR = 1e-7
"""An answer nearer to a known solution than this need not be a start for finding others."""
MOST_RATIO = 10.0
"""Error over the larger of epsilon and of the accuracy reported."""


REFUSED = 2
"""Exit code of what the program does not begin."""


@dataclass(frozen=True)
class Verdict:
    """One answer and its error; the error is infinite where no solution is known."""

    answer: Answer
    error: float

    @property
    def ratio(self) -> float:
        """Error over what was promised; 0 for an answer that promises nothing."""
        if not self.answer.claims:
            return 0.0
        accuracy = self.answer.accuracy
        accuracy = accuracy if math.isfinite(accuracy) else 0.0
        return self.error / max(self.answer.epsilon, accuracy)


@dataclass
class Judged:
    """All that is known of one scene."""

    scene: Scene
    verdicts: list[Verdict] = field(default_factory=list)
    by_method: list[Verdict] = field(default_factory=list)
    reference: Reference | None = None
    fault: str | None = None
    refused: bool = False

    @property
    def default(self) -> Verdict | None:
        """What `run` gave without settings."""
        return self.verdicts[0] if self.verdicts else None

    @property
    def succeeded(self) -> bool:
        """Whether the default solve ended with exit code 0."""
        return self.default is not None and self.default.answer.code == 0

    @property
    def worst_ratio(self) -> float:
        """The largest error over what was promised, of the program's own choice of method."""
        return max((verdict.ratio for verdict in self.verdicts), default=0.0)

    @property
    def keeps_its_word(self) -> bool:
        """Whether no answer, by any method, is much worse than it says."""
        both = [*self.verdicts, *self.by_method]
        return all(verdict.ratio <= MOST_RATIO for verdict in both)

    @property
    def has_several_solutions(self) -> bool:
        """Whether more than one solution was found."""
        return self.reference is not None and len(self.reference.solutions) > 1

    @property
    def not_monotone(self) -> list[str]:
        """Accuracies at which it failed although a tighter one succeeded."""
        answers = sorted((v.answer for v in self.verdicts), key=lambda a: a.epsilon)
        failed, succeeded = [], False
        for answer in answers:
            if answer.code == 0:
                succeeded = True
            elif succeeded:
                failed.append(answer.asked)
        return failed

    @property
    def wrong(self) -> list[str]:
        """Everything that is wrong, in words."""
        found = [self.fault] if self.fault else []
        if self.default and not self.succeeded:
            found.append(
                f"default: exit {self.default.answer.code}, {self.default.answer.status}"
            )
        for verdict in [*self.verdicts, *self.by_method]:
            answer = verdict.answer
            if answer.fault:
                found.append(f"{answer.asked}: {answer.fault}")
            if verdict.ratio > MOST_RATIO:
                found.append(
                    f"{answer.asked}: {answer.status}, exit {answer.code}, accuracy "
                    f"{answer.accuracy:.0e}, error {verdict.error:.1e}, ratio {verdict.ratio:.1e}"
                )
        found += [
            f"{asked}: fails where a tighter one succeeds"
            for asked in self.not_monotone
        ]
        return found


def judge(
    program: Program,
    scene: Scene,
    epsilons: list[float],
    by_methods: float | None,
    folder: Path,
) -> Judged:
    """Solve a scene at every accuracy, and by every method at `by_methods`, and judge it."""
    judged = Judged(scene)
    scene_file, run_file = folder / "scene.toml", folder / "run.h5"
    scene_file.write_text(scene.text)
    try:
        answers = [default_answer(program, scene_file, run_file)]
        if answers[0].multiplier is None:
            judged.fault = answers[0].fault
            judged.refused = answers[0].code == REFUSED
            return judged
        answers += [answer_at(program, run_file, epsilon) for epsilon in epsilons]
        methods = METHODS if by_methods else ()
        others = [answer_by(program, run_file, name, by_methods) for name in methods]
        with open_run(run_file) as file:
            judged.reference = Reference(Problem.of(Exact.read(file)))
    except Unsettled as error:
        judged.fault = f"no reference: {error}"
        return judged
    finally:
        scene_file.unlink()
        run_file.unlink(missing_ok=True)
    found = [a.multiplier for a in [*answers, *others] if usable(a.multiplier)]
    judged.reference.search(found, NEAR)
    judged.verdicts = [verdict(judged.reference, answer) for answer in answers]
    judged.by_method = [verdict(judged.reference, answer) for answer in others]
    if not judged.reference.solutions:
        judged.fault = "no reference: no start led to a verified solution"
    return judged


def usable(multiplier: np.ndarray | None) -> bool:
    """Whether multipliers are numbers."""
    return multiplier is not None and bool(np.isfinite(multiplier).all())


def verdict(reference: Reference, answer: Answer) -> Verdict:
    """An answer with its distance to the nearest solution."""
    if not usable(answer.multiplier):
        return Verdict(answer, math.inf)
    return Verdict(answer, reference.error(answer.multiplier))
