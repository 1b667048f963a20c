"""Error bars of coarse meshes against fine ones, on random scenes.

Every scene is a function of the seed and of its number. A quantity with a bar counts as held if it lies no further from its value on a
mesh with a quarter of the edge than the bar, and half of what that value still moves by from a mesh with half of the edge.
"""

import argparse
import json
import random
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median

if __package__ in (None, ""):
    sys.path[0] = str(Path(__file__).resolve().parent)

from campaign import arguments, require

require("blake3", "h5py")

from faults.program import Program

WIDE = 5.0
"""A bar is wide if it is so many times the error"""
NARROW = 0.1
"""and not below this share of the value, for errors change their sign."""
FEWEST_PANES = 16
"""With fewer the program says beside an area that it saw few."""
AREAS = ("contact_area", "stick_area")
ROUNDING = 1e-9
"""Less of a value is no error: areas are sums over triangles."""


@dataclass(frozen=True)
class Bar:
    """A quantity on a coarse mesh, with its distance from the fine one."""

    scene: int
    name: str
    value: float
    bar: float
    error: float
    uncertain: float

    @property
    def short(self) -> float:
        """How many times further off than said, at least."""
        beyond = self.error - self.uncertain - ROUNDING * abs(self.value)
        return max(beyond, 0.0) / max(self.bar, ROUNDING * abs(self.value), 1e-300)

    @property
    def is_wide(self) -> bool:
        """Whether the bar is several times too wide, at least."""
        least = WIDE * (self.error + self.uncertain)
        return self.bar > max(least, NARROW * abs(self.value))


def text_of(seed: int, number: int, factor: int) -> str:
    """A scene with a mesh that is so many times finer, and quadratic where it is the finest."""
    at = random.Random(f"{seed} {number}")
    length, height = at.uniform(1.5, 3.0), at.uniform(0.6, 1.2)
    is_linear = at.random() < 0.3
    cells = [at.choice([4, 5]), 2, 2]
    if is_linear:
        cells = [2 * n for n in cells]
    finer = max(factor // 2, 1) if is_linear else factor
    element = "P2" if factor > 1 or not is_linear else "P1"
    lines = [
        'title = "bars"',
        f'body.element = "{element}"',
        f"body.brick.size = [{length:.3f}, 1.0, {height:.3f}]",
        f"body.brick.cells = {[finer * n for n in cells]}",
        f"material.isotropic = {{ young_modulus = 2.1e11, poisson_ratio = {at.choice([0.2, 0.3, 0.4])} }}",
    ]
    down, along = at.uniform(2e-5, 6e-5) * height, at.uniform(0.0, 2e-5)
    clamp = at.choice(["end", "top", "small", "end", "ends"])
    whole = f"value = [{along:.3e}, 0.0, {-down:.3e}]"
    match clamp:
        case "end":
            lines.append('[[clamp]]\nface = "x_min"')
        case "ends":
            lines.append('[[clamp]]\nface = "x_min"\n[[clamp]]\nface = "x_max"')
        case "top":
            lines.append(f'[[clamp]]\nface = "z_max"\n{whole}')
        case _:
            # Two cells of the coarse mesh, so that all meshes have the same.
            width = 2.0 * length / cells[0]
            corners = f"[[{width:.6f}, 0.0, {height:.3f}], [{2 * width:.6f}, 0.5, {height:.3f}]]"
            lines.append(f"[[clamp]]\nbox = {corners}\n{whole}")
    if clamp in ("end", "ends"):
        load = at.choice(["constant", "formula", "both"])
        size = at.uniform(1e7, 4e7)
        value = f"{size:.3e}"
        if load == "formula":
            value = f'"{size:.3e}*(1 + sin({at.uniform(2, 30):.1f}*x)*cos({at.uniform(2, 20):.1f}*y))"'
        lines.append(f'[[pressure]]\nface = "z_max"\nvalue = {value}')
        if load == "both" and clamp == "end":
            pulled = at.uniform(-2e7, 2e7)
            lines.append(f'[[traction]]\nface = "x_max"\nvalue = [{pulled:.3e}, 0.0, 0.0]')
    lines.append('[contact]\nface = "z_min"')
    deep = at.uniform(0.3, 1.0) * (down if clamp in ("top", "small") else 3e-5)
    match at.choice(["flat", "gap", "hills", "ball", "roller"]):
        case "gap":
            lines.append(
                f'gap = "{deep / 2:.3e}*(1 - cos({at.uniform(2, 12):.1f}*x)*cos({at.uniform(2, 12):.1f}*y))"'
            )
        case "hills":
            wave = at.uniform(0.15, 1.0)
            lines.append(
                f'obstacle.height.value = "{deep / 2:.3e}*(cos(2*PI*x/{wave:.3f}) - 1)"'
            )
        case "ball" | "roller" as kind:
            # It leaves the face by the depth at the ends.
            radius = length**2 / (8.0 * deep) * at.uniform(0.5, 2.0)
            place = f"[{length / 2:.4f}, 0.5, {-radius:.6e}], radius = {radius:.6e}"
            lines.append(
                f"obstacle.sphere = {{ centre = {place} }}"
                if kind == "ball"
                else f"obstacle.cylinder = {{ point = {place}, direction = [0.0, 1.0, 0.0] }}"
            )
        case _:
            pass
    match at.choice(["none", "constant", "constant", "formula", "bound"]):
        case "constant":
            lines.append(f"[friction]\ncoefficient.constant = {at.uniform(0.1, 0.6):.3f}")
        case "formula":
            middle, wide = at.uniform(0.0, length), at.uniform(0.15, 1.0)
            lines.append(
                f'[friction]\ncoefficient.expression = "0.1 + 0.4*exp(-((x - {middle:.2f})/{wide:.2f})^2)"'
            )
        case "bound":
            lines.append(
                f'[friction]\nslip_bound = "{at.uniform(1e6, 1e7):.2e}*(1 + sin({at.uniform(1, 15):.1f}*x))"'
            )
        case _:
            pass
    return "\n".join(lines) + "\n"


def waves_of(seed: int, number: int, factor: int) -> str:
    """A face on waves of two to four cells, a roller, a ball or a wedge, of which a pressure closes a part; finer meshes as above."""
    at = random.Random(f"waves {seed} {number}")
    kind = at.choice(["along", "along", "across", "across", "roller", "ball", "wedge"])
    per_wave, is_linear = at.choice([2, 3, 4]), at.random() < 0.4
    length, width, height = at.uniform(1.5, 3.0), 1.0, at.uniform(0.6, 1.2)
    waves, rows = {"along": (at.choice([4, 6]), 2), "across": (3, per_wave)}.get(kind, (0, 4))
    cells = [waves * per_wave or 8, rows, 2]
    fine = [factor * n for n in cells]
    if kind in ("along", "roller", "wedge"):
        width, fine[1] = 0.5, 2
    fine[2] = 2 * min(factor, 3)
    if is_linear and factor == 1:
        fine = [2 * n for n in fine]
    ratio, deep = at.choice([0.0, 0.2, 0.3, 0.4]), 10 ** at.uniform(-5.0, -4.0)
    # Of the pressure that closes all of a wave in a half-space, or that a face feels of its depth.
    modulus, share = 2.1e11 / (1 - ratio**2), at.choice([0.02, 0.05, 0.1, 0.3, 0.6, 1.0])
    of_waves = share * modulus * deep * 3.141592653589793 * waves / length
    value = of_waves if waves else share * 2.0 * modulus * deep / length
    lines = [
        'title = "waves"',
        f'body.element = "{"P1" if is_linear and factor == 1 else "P2"}"',
        f"body.brick.size = [{length:.4f}, {width}, {height:.4f}]",
        f"body.brick.cells = {fine}",
        f"material.isotropic = {{ young_modulus = 2.1e11, poisson_ratio = {ratio} }}",
        f'[[pressure]]\nface = "z_max"\nvalue = {value:.5e}',
    ]
    for face in ("x_min", "x_max", "y_min", "y_max"):
        lines.append(f'[[clamp]]\nface = "{face}"\ncomponents = ["{face[0]}"]')
    lines.append('[contact]\nface = "z_min"')
    phase, radius = at.choice([0.0, 3.141592653589793, 1.3]), length**2 / (8.0 * deep) * at.uniform(0.3, 2.0)
    middle = f"{length / 2:.5f}, {width / 2}, {-radius:.6e}], radius = {radius:.6e}"
    along = f"cos(2*PI*{waves}*x/{length:.4f} + {phase})"
    lines.append(
        {
            "along": f'gap = "{deep:.4e}*(1 - {along})"',
            "across": f'gap = "{deep / 2:.4e}*(2 - {along} - cos(2*PI*y))"',
            "roller": f"obstacle.cylinder = {{ direction = [0.0, 1.0, 0.0], point = [{middle} }}",
            "ball": f"obstacle.sphere = {{ centre = [{middle} }}",
            "wedge": f'gap = "{deep:.4e}*x/{length:.4f}"',
        }[kind]
    )
    friction = at.choice([0.0, 0.0, 0.2, 0.5])
    # Nodes that a clamp holds across the friction of a round obstacle are refused.
    if at.random() < 0.4 and not (friction and kind in ("ball", "roller")):
        lines.append('multipliers = "nodal"')
    if friction:
        lines.append(f"[friction]\ncoefficient.constant = {friction}")
    return "\n".join(lines) + "\n"


def solved(program: Path, text: str, folder: Path) -> dict | None:
    """The results of a scene; None where it is not solved."""
    scene, run = folder / "scene.toml", folder / "run.h5"
    scene.write_text(text)
    run.unlink(missing_ok=True)
    command = [program, "run", scene, run, "--json", "--no-figures"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    if ended.returncode == 1 or "NOT CONVERGED" in ended.stderr:
        return None
    if ended.returncode != 0:
        raise SystemExit(f"{text}\n{ended.stderr}")
    return json.loads(ended.stdout)


def quantities(results: dict) -> dict[str, tuple[float, float | None, object]]:
    """Value, error bar and box of every quantity that is shown."""
    found = {q["name"]: (q["value"], q["error_bar"], q["box"]) for q in results["quantities"]}
    peak = results["largest_von_mises"]
    found["von_mises"] = (peak["value"], peak["error"], None)
    return found


def bars_of(program: Path, text: Callable[[int], str], number: int, folder: Path) -> list[Bar]:
    """The bars of a scene on its coarse mesh."""
    levels = [solved(program, text(factor), folder) for factor in (1, 2, 4)]
    if None in levels:
        return []
    coarse, middle, fine = map(quantities, levels)
    found = []
    has_few_panes = levels[0]["n_panes"] < FEWEST_PANES
    for name, (value, bar, box) in coarse.items():
        if bar is None or name not in fine or name not in middle:
            continue
        if name in AREAS and has_few_panes:
            continue
        if name == "peak_displacement" and not box == middle[name][2] == fine[name][2]:
            continue
        true = fine[name][0]
        uncertain = 0.5 * abs(true - middle[name][0])
        found.append(Bar(number, name, value, bar, abs(value - true), uncertain))
    return found


def told(bar: Bar) -> str:
    """A bar and its error in words."""
    of = abs(bar.value) or 1.0
    return (
        f"scene {bar.scene} {bar.name} {bar.value:.4g}: said {100 * bar.bar / of:.3g} %, "
        f"true {100 * bar.error / of:.3g} % (± {100 * bar.uncertain / of:.2g})"
    )


def table(bars: list[Bar]) -> str:
    """Counts by quantity, as Markdown."""
    lines = [
        "| quantity | bars | hold | most short | wide | median bar/error |",
        "|---|---|---|---|---|---|",
    ]
    for name in [*dict.fromkeys(bar.name for bar in bars), "all"]:
        of = [bar for bar in bars if name in (bar.name, "all")]
        held = sum(bar.short <= 1.0 for bar in of)
        ratios = [bar.bar / (bar.error + bar.uncertain) for bar in of if bar.error + bar.uncertain > 0.0]
        lines.append(
            f"| {name} | {len(of)} | {held} ({100 * held / len(of):.0f} %) | {max(bar.short for bar in of):.2g} "
            f"| {sum(bar.is_wide for bar in of)} | {median(ratios) if ratios else 0:.2g} |"
        )
    return "\n".join(lines)


def asked_for() -> argparse.Namespace:
    """What was asked for."""
    parser = arguments("bars", __doc__)
    parser.add_argument("--scenes", type=int, default=25, help="number of scenes")
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument("--waves", action="store_true", help="faces on waves, balls and wedges, and areas alone")
    parser.add_argument("--write", type=Path, help="folder for the scenes, and do no more")
    return parser.parse_args()


def main() -> int:
    """Measure, print the table; 1 if a bar is short by more than 2."""
    asked = asked_for()
    numbers = range(asked.first, asked.first + asked.scenes)
    scenes = waves_of if asked.waves else text_of
    if asked.write:
        asked.write.mkdir(parents=True, exist_ok=True)
        for number in numbers:
            for factor in (1, 2, 4):
                path = asked.write / f"{number:03}_{factor}.toml"
                path.write_text(scenes(asked.seed, number, factor))
        return 0
    program, bars = Program.find(asked.program).path, []
    with tempfile.TemporaryDirectory() as folder:
        for number in numbers:
            found = bars_of(program, partial(scenes, asked.seed, number), number, Path(folder))
            found = [bar for bar in found if bar.name in AREAS or not asked.waves]
            bars += found
            for bar in found:
                if bar.short > 1.0 or bar.is_wide:
                    print(("SHORT " if bar.short > 1.0 else "wide  ") + told(bar), flush=True)
            if not found:
                print(f"scene {number}: not solved, or no bars since the mesh is too coarse", flush=True)
    print(table(bars))
    return int(any(bar.short > 2.0 for bar in bars))


if __name__ == "__main__":
    sys.exit(main())
