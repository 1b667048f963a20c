"""The command line of the referee."""

import argparse
import os
import sys
import tempfile
from pathlib import Path

# Small matrices: threads of the linear algebra only get in each other's way.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

if __package__ in (None, ""):
    # Run as a folder: the folder's parent holds this package and the readers it uses.
    sys.path[0] = str(Path(__file__).resolve().parent.parent)

from faults.program import Program
from trust.judge import Judged, judge
from trust.keep import keep
from trust.scenes import Kind, Scene, scene
from trust.summary import failed, methods_table, offenders, table

EPSILONS = (1e-4, 1e-6, 1e-9, 1e-12)


def arguments() -> argparse.Namespace:
    """What was asked for."""
    parser = argparse.ArgumentParser(prog="trust", description=__doc__)
    parser.add_argument("--scenes", type=int, default=504, help="number of scenes")
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--program", type=Path, help="target/release/contact3d-pipe")
    parser.add_argument("--kind", type=Kind, choices=list(Kind), help="one kind only")
    parser.add_argument("--epsilon", type=float, nargs="*", default=EPSILONS)
    parser.add_argument(
        "--methods", type=float, metavar="EPS", help="other methods too, at EPS"
    )
    parser.add_argument("--markdown", action="store_true", help="print the table alone")
    parser.add_argument(
        "--keep", type=Path, help="folder for scenes, S, h and solutions"
    )
    parser.add_argument("--scratch", type=Path, help="folder for run files")
    parser.add_argument(
        "--write",
        type=int,
        metavar="N",
        help="write scene N to the folder of --keep, no more",
    )
    return parser.parse_args()


def again(chosen: argparse.Namespace, judged: Judged) -> str:
    """The command that judges one scene again and keeps its text."""
    kind = f" --kind {chosen.kind}" if chosen.kind else ""
    where = f"--seed {chosen.seed} --first {judged.scene.number} --scenes 1"
    return f"python3 python-checks/trust {where}{kind} --keep FOLDER"


def judge_all(chosen: argparse.Namespace, scenes: list[Scene]) -> list[Judged]:
    """Judge scene after scene, and show what is wrong as it comes."""
    program = Program(chosen.program.resolve()) if chosen.program else Program.find()
    results = []
    with tempfile.TemporaryDirectory(dir=chosen.scratch) as folder:
        for one in scenes:
            judged = judge(
                program, one, list(chosen.epsilon), chosen.methods, Path(folder)
            )
            if chosen.keep:
                keep(judged, chosen.keep)
            results.append(judged)
            if judged.wrong and not chosen.markdown:
                print(
                    f"{one.name}: {'; '.join(judged.wrong)}",
                    file=sys.stderr,
                    flush=True,
                )
    return results


def main() -> int:
    """Judge scenes and print the table; 1 if an answer is worse than it says."""
    chosen = arguments()
    if chosen.write is not None:
        one = scene(chosen.seed, chosen.write, chosen.kind)
        folder = chosen.keep or Path()
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{one.name}.toml").write_text(one.text)
        return 0
    numbers = range(chosen.first, chosen.first + chosen.scenes)
    judged = judge_all(chosen, [scene(chosen.seed, n, chosen.kind) for n in numbers])
    print(table(judged))
    for more in (
        methods_table(judged),
        "" if chosen.markdown else offenders(judged, lambda one: again(chosen, one)),
    ):
        if more:
            print(f"\n{more}")
    return int(failed(judged))


if __name__ == "__main__":
    sys.exit(main())
