"""The discrete problem of one mesh, from the arrays of its run file."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse

from .._run import Run
from ._face import ContactFace
from ._forms import Array, Solve, factor, scalar_forms

#: Columns that are solved for at once: a hundred megabytes on the published mesh.
BLOCK_COLUMNS = 256


class NotCovered(ValueError):
    """A scene beyond HKL sections 2 and 3."""


def require_covered(run: Run) -> None:
    """Refuses what the theory does not cover."""
    scene, nodes = run.scene, run["mesh/contact_nodes"].values if "contact_nodes" in run["mesh"] else []
    contact = scene.get("contact", {})
    faces = contact if isinstance(contact, list) else [contact]
    friction = faces[0].get("friction") or scene.get("friction")
    held_at = run["load"].get("prescribed_displacement")
    for applies, reason in (
        ("step" in scene, "step: HKL have no load history; leave the steps out"),
        (len(faces) != 1, "contact: HKL section 2 has one face; leave the others out"),
        (not friction or "slip_bound" in friction,
         "friction: expected Coulomb friction; other scenes have one solution, and no mapping to study"),
        ("obstacle" in faces[0], "contact.obstacle: HKL section 2 has a flat face on its foundation; leave the obstacle out"),
        (bool(faces[0].get("gap")), "contact.gap: the radii of Lemma 3.3 compare u with 0 and 2u, which a gap excludes; set it to 0"),
        ("tetrahedron_mid_edges" in run["mesh"], "body.element: quadratic interpolation does not preserve signs (3.2); use P1"),
        ("tool_degree_of_freedom" in run["assemble"], "tool: expected obstacles that rest; leave out contact.tool"),
        ("rigid_modes" in run["assemble"], "clamp: expected a body that its supports hold; add clamps"),
        (held_at is not None and held_at.values[nodes].any(),
         "clamp: contact nodes are held at zero or not at all; hold other faces, or leave value out"),
    ):
        if applies:
            raise NotCovered(reason)


@dataclass(frozen=True)
class Problem:
    """A u = l - B' lambda with multipliers on panes, or on nodes, of one face with friction: lambda_nu of all, then pairs lambda_t.

    :param frame: nu, t1, t2 at the contact nodes, [n, 3, 3].
    :param integrals: of the hat functions over panes, [m, n].
    :param areas: of the panes, [m].
    :param load: l over the free degrees of freedom, whose numbers are those of ``dofs``, [nodes, 3], -1 where held.
    """

    run: Run
    face: ContactFace
    frame: Array
    integrals: Array
    areas: Array
    load: Array
    dofs: Array

    @classmethod
    def of(cls, run: Run) -> "Problem":
        """The problem of a run file that has all stages."""
        require_covered(run)
        mesh = run["mesh"]
        nodes, areas, dofs = mesh["contact_nodes"].values, mesh["pane_area"].values, run["assemble/degree_of_freedom"].values
        triangles = np.searchsorted(nodes, mesh["facets"].values[mesh["contact_facets"].values])
        free = np.flatnonzero((dofs[nodes] >= 0).any(axis=1))
        normals = mesh["contact_node_normal" if "contact_node_normal" in mesh else "contact_normal"].values
        axes = [np.broadcast_to(normals, (len(nodes), 3)), *(run[f"post/contact_axis_{k}"].values for k in (1, 2))]
        face = ContactFace(mesh["coordinates"].values[nodes], triangles, free)
        integrals = (run.matrices["mesh/pane_average"].toarray() * areas).T
        return cls(run, face, np.stack(axes, axis=1), integrals, areas, run["load/force"].values, dofs)

    @property
    def contact(self) -> dict[str, Any]:
        """The only entry of ``contact``."""
        entry = self.run.scene["contact"]
        return entry[0] if isinstance(entry, list) else entry

    @cached_property
    def panes(self) -> Array | None:
        """The pane of each triangle; None for nodal multipliers."""
        mesh = self.run["mesh"]
        return mesh["contact_facet_pane"].values if "contact_facet_pane" in mesh else None

    @cached_property
    def big_h(self) -> float:
        """H: the largest diameter of a pane; h for nodal multipliers."""
        if self.panes is None:
            return self.face.h
        corners = [self.face.points[np.unique(self.face.triangles[self.panes == k])] for k in range(len(self.areas))]
        return max(float(np.linalg.norm(part[:, None] - part, axis=2).max()) for part in corners)

    @cached_property
    def stiffness(self) -> sparse.csc_array:
        """A over the free degrees of freedom."""
        return self.run.matrices["assemble/stiffness"]

    @cached_property
    def sobolev(self) -> sparse.csc_array:
        """The products of H1(Omega)^3 over the free degrees of freedom; lengths in the unit of the scene."""
        mesh = self.run["mesh"]
        whole = sparse.csc_array(sparse.kron(sum(scalar_forms(mesh["coordinates"].values, mesh["tetrahedra"].values)), np.eye(3)))
        order = np.argsort(self.dofs.ravel())[-len(self.load) :]
        return whole[order][:, order]

    def factor(self, matrix: sparse.csc_array) -> Solve:
        """b -> X^-1 b in the order of the stored factor of A, whose pattern serves other forms, too."""
        stored = self.run["assemble"].children.get("factor")
        return factor(matrix, None if stored is None else stored["permutation"].values)

    @cached_property
    def solve_stiffness(self) -> Solve:
        """b -> A^-1 b."""
        return self.factor(self.stiffness)

    @cached_property
    def selection(self) -> sparse.csr_array:
        """E: u_nu, u_t1, u_t2 of contact node after contact node, [3 n, n_free]."""
        dofs = np.repeat(self.dofs[self.run["mesh/contact_nodes"].values][:, None], 3, axis=1)
        node, axis, component = np.nonzero((dofs >= 0) & (self.frame != 0))
        entries = (self.frame[node, axis, component], (3 * node + axis, dofs[node, axis, component]))
        return sparse.csr_array(entries, shape=(3 * len(self.frame), len(self.load)))

    def gram(self, solve: Solve) -> Array:
        """E X^-1 E': for nodal forces f on the face, f' E X^-1 E' f = sup (f, v)^2 / |v|^2 over V^h. With X = A the compliance."""
        columns = range(0, self.selection.shape[0], BLOCK_COLUMNS)
        blocks = [self.selection @ solve(self.selection[k : k + BLOCK_COLUMNS].T.toarray()) for k in columns]
        gram = np.concatenate(blocks, axis=1)
        return (gram + gram.T) / 2
