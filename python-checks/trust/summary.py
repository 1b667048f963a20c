"""What came of all scenes, as a Markdown table and a list of what is wrong."""

import statistics
from collections.abc import Callable

from trust.judge import Judged
from trust.scenes import Kind

LEAST_SUCCESS = 0.995
HEADER = (
    "| kind | scenes | default solved | worst ratio | error at the default, median and "
    "worst | worst accuracy it reports | Newton steps, median and most | several "
    "solutions | monotone in ε |\n|---|---|---|---|---|---|---|---|---|"
)


def line(name: str, judged: list[Judged]) -> str:
    """One line of the table."""
    known = [j for j in judged if j.verdicts]
    claims = [j.default for j in known if j.default.answer.claims]
    steps = [j.default.answer.newton_steps for j in known]
    solved = sum(j.succeeded for j in judged)
    not_monotone = sum(bool(j.not_monotone) for j in judged)
    cells = (
        name,
        len(judged),
        f"{solved} ({100.0 * solved / len(judged):.1f} %)",
        f"{max(j.worst_ratio for j in judged):.1e}",
        middle_and_most([verdict.error for verdict in claims], "{:.0e}"),
        f"{max((v.answer.accuracy for v in claims), default=0.0):.0e}",
        middle_and_most(steps, "{:g}"),
        sum(j.has_several_solutions for j in judged),
        f"{not_monotone} not" if not_monotone else "yes",
    )
    return f"| {' | '.join(map(str, cells))} |"


def middle_and_most(values: list[float], form: str) -> str:
    """The median and the largest of some numbers."""
    if not values:
        return ""
    return ", ".join(form.format(v) for v in (statistics.median(values), max(values)))


def several(judged: list[Judged]) -> str:
    """The scenes with more than one solution, where an answer may be any of them."""
    names = [j.scene.name for j in judged if j.has_several_solutions]
    return f"several solutions: {', '.join(names)}" if names else ""


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
    """Whether answers are worse than they say, too many solves fail, a looser epsilon fails
    where a tighter one does not, or a scene is not judged."""
    success = sum(j.succeeded for j in judged) / max(len(judged), 1)
    honest = all(j.keeps_its_word and not j.fault for j in judged)
    return not honest or success < LEAST_SUCCESS or any(j.not_monotone for j in judged)
