"""python -m contact3d.theory SCENE: the table of :func:`contact3d.theory.measure`, and what it means."""

import argparse
import json
import sys
import tomllib
from dataclasses import asdict
from typing import Any

from .. import ProgramError
from . import NotCovered, measure


def change(text: str) -> tuple[str, Any]:
    """KEY=VALUE with a TOML value."""
    key, _, value = text.partition("=")
    try:
        return key, tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError as error:
        raise argparse.ArgumentTypeError(f"expected KEY=VALUE with a TOML value, found {text}") from error


def main() -> int:
    """Exit codes: 0, 1 where the figures contradict each other or a mesh has no solution, 2 for bad input."""
    parser = argparse.ArgumentParser("python -m contact3d.theory", description="Measure the constants of HKL section 3 for a scene.")
    parser.add_argument("scene", help="a scene with Coulomb friction on one face")
    parser.add_argument("--set", metavar="KEY=VALUE", type=change, action="append", default=[], help="change one key of the scene")
    parser.add_argument("--coarsest", metavar="N_DIV", type=int, default=2, help="smallest n_div of the meshes of a brick")
    parser.add_argument("--finest", metavar="N_DIV", type=int, help="largest n_div, a multiple of the scene's")
    parser.add_argument("--mesh", metavar="FILE", action="append", default=[], help="a Gmsh file of the body; once for each mesh")
    parser.add_argument("--figure", metavar="FILE", help="draw the factors of the law at which bounds and the mapping reach 1")
    parser.add_argument("--json", action="store_true", help="print JSON")
    given = parser.parse_args()
    try:
        theory = measure(given.scene, set=dict(given.set), coarsest=given.coarsest, finest=given.finest, meshes=given.mesh,
                         tell=lambda words: print(words, file=sys.stderr, flush=True))
    except (NotCovered, ProgramError) as error:
        print(f"error: {error}", file=sys.stderr)
        return getattr(error, "exit_code", 2)
    if given.figure:
        theory.plot().figure.savefig(given.figure)
    if given.json:
        print(json.dumps({**asdict(theory), "findings": theory.findings}, indent=2))
    else:
        print(theory.table.to_string(float_format="{:.5g}".format))
        print(theory.findings)
    for problem in theory.problems:
        print(f"NOT CONVERGED: {problem}", file=sys.stderr)
    return 1 if theory.problems else 0


if __name__ == "__main__":
    sys.exit(main())
