#!/usr/bin/env python3
"""Runs every scene of pipelines and writes the gallery: pipelines/README.md, and a small picture of each in pipelines/gallery.

    python3 scripts/gallery.py [SCENE ...]

Without names it runs all scenes, on the program in target/release or named by CONTACT3D_PIPE. What a scene shows and what
to expect are its own first two comments. Needs Pillow.
"""

import os
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
PIPELINES = ROOT / "pipelines"
GALLERY = PIPELINES / "gallery"
PROGRAM = os.environ.get("CONTACT3D_PIPE", str(ROOT / "target/release/contact3d-pipe"))
# Pixels across, and the colours of a picture.
WIDTH, COLOURS = 480, 128

# Scenes by task, in the order of the page.
TASKS = {
    "Press": "pressed shrink_fit barrel platen frictionless force_on_disc hertz_sphere hertz_cylinder gap symmetry_plane weight",
    "Drag": "newton hkl2011_table1 hkl2011_table2 coulomb_isotropic coulomb_orthotropic tresca capped expression_law "
    "table_law turning_frame parameters dry_and_greased wall ssnv128 ssnv503",
    "Load in steps and loops": "history history_wear cattaneo_roller rail roller",
    "Let two bodies touch": "two_blocks elastic_foundation stack two_cylinders two_balls two_rings bolt glued",
    "Sweep": "sweep_friction sweep_slope",
    "Hold by contact or springs": "block_on_slope pushed_block corner_block slope two_plates springs",
    "Take a mesh from elsewhere": "gmsh_foot cup wedge",
    "Choose a mesh": "graded quadratic adaptive nodal",
    "Rubber": "wavy",
    "Two materials, and other materials": "regions orthotropic_material voigt_material elastic_only",
    "Other units": "millimetres inches",
}
# Pictures that show a scene better than its deformed body does.
PICTURES = {
    "friction_loop": "history history_wear cattaneo_roller two_blocks",
    "d_friction_ellipses": "coulomb_orthotropic turning_frame table_law expression_law tresca capped dry_and_greased",
    "a_contact_pressure": "hertz_sphere cup wavy nodal force_on_disc two_balls",
    "von_mises": "shrink_fit two_rings elastic_only adaptive graded",
    "overview": "newton",
    "tangential_force_1": "sweep_friction sweep_slope",
}
# Where a test compares with the closed form, or the published results.
TESTS = {
    "python-checks/test_faces.py": "slope two_plates wedge",
    "python-checks/test_history.py": "cattaneo_roller rail",
    "python-checks/test_obstacle.py": "shrink_fit barrel",
    "python-checks/test_pairs.py": "stack two_cylinders two_balls two_rings bolt",
    "python-checks/test_supports.py": "force_on_disc",
    "crates/contact3d/tests/scenes/floating/limits.rs": "block_on_slope sweep_slope pushed_block corner_block",
    "crates/contact3d/tests/scenes/obstacles/hertz.rs": "hertz_sphere hertz_cylinder cup",
    "crates/contact3d/tests/scenes/closed_forms.rs": "turning_frame",
    "crates/contact3d/tests/scenes/tools.rs": "platen",
    "crates/contact3d/tests/scenes/glued.rs": "glued",
    "tests/all/verification.rs": "newton ssnv128 ssnv503",
}


def named(table: dict[str, str], scene: str, otherwise: str = "") -> str:
    """The key of a table that lists the scene."""
    return next((key for key, scenes in table.items() if scene in scenes.split()), otherwise)


def header(scene: str) -> dict[str, str]:
    """The comments of a scene: what it shows, and what to expect."""
    lines = (PIPELINES / f"{scene}.toml").read_text().splitlines()
    return dict(re.findall(r"^# (\w+): (.*)$", "\n".join(lines[:3]), re.MULTILINE))


def run(scene: str) -> float:
    """Runs a scene and makes its small picture; returns the processor seconds of the run without pictures."""
    file = PIPELINES / f"{scene}.toml"
    command = [PROGRAM, "sweep" if scene.startswith("sweep_") else "run", "--quiet", str(file)]
    with tempfile.TemporaryDirectory() as scratch:
        made, figures = Path(scratch) / "made", Path(scratch) / "figures"
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        status = subprocess.run([*command, str(made), "--no-figures"], stdout=subprocess.DEVNULL, check=False).returncode
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        # 1: some cases of a sweep have no equilibrium, or the published stopping rule leaves an error.
        assert status <= 1, f"{scene}: exit code {status}"
        subprocess.run([*command, str(made), "--figures", str(figures)], stdout=subprocess.DEVNULL, check=False)
        # With several contact faces the first.
        drawn = sorted(figures.glob(f"{named(PICTURES, scene, 'c_deformed_body')}*.png"))[0]
        picture = Image.open(drawn).convert("RGB")
        picture = picture.resize((WIDTH, round(WIDTH * picture.height / picture.width)), Image.Resampling.LANCZOS)
        GALLERY.mkdir(exist_ok=True)
        picture.quantize(COLOURS).save(GALLERY / f"{scene}.png", optimize=True)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def entry(scene: str, seconds: str) -> str:
    """What the page says about a scene."""
    said = header(scene)
    test = named(TESTS, scene)
    checked = f" [Test](../{test})." if test else ""
    return f"""| ![{scene}](gallery/{scene}.png) | **[{scene}]({scene}.toml)** ({seconds} s): {said["Shows"].rstrip(".")}. \
*Expect* {said["Expect"].rstrip(".")}.{checked} |"""


def main() -> None:
    scenes = " ".join(TASKS.values()).split()
    there = {path.stem for path in PIPELINES.glob("*.toml")}
    assert set(scenes) == there, f"no task, or no scene: {set(scenes) ^ there}"
    page = PIPELINES / "README.md"
    told = dict(re.findall(r"\*\*\[(\w+)\]\S+\*\* \((\S+) s\)", page.read_text())) if page.exists() else {}
    for scene in sys.argv[1:] or scenes:
        told[scene] = f"{run(scene):.1f}"
        print(scene, told[scene], flush=True)
    parts = [
        "# Gallery",
        "A scene for each feature, by task, with the processor seconds of a run without pictures. Made by\n"
        "`python3 scripts/gallery.py`. Run one with `contact3d-pipe run pipelines/newton.toml newton.h5`, a sweep with\n"
        "`contact3d-pipe sweep pipelines/sweep_slope.toml slope`.",
    ]
    for task, names in TASKS.items():
        rows = [entry(scene, told[scene]) for scene in names.split()]
        parts.append("\n".join([f"## {task}\n", "| | |", "|---|---|", *rows]))
    page.write_text("\n\n".join(parts) + "\n")


if __name__ == "__main__":
    main()
