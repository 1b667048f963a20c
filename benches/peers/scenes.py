"""The scenes of the comparison, and how the program is given them; standard library only.

compare.py imports nothing heavy: on Linux the peak memory reported for a child process is never
below that of the parent at its start.
"""

import subprocess
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCENE_FILE = Path(__file__).with_name("hkl_brick.toml")
PROGRAM = ROOT / "target" / "release" / "contact3d-pipe"

# J = 1/2 u.Au - l.u in N m with contact at nodes, from an independent implementation.
REFERENCE_ENERGY = {
    ("S1", 8): -7501.915760,
    ("S2", 8): -7508.308109,
    ("S3", 8): -7754.978429,
    ("S1", 16): -7592.807,
    ("S3", 16): -7846.607,
}


@dataclass(frozen=True)
class Ramp:
    """F(zeta): `initial` up to `onset` in m, a line of slope -`rate` in 1/m, then `residual`."""

    initial: float
    residual: float
    onset: float = 0.0
    rate: float = 0.0

    @property
    def is_constant(self) -> bool:
        """Whether F does not depend on slip."""
        return self.rate == 0.0

    @property
    def toml(self) -> str:
        """The law as the program reads it; it wants F > 0, so 0 becomes a negligible value."""
        if self.is_constant:
            return f"{{constant={max(self.initial, 1e-9)}}}"
        return (
            f"{{ramp={{initial={self.initial}, residual={self.residual}, "
            f"onset={self.onset}, rate={self.rate}}}}}"
        )


def constant(value: float) -> Ramp:
    """A coefficient that does not depend on slip."""
    return Ramp(value, value)


SCENES = {
    "S0": (constant(0.0), constant(0.0)),
    "S1": (constant(0.3), constant(0.3)),
    "S2": (constant(0.3), constant(0.2)),
    "S3": (Ramp(0.3, 0.2, 1e-5, 3000.0), Ramp(0.3, 0.2, 1e-5, 1000.0)),
}


def program_settings(scene: str, n_div: int) -> list[str]:
    """The --set arguments that make a scene on a mesh out of `SCENE_FILE`."""
    cells = f"body.brick.cells=[{3 * n_div},{n_div},{n_div}]"
    laws = [f"friction.coefficient_{i + 1}={SCENES[scene][i].toml}" for i in (0, 1)]
    return [word for setting in (cells, *laws) for word in ("--set", setting)]


def make_run_file(program: Path, n_div: int, path: Path) -> None:
    """Let the program mesh and assemble the brick."""
    mesh = [program, "mesh", SCENE_FILE, path, *program_settings("S3", n_div)]
    for command in (mesh, [program, "assemble", path]):
        subprocess.run([*map(str, command), "--quiet"], check=True)
