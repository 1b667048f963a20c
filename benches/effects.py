#!/usr/bin/env python3
"""What each model feature costs: unknowns, operator applications and seconds, against the full model on the same mesh.

    python3 benches/effects.py [--n-div 16] [--repeat 3] [--threads 1] [--least]

The full model is the published one: orthotropic Coulomb friction that follows the slip. The rows
above it leave effects out, the rows below it add one each. Runs of all rows alternate. Printed as
Markdown: wall-clock seconds of the dual operator and of the solve as the program measures them, and
processor seconds of the whole run, files included; medians, or with --least the least of the runs,
since other users of a machine can only add. Needs Python 3 and the program
(target/release/contact3d-pipe, or CONTACT3D_PIPE).
"""

import argparse
import datetime
import json
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
PROGRAM = os.environ.get("CONTACT3D_PIPE", str(HERE.parent / "target/release/contact3d-pipe"))
FULL_SCENE = (HERE.parent / "pipelines/newton.toml").read_text()
FULL = "orthotropic Coulomb that follows the slip (full)"

BODY, REST = FULL_SCENE.split("[contact]\n")
CONTACT, FULL_LAW = REST.split("[friction.coefficient_1.ramp]\n")
CONTACT = "[contact]\n" + CONTACT
FULL_LAW = "[friction.coefficient_1.ramp]\n" + FULL_LAW
WOOD = """[material.orthotropic]
young_moduli = [21e10, 18e10, 15e10]
poisson_ratios = [0.25, 0.25, 0.25]
shear_moduli = [7e10, 7e10, 7e10]
"""
REGION = """[[region]]
part.box = [[0, 0, 0], [3, 1, 0.25]]
material.isotropic = { young_modulus = 1e11, poisson_ratio = 0.3 }
"""


def with_material(material):
    """The body with another material."""
    before, after = BODY.split("[material.isotropic]\n")
    return before + material + after[after.index("[[clamp]]"):]


def with_contact(key):
    """The contact table with one more key."""
    return CONTACT.rstrip() + f"\n{key}\n\n"


CLAMP = '[[clamp]]\nface = "x_min"\n'
SPRING = "[[spring]]\nface = 'y_max'\nnormal = 1e11\ntangential = 5e10\n\n"
WALL = "\n[[contact]]\nface = 'y_min'\nfriction.coefficient.constant = 0.3\n"
STEPS = "\n[[step]]\nincrements = 4\n"


def without(text, part):
    """A text without one part, which it must have."""
    before, after = text.split(part)
    return before + after


def of_contact(law):
    """The law as one of the first of several contact faces."""
    return law.replace("[friction.", "[contact.friction.")


SCENES = {
    "elasticity alone": BODY,
    "+ contact, frictionless": BODY + CONTACT,
    "+ given slip bound (Tresca)": BODY + CONTACT + "[friction]\nslip_bound = 5e6\n",
    "+ isotropic Coulomb": BODY + CONTACT + "[friction]\ncoefficient.constant = 0.3\n",
    "+ orthotropic Coulomb": BODY + CONTACT
    + "[friction]\ncoefficient_1.constant = 0.3\ncoefficient_2.constant = 0.2\n",
    "+ coefficients of the place": BODY + CONTACT
    + "[friction]\ncoefficient_1.expression = '0.2 + 0.05*x'\ncoefficient_2.constant = 0.2\n",
    FULL: BODY + CONTACT + FULL_LAW,
    "full + initial gap": BODY + with_contact("gap = '2e-6*x'") + FULL_LAW,
    "full + turning frame": BODY + with_contact("angle = '10*x'") + FULL_LAW,
    "full + body force": BODY + "[body_force]\nvalue = [0, 0, -77e3]\n" + CONTACT + FULL_LAW,
    "full + region": BODY + REGION + CONTACT + FULL_LAW,
    "full + orthotropic material": with_material(WOOD) + CONTACT + FULL_LAW,
    "full + nodal multipliers": BODY + with_contact("multipliers = 'nodal'") + FULL_LAW,
    "full + prescribed displacement": BODY.replace(CLAMP, CLAMP + "value = [1e-6, 0.0, 0.0]\n") + CONTACT + FULL_LAW,
    "full + springs": BODY + SPRING + CONTACT + FULL_LAW,
    "full + obstacle": BODY + with_contact("obstacle.height.value = '-2e-6*x^2'") + FULL_LAW,
    "full + second contact face": BODY + "[" + CONTACT.replace("[contact]", "[contact]]") + of_contact(FULL_LAW) + WALL,
    "full, held by contact alone": without(BODY, CLAMP) + CONTACT + FULL_LAW,
    "full, in four increments": BODY + CONTACT + FULL_LAW + STEPS,
}


def run(scene, n_div, threads, folder):
    """One run from scratch: the program's JSON, with the processor seconds of the process."""
    (folder / "scene.toml").write_text(scene)
    for old in folder.glob("run*.h5"):
        old.unlink()
    command = [
        PROGRAM, "run", str(folder / "scene.toml"), str(folder / "run.h5"),
        "--set", f"body.brick.cells=[{3 * n_div},{n_div},{n_div}]",
        "--no-figures", "--quiet", "--json", "--threads", str(threads),
    ]
    child = subprocess.Popen(command, stdout=subprocess.PIPE)
    output = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    if os.waitstatus_to_exitcode(status) != 0:
        sys.exit(f"failed: {' '.join(command)}")
    return json.loads(output) | {"processor": usage.ru_utime + usage.ru_stime}


def seconds(result, stage):
    """Seconds of computing in a stage."""
    return sum(s["compute_seconds"] for s in result["stages"] if s["stage"] == stage)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--n-div", type=int, default=16)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--least", action="store_true")
    arguments = parser.parse_args()
    results = {name: [] for name in SCENES}
    with tempfile.TemporaryDirectory() as scratch:
        for _ in range(arguments.repeat):
            for name, scene in SCENES.items():
                folder = pathlib.Path(scratch)
                results[name].append(run(scene, arguments.n_div, arguments.threads, folder))

    choose = min if arguments.least else statistics.median

    def chosen(name, figure):
        return choose(figure(result) for result in results[name])

    print(f"n_div = {arguments.n_div}, {'least' if arguments.least else 'medians'} of {arguments.repeat} runs, {arguments.threads} thread(s), "
          f"{os.cpu_count()}-core {platform.machine()}, {datetime.date.today():%d %B %Y}\n")
    print("| scene | unknowns u | multipliers | slips | n_A | dual operator s | solve s | whole run s | of the full model |")
    print("|---|---|---|---|---|---|---|---|---|")
    full = chosen(FULL, lambda r: r["processor"])
    for name in SCENES:
        first = results[name][0]
        costs = {e["effect"]: e["unknowns"] for e in first["effects"]["present"]}
        slips = costs.get("slip-dependent coefficients", 0)
        operator = chosen(name, lambda r: r["assembly_seconds"]["dual_operator"])
        solving = chosen(name, lambda r: seconds(r, "solve"))
        whole = chosen(name, lambda r: r["processor"])
        print(f"| {name} | {first['n_free']:,} | {first['n_multipliers']:,} | {slips:,} "
              f"| {first['applications']} | {operator:.3f} | {solving:.3f} | {whole:.2f} | {whole / full:.2f} |")


if __name__ == "__main__":
    main()
