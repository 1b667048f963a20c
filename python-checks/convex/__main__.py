"""The command line of the campaign."""

import argparse
import os
import sys
import tempfile
from collections import Counter
from pathlib import Path

# Small matrices: threads of the linear algebra only get in each other's way.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

if __package__ in (None, ""):
    # Run as a folder: the folder's parent holds this package and the readers it uses.
    sys.path[0] = str(Path(__file__).resolve().parent.parent)

from campaign import arguments, require

require("blake3", "h5py", "numpy", "scipy")

from convex import springs
from convex.judge import Judged, judge
from convex.scenes import Kind, scene
from convex.sprung import LAWS, SOFTEST, sprung
from faults.program import Program


def asked_for() -> argparse.Namespace:
    """What was asked for."""
    parser = arguments("convex", __doc__)
    parser.add_argument("--scenes", type=int, default=300, help="number of scenes")
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument(
        "--sprung",
        type=float,
        nargs="?",
        const=SOFTEST,
        metavar="SOFTEST",
        help="blocks that springs hold, up to so many times softer than the block",
    )
    parser.add_argument(
        "--write", type=Path, help="folder for the scenes, and do no more"
    )
    return parser.parse_args()


def table(judged: list[Judged]) -> str:
    """Counts by kind and law, as Markdown."""
    lines = [
        "| kind | law | scenes | wrong | most multipliers | most ε cond S | largest error |",
        "|---|---|---|---|---|---|---|",
    ]
    for kind in Kind:
        for has_friction in (False, True):
            group = [
                j
                for j in judged
                if j.scene.kind == kind and j.scene.has_friction == has_friction
            ]
            if group:
                lines.append(row(kind, has_friction, group))
    return "\n".join(lines)


def row(kind: Kind, has_friction: bool, group: list[Judged]) -> str:
    """One line of the table."""
    right = [j for j in group if j.wrong is None]
    cells = [
        kind,
        "Tresca" if has_friction else "none",
        len(group),
        len(group) - len(right),
        max((j.n_multipliers for j in group), default=0),
        f"{max((j.rounding for j in right), default=0.0):.0e}",
        f"{max((j.error for j in right), default=0.0):.0e}",
    ]
    return f"| {' | '.join(map(str, cells))} |"


def on_springs(asked: argparse.Namespace) -> int:
    """Judge blocks on springs; 1 if any answer without friction or with Tresca's law is wrong or missing."""
    program = Program.find(asked.program)
    counts: Counter = Counter()
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(asked.first, asked.first + asked.scenes):
            one = sprung(asked.seed, number, asked.sprung)
            judged = springs.judge(program, one, Path(folder))
            counts[one.law, judged.status, judged.wrong is None] += 1
            if judged.wrong:
                print(f"{one.name}, E/kL {judged.softness:.0e}: {judged.wrong}", flush=True)
                failed += one.law != "coulomb"
    for law in LAWS:
        rows = {key[1:]: count for key, count in counts.items() if key[0] == law}
        words = [f"{status}{'' if right else ', wrong'} {n}" for (status, right), n in sorted(rows.items())]
        print(f"{law}: {'; '.join(words)}")
    return int(failed > 0)


def main() -> int:
    """Judge the scenes; 1 if any answer is wrong or missing."""
    asked = asked_for()
    if asked.sprung:
        return on_springs(asked)
    numbers = range(asked.first, asked.first + asked.scenes)
    scenes = [scene(asked.seed, number) for number in numbers]
    if asked.write:
        asked.write.mkdir(parents=True, exist_ok=True)
        for one in scenes:
            (asked.write / f"{one.name}.toml").write_text(one.text)
        return 0
    program = Program.find(asked.program)
    judged = []
    with tempfile.TemporaryDirectory() as folder:
        for one in scenes:
            judged.append(judge(program, one, Path(folder)))
            if judged[-1].wrong:
                print(f"{one.name}: {judged[-1].wrong}", flush=True)
    print(table(judged))
    print("statuses:", dict(Counter(j.status for j in judged)))
    return int(any(j.wrong for j in judged))


if __name__ == "__main__":
    sys.exit(main())
