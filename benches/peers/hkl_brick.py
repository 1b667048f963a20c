"""The HKL brick as the peers see it: the program's own mesh, stiffness and load, contact at nodes.

The scenes differ in friction alone: S0 frictionless, S1 isotropic F = 0.3, S2 orthotropic 0.3 and
0.2, S3 the solution-dependent law of Table 1. Peers impose non-penetration and friction on the
forces at the contact nodes (multipliers linear on triangles, lumped), the program on panes.
"""

import argparse
import json
import resource
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy import sparse

from scenes import PROGRAM, REFERENCE_ENERGY, ROOT, SCENES, Ramp, make_run_file

sys.path.insert(0, str(ROOT / "python-checks"))
from run_file import open_run, read_matrix  # noqa: E402  (needs the path above)


def coefficient(law: Ramp, slip: np.ndarray) -> np.ndarray:
    """F at some slips in m."""
    fall = law.rate * np.maximum(slip - law.onset, 0.0)
    return np.maximum(law.initial - fall, law.residual)


@dataclass(frozen=True)
class Brick:
    """A u = l + H r with contact forces r at the free contact nodes."""

    coordinates: np.ndarray
    tetrahedra: np.ndarray
    clamped: np.ndarray
    dof: np.ndarray
    stiffness: sparse.csc_matrix
    load: np.ndarray
    contact_nodes: np.ndarray
    is_quadratic: bool

    @classmethod
    def read(cls, path: Path) -> "Brick":
        """Take mesh, A and l from an assembled run file."""
        with open_run(path) as file:
            dof = file["assemble/degree_of_freedom"][:]
            nodes = file["mesh/contact_nodes"][:]
            stiffness = read_matrix(file["assemble/stiffness"])
            # CHOLMOD and SuperLU want 32-bit indices.
            stiffness.indices = stiffness.indices.astype(np.int32)
            stiffness.indptr = stiffness.indptr.astype(np.int32)
            return cls(
                coordinates=file["mesh/coordinates"][:],
                tetrahedra=file["mesh/tetrahedra"][:],
                clamped=np.flatnonzero((dof < 0).all(axis=1)),
                dof=dof,
                stiffness=stiffness,
                load=file["load/force"][:],
                contact_nodes=nodes[(dof[nodes] >= 0).all(axis=1)],
                is_quadratic="mesh/tetrahedron_mid_edges" in file,
            )

    @property
    def n_div(self) -> int:
        """Cubes along the short edges."""
        corners = np.unique(self.tetrahedra)
        return np.unique(self.coordinates[corners, 2]).size - 1

    @cached_property
    def contact_dof(self) -> np.ndarray:
        """Degrees of freedom z, x, y of each contact node: distance first, then slips."""
        return self.dof[self.contact_nodes][:, [2, 0, 1]].ravel()

    def energy(self, displacement: np.ndarray) -> float:
        """J = 1/2 u.Au - l.u in N m."""
        u = displacement
        return float(0.5 * u @ (self.stiffness @ u) - self.load @ u)


@dataclass
class Report:
    """What a peer did: printed for people, stored as JSON for compare.py."""

    peer: str
    scene: str
    brick: Brick
    data: dict

    @classmethod
    def begin(cls, peer: str, scene: str, brick: Brick) -> "Report":
        """An empty report."""
        return cls(peer, scene, brick, {"seconds": {}})

    @contextmanager
    def timed(self, part: str) -> Iterator[None]:
        """Add the wall-clock time of a block to a part."""
        start = time.perf_counter()
        yield
        seconds = self.data["seconds"]
        seconds[part] = seconds.get(part, 0.0) + time.perf_counter() - start

    def finish(self, displacement: np.ndarray, path: Path | None) -> None:
        """Add energy and memory, print all, and write JSON when asked to."""
        energy = self.brick.energy(displacement)
        key = (self.scene, self.brick.n_div)
        reference = None if self.brick.is_quadratic else REFERENCE_ENERGY.get(key)
        seconds = self.data["seconds"]
        solving = sum(value for part, value in seconds.items() if part != "assembly")
        kilobytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        self.data |= {
            "peer": self.peer,
            "scene": self.scene,
            "n_div": self.brick.n_div,
            "energy": energy,
            "energy_error": None if reference is None else energy / reference - 1.0,
            "seconds_without_assembly": solving,
            "peak_megabytes": kilobytes / 1024,
        }
        print(f"{self.peer}, {self.scene}, n_div = {self.brick.n_div}")
        print(f"  J = {energy:.6f} N m, reference {reference}")
        for part, value in seconds.items():
            print(f"  {part:<14} {value:9.3f} s")
        print(f"  {'all but assembly':<14} {solving:7.3f} s")
        for name in ("iterations", "outer_steps", "converged", "residual"):
            if name in self.data:
                print(f"  {name:<14} {self.data[name]}")
        print(f"  peak memory    {self.data['peak_megabytes']:9.0f} MB")
        if path:
            path.write_text(json.dumps(self.data, indent=1) + "\n")


def peer_arguments(description: str) -> argparse.ArgumentParser:
    """The arguments that all peers share."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("run_file", type=Path, help="an assembled run file")
    parser.add_argument("--scene", choices=SCENES, default="S1")
    parser.add_argument("--json", type=Path, help="also write the results here")
    return parser


def main() -> None:
    """Write an assembled run file of the brick."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("run_file", type=Path)
    parser.add_argument("--n-div", type=int, default=8)
    parser.add_argument("--program", type=Path, default=PROGRAM)
    arguments = parser.parse_args()
    make_run_file(arguments.program, arguments.n_div, arguments.run_file)


if __name__ == "__main__":
    main()
