"""Meshes of other programs as Gmsh files: ``python -m contact3d.convert part.inp part.msh``.

Reads Abaqus and CalculiX (.inp), MED (.med), Nastran (.bdf, .nas), VTK (.vtu, .vtk) and what else meshlane reads. Sets
become names: those of surface elements, element faces and nodes of faces, those of volume elements of regions. A boundary
without names is split at its edges.
"""

import argparse
import importlib
import io
import itertools
import sys
from collections import Counter
from collections.abc import Collection, Hashable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from . import _nastran, _shapes
from ._abaqus import INSTANCE, Deck, DeckError, surfaces
from ._files import write_whole
from ._nastran import BulkError

TETRAHEDRA = {"tetra": 4, "tetra10": 10}
#: Faces of the cells that can be cut, by their corners.
CUT = {
    "hexahedron": ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    "wedge": ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "pyramid": ((0, 1, 2, 3), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
}
CORNERS = {"hexahedron": 8, "wedge": 6, "pyramid": 5}
QUADRATIC = {"hexahedron20": "hexahedron", "hexahedron24": "hexahedron", "hexahedron27": "hexahedron", "wedge15": "wedge",
             "wedge18": "wedge", "pyramid13": "pyramid", "pyramid14": "pyramid"}
SURFACES = {"triangle": 3, "triangle6": 3, "triangle7": 3, "quad": 4, "quad8": 4, "quad9": 4}
#: Sides of a tetrahedron, and the middles of their edges in the order of VTK.
SIDES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
MIDDLES = {(0, 1): 4, (1, 2): 5, (0, 2): 6, (0, 3): 7, (1, 3): 8, (2, 3): 9}
#: Arrays that number cells and name no sets.
NO_SETS = ("gmsh:geometrical", "gmsh:bounding_entities", "vtkGhostType", "vtkOriginalCellIds", "GlobalCellId")
NASTRAN = (".bdf", ".nas", ".dat", ".fem")


class ConversionError(ValueError):
    """A mesh that cannot be used, and what to do about it."""


@dataclass
class Tetrahedra:
    """The body: nodes, cells of one kind, and the names of faces and regions."""

    points: np.ndarray
    cells: np.ndarray
    regions: list[str | None]
    faces: dict[frozenset[int], str] = field(default_factory=dict)
    ignored: list[str] = field(default_factory=list)
    #: What the faces are that were split off.
    shapes: dict[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        corners = "four" if self.cells.shape[1] == 4 else "ten"
        lines = [f"{len(self.points)} nodes, {len(self.cells)} tetrahedra of {corners} nodes"]
        for name, count in sorted(Counter(self.faces.values()).items(), key=lambda item: (len(item[0]), item[0])):
            lines.append(f"face {name!r}: {count} triangles" + (f", {self.shapes[name]}" if name in self.shapes else ""))
        named = Counter(name for name in self.regions if name is not None)
        lines += [f"region {name!r}: {count} tetrahedra" for name, count in sorted(named.items())]
        return "\n".join(lines + self.ignored)


def convert(source: str | Path, target: str | Path, *, sets: Collection[str] | None = None, cut: bool = False,
            angle: float | None = None) -> Tetrahedra:
    """Reads a mesh, and writes its tetrahedra with their names as a Gmsh file, MSH 4.1.

    :param sets: the sets that become names, or arrays of cells of which all values do; all by default, but those that hold
        everything.
    :param cut: cut hexahedra, prisms and pyramids into tetrahedra at their corners.
    :param angle: what is in no set is split into the faces ``face_1``, ``face_2`` and so on, the largest first, where triangles
        meet at more than this angle in degrees; by default at 30 degrees if the file names no face.
    :raises ConversionError: a file without tetrahedra, or with other cells unless they are to be cut; sets that overlap.
    """
    source, target = Path(source), Path(target)
    if target.suffix != ".msh":
        raise ConversionError(f"{target}: expected a name that ends in .msh")
    if target.is_file() and not target.read_bytes().startswith(b"$MeshFormat"):
        raise ConversionError(f"{target} is there and no Gmsh file; choose another name or move it away")
    body = read(source, sets, cut)
    if angle is not None or not body.faces:
        _split(body, 30.0 if angle is None else angle)
    write_whole(target, msh(body))
    return body


def read(source: Path, chosen: Collection[str] | None, cut: bool) -> Tetrahedra:
    """The tetrahedra of a file and the names of its sets."""
    mesh, ignored = _load(source)
    cells, parents = _tetrahedra(mesh, source, cut)
    used = np.unique(cells)
    number = np.full(len(mesh.points), -1)
    number[used] = np.arange(len(used))
    children: dict[tuple[int, int], list[int]] = {}
    for child, parent in enumerate(parents):
        children.setdefault(parent, []).append(child)
    boundary = _boundary(cells)
    inside: dict[str, set[int]] = {}
    outside: dict[str, set[frozenset[int]]] = {}
    for name, volumes, sides, nodes in _sets(mesh, source):
        held = set(nodes)
        triangles = [triangle for side in sides for triangle in _triangles(side)]
        triangles += [triangle for triangle in boundary if held and triangle <= held]
        inside.setdefault(name, set()).update(child for cell in volumes for child in children.get(cell, []))
        outside.setdefault(name, set()).update(triangle for triangle in triangles if triangle in boundary)
    if chosen is not None:
        # The name of an array stands for those of all its values.
        values = [[name for name in inside if part in (name, name.partition("=")[0])] or [part] for part in chosen]
        chosen = list(itertools.chain(*values))
    instances, left_out = _name_instances(inside, outside, len(cells), chosen)
    ignored += left_out
    chosen = None if chosen is None else [*chosen, *instances]
    if missing := sorted(set(chosen or ()) - set(inside)):
        raise ConversionError(f"{source}: there is no set {missing[0]!r}; there are {', '.join(sorted(inside)) or 'none'}")
    ignored += [f"ignored {name!r}: it holds no tetrahedron and no triangle of the boundary"
               for name in inside if chosen is None and not inside[name] and not outside[name]]
    regions, whole = _exclusive(source, inside, len(cells), chosen)
    faces, all_around = _exclusive(source, outside, len(boundary), chosen)
    ignored += [f"ignored {name!r}: it holds everything" for name in whole + all_around]
    return Tetrahedra(
        np.asarray(mesh.points, dtype=float)[used],
        number[cells],
        [regions.get(child) for child in range(len(cells))],
        {frozenset(int(number[n]) for n in triangle): name for triangle, name in faces.items()},
        ignored,
    )


def _name_instances(inside: dict[str, set[int]], outside: dict[str, Any], size: int, chosen: Collection[str] | None
                    ) -> tuple[list[str], list[str]]:
    """Gives the cells of each instance its name, where no chosen set of cells tells parts of the body from others; the names, and what was
    left out."""
    instances = {key: inside.pop(key) for key in list(inside) if key.startswith(INSTANCE)}
    names = [key.removeprefix(INSTANCE) for key in instances]
    for key in instances:
        outside.pop(key, None)
    regions = [cells for name, cells in inside.items() if chosen is None or name in chosen]
    if any(0 < len(cells) < size for cells in regions) or set(names) & set(inside):
        return [], [f"ignored the instance {name!r}: sets of elements are the regions" for name in names]
    inside.update(zip(names, instances.values(), strict=True))
    outside.update((name, set()) for name in names)
    return names, []


Member = TypeVar("Member", bound=Hashable)


def _exclusive(source: Path, sets: dict[str, set[Member]], size: int, chosen: Collection[str] | None
               ) -> tuple[dict[Member, str], list[str]]:
    """The one set of each member, and the sets that are left out since they hold everything and are not the only one."""
    wanted = {name: members for name, members in sets.items() if members and (chosen is None or name in chosen)}
    whole = [name for name, members in wanted.items() if len(members) == size and len(wanted) > 1 and chosen is None]
    owner: dict[Member, str] = {}
    for name in sorted(set(wanted) - set(whole)):
        for member in wanted[name]:
            if member in owner:
                pair = f"{owner[member]!r} and {name!r}"
                raise ConversionError(
                    f"{source}: the sets {pair} overlap, and a part has one name; choose with --sets NAME … (sets=)"
                )
            owner[member] = name
    return owner, whole


def _load(source: Path) -> tuple[Any, list[str]]:
    """The mesh, and what was left out of it."""
    try:
        meshlane = importlib.import_module("meshlane")
    except ImportError:
        raise ConversionError("reading meshes needs meshlane: pip install meshlane") from None
    if not source.is_file():
        raise ConversionError(f"there is no file {source}")
    try:
        if source.suffix.lower() in NASTRAN:
            return _nastran.read(source, meshlane), []
        if source.suffix.lower() == ".inp":
            deck = Deck(source)
            return meshlane.read(io.StringIO("\n".join(deck.lines) + "\n"), "abaqus"), deck.ignored
        return meshlane.read(source), []
    except (Exception, SystemExit) as error:
        # meshlane ends the process where it knows no format, and its readers raise anything.
        reason = str(error) if not isinstance(error, SystemExit) and str(error) else "meshlane cannot read it"
        kind = "" if isinstance(error, (DeckError, BulkError)) else f"{type(error).__name__}: "
        raise ConversionError(f"{source}: {kind}{reason}") from error


def _split(body: Tetrahedra, angle: float) -> None:
    """Names the parts of the boundary that have no name."""
    sides = body.cells[:, SIDES].reshape(-1, 3)
    boundary = _boundary(body.cells)
    free = np.array([side for side in sides if (key := frozenset(map(int, side))) in boundary and key not in body.faces])
    if not len(free):
        return
    taken = set(body.faces.values())
    numbers = (f"face_{n}" for n in itertools.count(1) if f"face_{n}" not in taken)
    for members, name in zip(_shapes.split(body.points, free, angle), numbers, strict=False):
        body.faces.update(dict.fromkeys((frozenset(map(int, side)) for side in free[members]), name))
        body.shapes[name] = _shapes.describe(body.points, free[members])


def _tetrahedra(mesh: Any, source: Path, cut: bool) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """The cells, and the block and number of the cell that each comes from."""
    found: list[np.ndarray] = []
    parents: list[tuple[int, int]] = []
    kinds: set[str] = set()
    for k, block in enumerate(mesh.cells):
        kind = QUADRATIC.get(block.type, block.type)
        if block.type in TETRAHEDRA:
            kinds.add(block.type)
            found.append(block.data)
            parents += [(k, n) for n in range(len(block.data))]
        elif kind in CUT:
            if not cut:
                raise ConversionError(
                    f"{source}: {len(block.data)} cells are {block.type}, and this program takes tetrahedra; "
                    "mesh the part with tetrahedra, which is better, or cut them with --cut (cut=True)"
                )
            kinds.add("tetra")
            for n, cell in enumerate(block.data):
                pieces = _cut(cell[: CORNERS[kind]], CUT[kind])
                found.append(pieces)
                parents += [(k, n)] * len(pieces)
    if not found:
        present = ", ".join(sorted({block.type for block in mesh.cells})) or "no cells"
        raise ConversionError(f"{source}: expected tetrahedra, found {present}; mesh the volume")
    if len(kinds) > 1:
        mixed = "found tetrahedra of four and of ten nodes; mesh all in one order"
        raise ConversionError(f"{source}: expected cells of one order, {mixed}")
    cells = np.vstack(found).astype(int)
    corners = np.asarray(mesh.points, dtype=float)[cells[:, :4]]
    edges = corners[:, 1:] - corners[:, :1]
    inverted = np.linalg.det(edges) < 0.0
    if cells.shape[1] == 4:
        cells[inverted] = cells[inverted][:, [0, 2, 1, 3]]
    else:
        cells[inverted] = cells[inverted][:, [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]]
    return cells, parents


def _cut(cell: np.ndarray, faces: Iterable[tuple[int, ...]]) -> np.ndarray:
    """A cone from the smallest corner over the triangles of the faces that do not hold it.

    Each quadrilateral is cut from its own smallest corner, so that neighbours cut it alike.
    """
    apex = min(cell)
    opposite = [[cell[n] for n in face] for face in faces if apex not in cell[list(face)]]
    return np.array([[apex, *triangle] for face in opposite for triangle in _ordered_triangles(face)])


def _ordered_triangles(face: list[int]) -> list[list[int]]:
    if len(face) == 3:
        return [face]
    start = face.index(min(face))
    a, b, c, d = face[start:] + face[:start]
    return [[a, b, c], [a, c, d]]


def _triangles(side: Iterable[int]) -> list[frozenset[int]]:
    return [frozenset(triangle) for triangle in _ordered_triangles([int(n) for n in side])]


def _boundary(cells: np.ndarray) -> set[frozenset[int]]:
    """The triangles that only one tetrahedron has."""
    sides = np.sort(np.vstack([cells[:, side] for side in SIDES]), axis=1)
    distinct, counts = np.unique(sides, axis=0, return_counts=True)
    return {frozenset(map(int, side)) for side in distinct[counts == 1]}


#: A set: its name, volume cells by block and number, sides by their corners, nodes.
NamedSet = tuple[str, list[tuple[int, int]], list[np.ndarray], list[int]]


def _sets(mesh: Any, source: Path) -> Iterator[NamedSet]:
    """The sets of a mesh, however its format tells them."""
    if source.suffix.lower() == ".inp":
        try:
            for name, sides in surfaces(mesh):
                yield name, [], sides, []
        except DeckError as error:
            raise ConversionError(f"{source}: {error}") from error
    for name, members in mesh.cell_sets.items():
        if name in NO_SETS:
            continue
        yield _of_cells(mesh, name, [[] if block is None else block for block in members])
    for name, nodes in mesh.point_sets.items():
        yield name, [], [], [int(n) for n in nodes]
    for names, data, of_nodes, prefix in _tags(mesh):
        for tag in sorted({int(tag) for block in data for tag in np.unique(block)}):
            for name in names.get(tag, []) if names else [f"{prefix}{tag}"]:
                members = [np.flatnonzero(np.asarray(block) == tag) for block in data]
                yield (name, [], [], [int(n) for n in members[0]]) if of_nodes else _of_cells(mesh, name, members)


#: Names of numbers, the numbers, whether they are those of nodes, and what stands before a number that has no name.
Tags = tuple[dict[int, list[str]], list[np.ndarray], bool, str]


def _tags(mesh: Any) -> Iterator[Tags]:
    """Numbers of cells and nodes that stand for sets: families of MED with names, others with their number as the name.

    Where several arrays have numbers, the name of the array stands before: ``material=1``.
    """
    families = {"cell_tags": getattr(mesh, "cell_tags", {}), "point_tags": getattr(mesh, "point_tags", {})}
    # Scalars of VTK are columns.
    arrays = {name: [np.ravel(block) for block in data] for name, data in mesh.cell_data.items() if name not in NO_SETS
              and all(np.asarray(block).dtype.kind in "iu" and np.size(block) == len(block) for block in data)}
    for name, data in arrays.items():
        if name == "gmsh:physical":
            yield from _physical(mesh, data)
        else:
            yield families.get(name) or {}, data, False, f"{name}=" if len(arrays) > 1 else ""
    if "point_tags" in mesh.point_data:
        yield families["point_tags"], [mesh.point_data["point_tags"]], True, ""


def _physical(mesh: Any, data: list[np.ndarray]) -> Iterator[Tags]:
    """Physical surfaces, then volumes: their numbers are apart, and those without a name have their number as the name."""
    for dimension in (2, 3):
        own = [(block.type in SURFACES) == (dimension == 2) for block in mesh.cells]
        tags = [np.where(is_own, block, -1) for is_own, block in zip(own, data, strict=True)]
        names = {int(tag): [str(tag)] for block in tags for tag in np.unique(block) if tag > 0}
        names.update({int(tag): [key] for key, (tag, of) in mesh.field_data.items() if of == dimension})
        if names:
            yield names, tags, False, ""


def _of_cells(mesh: Any, name: str, members: list[Any]) -> NamedSet:
    volumes, sides = [], []
    for k, (block, numbers) in enumerate(zip(mesh.cells, members, strict=False)):
        numbers = np.asarray(numbers, dtype=int)
        if block.type in SURFACES:
            sides += list(block.data[numbers][:, : SURFACES[block.type]])
        else:
            volumes += [(k, int(n)) for n in numbers]
    return name, volumes, sides, []


def msh(body: Tetrahedra) -> str:
    """The body as MSH 4.1: an entity for each name."""
    quadratic = body.cells.shape[1] == 10
    sides: dict[str | None, list[Any]] = {}
    for side in _oriented(body):
        sides.setdefault(body.faces[frozenset(side[:3])], []).append(side)
    volumes: dict[str | None, list[Any]] = {}
    for cell, name in zip(body.cells, body.regions, strict=True):
        volumes.setdefault(name, []).append(cell[[0, 1, 2, 3, 4, 5, 6, 7, 9, 8]] if quadratic else cell)
    groups = [(2, 9 if quadratic else 2, sides), (3, 11 if quadratic else 4, volumes)]
    box = " ".join(map(repr, [*body.points.min(axis=0).tolist(), *body.points.max(axis=0).tolist()]))
    names, entities, elements = [], [], []
    number = itertools.count(1)
    for dimension, kind, group in groups:
        for tag, (name, members) in enumerate(group.items(), start=1):
            if name is not None:
                names.append(f'{dimension} {tag} "{name.replace(chr(34), chr(39))}"')
            entities.append(f"{tag} {box} {'0' if name is None else f'1 {tag}'} 0")
            elements.append(f"{dimension} {tag} {kind} {len(members)}")
            elements += [" ".join(map(str, [next(number), *(int(n) + 1 for n in member)])) for member in members]
    count, total = len(body.points), next(number) - 1
    lines = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names)), *names, "$EndPhysicalNames"]
    lines += ["$Entities", f"0 0 {len(sides)} {len(volumes)}", *entities, "$EndEntities"]
    lines += ["$Nodes", f"1 {count} 1 {count}", f"3 1 0 {count}", *map(str, range(1, count + 1))]
    lines += [*(" ".join(map(repr, point)) for point in body.points.tolist()), "$EndNodes"]
    lines += ["$Elements", f"{len(sides) + len(volumes)} {total} 1 {total}", *elements, "$EndElements", ""]
    return "\n".join(lines)


def _oriented(body: Tetrahedra) -> Iterator[list[int]]:
    """The sides of all tetrahedra that have names, seen from outside, with the middles of their edges where there are any."""
    for cell in body.cells:
        for side in SIDES:
            nodes = [int(cell[n]) for n in side]
            if frozenset(nodes) in body.faces:
                if len(cell) == 10:
                    edges = zip(side, side[1:] + side[:1], strict=True)
                    nodes += [int(cell[MIDDLES[min(edge), max(edge)]]) for edge in edges]
                yield nodes


def main(arguments: list[str] | None = None) -> int:
    """The command line; exit code 2 for a mesh that cannot be used."""
    parser = argparse.ArgumentParser(prog="python -m contact3d.convert", description=__doc__.splitlines()[0])
    parser.add_argument("source", type=Path, help="a mesh of Abaqus, MED, Nastran, VTK or another format of meshlane")
    parser.add_argument("target", type=Path, help="the Gmsh file, NAME.msh")
    parser.add_argument("--cut", action="store_true", help="cut hexahedra, prisms and pyramids into tetrahedra")
    parser.add_argument("--sets", nargs="+", metavar="NAME", help="the sets or arrays of cells that become names; all by default")
    parser.add_argument("--angle", type=float, help="split what has no name into faces at edges above this angle in degrees; "
                        "by default 30 if there are no faces")
    given = parser.parse_args(arguments)
    try:
        print(convert(given.source, given.target, sets=given.sets, cut=given.cut, angle=given.angle))
        scene = given.target.with_suffix(".toml")
        print(f"materials, supports and loads belong into a scene: contact3d-pipe inspect {given.target} --scene {scene}")
    except (ConversionError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
