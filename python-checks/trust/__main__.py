"""The command line of the referee."""

import argparse
import dataclasses
import os
import sys
import tempfile
from pathlib import Path

# Small matrices: threads of the linear algebra only get in each other's way.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

if __package__ in (None, ""):
    # Run as a folder: the folder's parent holds this package and the readers it uses.
    sys.path[0] = str(Path(__file__).resolve().parent.parent)

from campaign import arguments, require

require("blake3", "h5py", "numpy", "scipy")

from faults.program import Program
from trust.judge import Judged, judge
from trust.keep import keep
from trust.scenes import Kind, Scene, scene
from trust.summary import failed, methods_table, offenders, several, table

EPSILONS = (1e-4, 1e-6, 1e-9, 1e-12)


def asked_for() -> argparse.Namespace:
    """What was asked for."""
    parser = arguments("trust", __doc__)
    parser.add_argument("--scenes", type=int, default=504, help="number of scenes")
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument("--kind", type=Kind, choices=list(Kind), help="one kind only")
    parser.add_argument(
        "--capped", action="store_true", help="friction capped at a random pressure"
    )
    parser.add_argument(
        "--single",
        action="store_true",
        help="a factor in single precision; scenes without one are counted",
    )
    parser.add_argument("--epsilon", type=float, nargs="*", default=EPSILONS)
    parser.add_argument(
        "--methods", type=float, metavar="EPS", help="other methods too, at EPS"
    )
    parser.add_argument(
        "--markdown", action="store_true", help="print the tables alone"
    )
    parser.add_argument(
        "--keep", type=Path, help="folder for scenes, S, h and solutions"
    )
    parser.add_argument("--scratch", type=Path, help="folder for run files")
    parser.add_argument(
        "--write",
        nargs=2,
        metavar=("N", "FOLDER"),
        help="write the text of scene N to a folder, and do no more",
    )
    return parser.parse_args()


def again(chosen: argparse.Namespace, judged: Judged) -> str:
    """The commands that judge one scene again and that write its text."""
    command = f"python3 python-checks/trust --seed {chosen.seed}"
    if chosen.kind:
        command += f" --kind {chosen.kind}"
    if chosen.capped:
        command += " --capped"
    if chosen.single:
        command += " --single"
    number = judged.scene.number
    return f"{command} --first {number} --scenes 1; {command} --write {number} ."


def in_single_precision(one: Scene) -> Scene:
    """A scene that asks for a factor in single precision."""
    text = one.text + '\n[assemble]\nfactor = "single"\n'
    return dataclasses.replace(one, text=text)


def judge_all(chosen: argparse.Namespace, scenes: list[Scene]) -> list[Judged]:
    """Judge scene after scene, and show what is wrong as it comes."""
    program = Program.find(chosen.program)
    results, refused = [], 0
    with tempfile.TemporaryDirectory(dir=chosen.scratch) as folder:
        for one in scenes:
            judged = judge(
                program, one, list(chosen.epsilon), chosen.methods, Path(folder)
            )
            if chosen.single and judged.refused:
                refused += 1
                continue
            if chosen.keep:
                keep(judged, chosen.keep)
            results.append(judged)
            if judged.wrong and not chosen.markdown:
                print(
                    f"{one.name}: {'; '.join(judged.wrong)}",
                    file=sys.stderr,
                    flush=True,
                )
    if refused:
        print(f"{refused} scenes have no factor in single precision", file=sys.stderr)
    return results


def main() -> int:
    """Judge scenes and print the table; 1 if an answer is worse than it says."""
    chosen = asked_for()
    if chosen.write:
        number, folder = int(chosen.write[0]), Path(chosen.write[1])
        one = scene(chosen.seed, number, chosen.kind, chosen.capped)
        one = in_single_precision(one) if chosen.single else one
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{one.name}.toml").write_text(one.text)
        return 0
    numbers = range(chosen.first, chosen.first + chosen.scenes)
    scenes = [scene(chosen.seed, n, chosen.kind, chosen.capped) for n in numbers]
    if chosen.single:
        scenes = [in_single_precision(one) for one in scenes]
    judged = judge_all(chosen, scenes)
    print(table(judged))
    more = [methods_table(judged)]
    if not chosen.markdown:
        more += [several(judged), offenders(judged, lambda one: again(chosen, one))]
    for text in more:
        if text:
            print(f"\n{text}")
    return int(failed(judged))


if __name__ == "__main__":
    sys.exit(main())
