"""What came of all scenes, as a Markdown table and a list of what is wrong."""

import statistics
from collections.abc import Callable

from trust.judge import MOST_RATIO, Judged
from trust.scenes import Kind

LEAST_SUCCESS = 0.995
HEADER = (
    "| kind | scenes | default solved | worst ratio | worst error at the default | Newton steps, "
    "median and most | several solutions | monotone in ε |\n|---|---|---|---|---|---|---|---|"
)


def line(name: str, judged: list[Judged]) -> str:
    """One line of the table."""
    known = [j for j in judged if j.verdicts]
    steps = [j.default.answer.newton_steps for j in known]
    errors = [j.default.error for j in known if j.default.answer.claims]
    solved = sum(j.succeeded for j in judged)
    not_monotone = sum(bool(j.not_monotone) for j in judged)
    several = sum(len(j.reference.solutions) > 1 for j in known)
    cells = (
        name,
        len(judged),
        f"{solved} ({100.0 * solved / len(judged):.1f} %)",
        f"{max((j.worst_ratio for j in judged), default=0.0):.1e}",
        f"{max(errors, default=0.0):.1e}",
        f"{statistics.median(steps):g}, {max(steps)}" if steps else "",
        several,
        f"{not_monotone} not" if not_monotone else "yes",
    )
    return f"| {' | '.join(map(str, cells))} |"


def methods_table(judged: list[Judged]) -> str:
    """How the other methods fared where they were asked."""
    names = dict.fromkeys(v.answer.asked for j in judged for v in j.by_method)
    lines = ["| method | scenes | solved | worst ratio |", "|---|---|---|---|"]
    for name in names:
        verdicts = [v for j in judged for v in j.by_method if v.answer.asked == name]
        solved = sum(v.answer.code == 0 for v in verdicts)
        worst = max(v.ratio for v in verdicts)
        lines.append(f"| {name} | {len(verdicts)} | {solved} | {worst:.1e} |")
    return "\n".join(lines) if names else ""


def table(judged: list[Judged]) -> str:
    """One line a kind, and one for all."""
    lines = [HEADER]
    for kind in Kind:
        of_kind = [j for j in judged if j.scene.kind is kind]
        if of_kind:
            lines.append(line(kind.replace("_", " "), of_kind))
    lines.append(line("all", judged))
    return "\n".join(lines)


def offenders(judged: list[Judged], command: Callable[[Judged], str]) -> str:
    """Everything wrong, scene by scene, with the command that makes the scene again."""
    lines = []
    for one in judged:
        if one.wrong:
            lines.append(f"{one.scene.name}: {'; '.join(one.wrong)}")
            lines.append(f"    {command(one)}")
    return "\n".join(lines)


def failed(judged: list[Judged]) -> bool:
    """Whether an answer is worse than it says, too many solves fail, or a scene is not judged."""
    success = sum(j.succeeded for j in judged) / max(len(judged), 1)
    too_wrong = any(j.worst_ratio > MOST_RATIO for j in judged)
    return too_wrong or success < LEAST_SUCCESS or any(j.fault for j in judged)
