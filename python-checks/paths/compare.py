"""What `branches --all` finds at the end of a range beside an independent search."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from faults.program import Program
from paths.scenes import LAWS, Case, body, case
from paths.solutions import SAME, all_solutions


@dataclass(frozen=True)
class Compared:
    """One scene: how many solutions both found, what each alone found, and what the program claims."""

    nodes: int
    law: str
    scene: str
    common: int
    missed: int
    only_program: int
    degree: int
    code: int | None

    @property
    def is_good(self) -> bool:
        """No solution is missed."""
        return self.missed == 0 and self.code in (0, 1)

    @property
    def is_seen(self) -> bool:
        """Whether the signs tell that solutions are missed."""
        return self.missed > 0 and self.degree != 1


def found_by_program(program: Program, one: Case) -> tuple[list[np.ndarray], dict, int | None]:
    """The multipliers at the end of the range."""
    run = one.path.with_suffix(".h5")
    span = ["--parameter", one.key, "--from", *map(str, [one.span[0], "--to", one.span[1]])]
    done = program.run("branches", one.path, run, *span, "--all", "--no-figures", "--json")
    if done.code not in (0, 1):
        raise RuntimeError(done.stderr)
    with h5py.File(run) as file:
        points = file["branches/point"]
        at_end = points["parameter"][:] == one.span[1]
        multipliers = points["multiplier"][:][at_end]
    return distinct(multipliers), done.json, done.code


def distinct(multipliers) -> list[np.ndarray]:
    """Each once."""
    found: list[np.ndarray] = []
    for multiplier in multipliers:
        if not any(is_same(multiplier, other) for other in found):
            found.append(multiplier)
    return found


def is_same(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two answers are one, relative to their stresses."""
    size = max(np.abs(one).max(), np.abs(other).max())
    return bool(np.abs(one - other).max() <= 3 * SAME * size)


def compare(program: Program, folder: Path, nodes: int, law: str, number: int, seed: int = 0) -> Compared:
    """One random scene."""
    random = np.random.default_rng([number, nodes, LAWS.index(law), seed])
    folder.mkdir(parents=True, exist_ok=True)
    made = body(program, folder, nodes, random)
    one = case(made, folder, f"{law.replace(' ', '_')}_{number}", law, random)
    by_program, said, code = found_by_program(program, one)
    by_check = all_solutions(one.problem)
    seen = [any(is_same(known, other) for other in by_program) for known in by_check]
    back = [any(is_same(known, other) for other in by_check) for known in by_program]
    return Compared(
        nodes,
        law,
        str(one.path),
        sum(seen),
        len(seen) - sum(seen),
        len(back) - sum(back),
        said["solutions"][1]["degree"],
        code,
    )


def table(compared: list[Compared]) -> str:
    """The counts as a Markdown table."""
    lines = [
        "| nodes | law | scenes | solutions | with several | missed | in scenes | with other sums of signs | found by the program alone |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for nodes, law in Counter((c.nodes, c.law) for c in compared):
        rows = [c for c in compared if (c.nodes, c.law) == (nodes, law)]
        figures = [
            len(rows),
            sum(c.common + c.missed for c in rows),
            sum(c.common + c.missed > 1 for c in rows),
            sum(c.missed for c in rows),
            sum(c.missed > 0 for c in rows),
            sum(c.is_seen for c in rows),
            sum(c.only_program for c in rows),
        ]
        lines.append(f"| {nodes} | {law} | {' | '.join(map(str, figures))} |")
    return "\n".join(lines)
