"""Meshes of other programs as Gmsh files: formats, sets as faces and regions, hexahedra, errors."""

import itertools
import os
import subprocess
import sys

import meshlane
import numpy as np
import pytest

from conftest import ROOT

import contact3d as package
from contact3d._files import write_whole
from contact3d.convert import ConversionError, Tetrahedra, convert, read

SIZE, CELLS = (3.0, 2.0, 2.0), (6, 4, 4)


@pytest.fixture(scope="module", autouse=True)
def same_program(program):
    before = os.environ.get("CONTACT3D_PIPE")
    os.environ["CONTACT3D_PIPE"] = str(program)
    yield
    os.environ.pop("CONTACT3D_PIPE") if before is None else os.environ.update(CONTACT3D_PIPE=before)


def hexahedra() -> tuple[np.ndarray, np.ndarray]:
    """Nodes and cells of a brick."""
    planes = [np.linspace(0.0, size, count + 1) for size, count in zip(SIZE, CELLS, strict=True)]
    points = np.array([(x, y, z) for z in planes[2] for y in planes[1] for x in planes[0]])
    node = lambda i, j, k: i + (CELLS[0] + 1) * (j + (CELLS[1] + 1) * k)  # noqa: E731
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    cells = [[node(i + a, j + b, k + c) for a, b, c in corners] for k, j, i in itertools.product(*map(range, CELLS[::-1]))]
    return points, np.array(cells)


def on(points: np.ndarray, axis: int, value: float) -> np.ndarray:
    return np.flatnonzero(points[:, axis] == value)


@pytest.fixture(scope="module")
def tetrahedra(tmp_path_factory):
    """The same brick in tetrahedra, with the triangles of its bottom."""
    points, cells = hexahedra()
    file = tmp_path_factory.mktemp("brick") / "brick.vtu"
    meshlane.Mesh(points, [("hexahedron", cells)]).write(file)
    body = read(file, None, cut=True)
    sides = np.sort(body.cells[:, [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]].reshape(-1, 3), axis=1)
    bottom = [side for side in sides if np.all(body.points[side][:, 2] == 0.0)]
    return body.points, body.cells, np.array(bottom)


def test_hexahedra_are_refused_or_cut(tmp_path):
    points, cells = hexahedra()
    meshlane.Mesh(points, [("hexahedron", cells)], point_sets={"left": on(points, 0, 0.0)}).write(tmp_path / "part.inp")
    with pytest.raises(ConversionError, match="96 cells are hexahedron.*mesh the part with tetrahedra"):
        convert(tmp_path / "part.inp", tmp_path / "part.msh")
    assert not (tmp_path / "part.msh").exists()
    body = convert(tmp_path / "part.inp", tmp_path / "part.msh", cut=True)
    edges = body.points[body.cells[:, 1:]] - body.points[body.cells[:, :1]]
    volumes = np.linalg.det(edges) / 6.0
    assert len(volumes) == 6 * 96 and volumes.min() > 0.0
    assert volumes.sum() == pytest.approx(12.0, rel=1e-13)  # A sum of 576 roundings.
    # Neighbours fit: a side is that of two tetrahedra or lies on the outside, two to each of 2 (24 + 24 + 16) squares.
    sides = np.sort(body.cells[:, [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]].reshape(-1, 3), axis=1)
    _, counts = np.unique(sides, axis=0, return_counts=True)
    assert set(counts) == {1, 2} and (counts == 1).sum() == 2 * 128
    assert len(body.faces) == 32


@pytest.mark.parametrize("kind", ["wedge", "pyramid"])
def test_other_cells_are_cut_too(tmp_path, kind):
    points = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1.0), (1, 0, 1), (1, 1, 1)], dtype=float)
    cells = {"pyramid": [[0, 1, 2, 3, 4]], "wedge": [[0, 1, 5, 3, 2, 6]]}[kind]
    meshlane.Mesh(points, [(kind, np.array(cells))]).write(tmp_path / "part.vtu")
    body = read(tmp_path / "part.vtu", None, cut=True)
    edges = body.points[body.cells[:, 1:]] - body.points[body.cells[:, :1]]
    volumes = np.linalg.det(edges) / 6.0
    assert volumes.min() > 0.0 and volumes.sum() == pytest.approx({"pyramid": 1 / 3, "wedge": 1 / 2}[kind])


def written(tetrahedra, file):
    """The brick in a format, with what that has for sets."""
    points, cells, bottom = tetrahedra
    soft = points[cells].mean(axis=1)[:, 0] < 1.5
    blocks = [("tetra", cells), ("triangle", bottom)]
    if file.suffix == ".inp":
        of_cells = {"soft": [np.flatnonzero(soft), []], "bottom": [[], np.arange(len(bottom))]}
        of_nodes = {"left": on(points, 0, 0.0), "right": on(points, 0, 3.0), "all": np.arange(len(points))}
        meshlane.Mesh(points, blocks, cell_sets=of_cells, point_sets=of_nodes).write(file)
    elif file.suffix == ".med":
        families = np.where(points[:, 0] == 0.0, 2, np.where(points[:, 0] == 3.0, 3, 0))
        data = {"cell_tags": [np.where(soft, -6, 0), np.full(len(bottom), -7)]}
        mesh = meshlane.Mesh(points, blocks, cell_data=data, point_data={"point_tags": families})
        mesh.cell_tags, mesh.point_tags = {-6: ["soft"], -7: ["bottom"]}, {2: ["left"], 3: ["right"]}
        mesh.write(file)
    else:
        name = {".bdf": "nastran:ref"}.get(file.suffix, "CellEntityIds")
        meshlane.Mesh(points, blocks, cell_data={name: [np.where(soft, 1, 2), np.full(len(bottom), 7)]}).write(file)


@pytest.mark.parametrize("suffix", ["inp", "med", "bdf", "vtu"])
def test_sets_become_faces_and_regions(tetrahedra, tmp_path, suffix):
    written(tetrahedra, tmp_path / f"part.{suffix}")
    body = convert(tmp_path / f"part.{suffix}", tmp_path / "part.msh")
    faces = {name: list(body.faces.values()).count(name) for name in set(body.faces.values())}
    regions = {name: body.regions.count(name) for name in set(body.regions)}
    if suffix in ("inp", "med"):
        assert faces == {"bottom": 48, "left": 32, "right": 32} and regions == {"soft": 288, None: 288}
        assert ("ignored 'all': it holds everything" in body.ignored) == (suffix == "inp")
    else:
        assert faces == {"7": 48} and regions == {"1": 288, "2": 288}
        # meshlane reads what was written, which it does where all cells have names.
        again = meshlane.read(tmp_path / "part.msh")
        assert sum(len(block.data) for block in again.cells if block.type == "tetra") == 576


def scene(mesh, element="P1"):
    return {
        "title": "a brick from elsewhere",
        "body": {"element": element, "gmsh": {"file": mesh}},
        "material": {"isotropic": {"young_modulus": 2e11, "poisson_ratio": 0.3}},
        "clamp": [{"face": "left"}],
        "contact": {"face": "bottom"},
        "friction": {"coefficient": {"constant": 0.3}},
        "pressure": [{"name": "weight", "face": "top", "value": 1e7}],
    }


def with_surface(text: str, points: np.ndarray, cells: np.ndarray) -> str:
    """An input file with the sides of tetrahedra at the top as *SURFACE, their numbers as Abaqus numbers them."""
    lines = ["*SURFACE, NAME=top, TYPE=ELEMENT"]
    for n, cell in enumerate(cells, start=1):
        for side, corners in enumerate([(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)], start=1):
            if np.all(points[cell[list(corners)]][:, 2] == 2.0):
                lines.append(f"{n}, S{side}")
    return text.rstrip() + "\n" + "\n".join(lines) + "\n"


def test_the_program_solves_what_was_converted(tetrahedra, tmp_path):
    points, cells, _ = tetrahedra
    written(tetrahedra, tmp_path / "part.inp")
    text = with_surface((tmp_path / "part.inp").read_text(), points, cells)
    (tmp_path / "part.inp").write_text(text)
    convert(tmp_path / "part.inp", tmp_path / "part.msh")
    run = package.run(scene(tmp_path / "part.msh"), tmp_path / "run.h5")
    # 1e7 Pa on six square metres.
    assert run.forces["force"].sel(source="weight").values == pytest.approx([0.0, 0.0, -6e7], abs=1.0)
    assert run["mesh/pane_area"].sum().item() == pytest.approx(6.0)


def test_quadratic_tetrahedra_keep_their_middles(tetrahedra, tmp_path):
    points, cells, _ = tetrahedra
    edges = np.sort(cells[:, [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]], axis=2)
    distinct, place = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    whole = np.vstack([points, points[distinct].mean(axis=1)])
    ten = np.hstack([cells, len(points) + place.reshape(-1, 6)])
    faces = {"left": on(whole, 0, 0.0), "bottom": on(whole, 2, 0.0), "top": on(whole, 2, 2.0)}
    meshlane.Mesh(whole, [("tetra10", ten)], point_sets=faces).write(tmp_path / "part.inp")
    convert(tmp_path / "part.inp", tmp_path / "part.msh")
    run = package.run(scene(tmp_path / "part.msh", "P2"), tmp_path / "run.h5")
    edges = run["mesh/tetrahedra"].values[:, [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]]
    nodes = run["mesh/coordinates"].values
    np.testing.assert_allclose(nodes[run["mesh/tetrahedron_mid_edges"].values], nodes[edges].mean(axis=2), rtol=1e-14)


def test_sets_that_overlap_are_chosen_from(tetrahedra, tmp_path):
    points, cells, _ = tetrahedra
    sets = {"left": on(points, 0, 0.0), "lower": np.flatnonzero(points[:, 2] <= 1.0)}
    meshlane.Mesh(points, [("tetra", cells)], point_sets=sets).write(tmp_path / "part.inp")
    with pytest.raises(ConversionError, match="'left' and 'lower' overlap.*--sets"):
        convert(tmp_path / "part.inp", tmp_path / "part.msh")
    assert set(convert(tmp_path / "part.inp", tmp_path / "part.msh", sets=["left"]).faces.values()) == {"left"}
    with pytest.raises(ConversionError, match="no set 'top'; there are left, lower"):
        convert(tmp_path / "part.inp", tmp_path / "part.msh", sets=["top"])


def test_errors_are_lines_and_exit_code_2(tetrahedra, tmp_path):
    points, _, bottom = tetrahedra
    meshlane.Mesh(points, [("triangle", bottom)]).write(tmp_path / "shell.vtu")
    for name in ("broken.inp", "broken.vtu", "broken.med", "broken.bdf", "broken.xyz"):
        (tmp_path / name).write_text("nonsense\n")
    (tmp_path / "mine.msh").write_text("a letter")
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "python")}
    for source, target, words in (
        ("nowhere.inp", "part.msh", "there is no file"),
        ("shell.vtu", "part.msh", "expected tetrahedra, found triangle"),
        ("shell.vtu", "part.txt", "ends in .msh"),
        ("shell.vtu", "mine.msh", "no Gmsh file"),
    ):
        command = [sys.executable, "-m", "contact3d.convert", source, target]
        answer = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert answer.returncode == 2 and answer.stderr.startswith("error: ") and words in answer.stderr, answer.stderr
    for broken in tmp_path.glob("broken.*"):
        with pytest.raises(ConversionError):
            convert(broken, tmp_path / "part.msh")
    assert not (tmp_path / "part.msh").exists() and (tmp_path / "mine.msh").read_text() == "a letter"


def volumes(body: Tetrahedra) -> np.ndarray:
    return np.linalg.det(body.points[body.cells[:, 1:4]] - body.points[body.cells[:, :1]]) / 6.0


#: One tetrahedron of volume 1/6 between the axes, its sides at z = 0 (S1) and at y = 0 (S2).
NODES = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n"
CELL = "*ELEMENT, TYPE=C3D4, ELSET=body\n1, 1, 2, 3, 4\n"
BOTTOM = "*SURFACE, NAME=bottom, TYPE=ELEMENT\n1, S1\n"
PART = f"*PART, NAME=p\n{NODES}{CELL}*ELSET, ELSET=_b, INTERNAL\n1\n*SURFACE, NAME=bottom\n_b, S1\n*END PART\n"


def assembly(*places: str) -> str:
    instances = [f"*INSTANCE, NAME=i{n}, PART=p\n{place}*END INSTANCE\n" for n, place in enumerate(places)]
    return PART + "*ASSEMBLY, NAME=a\n" + "".join(instances)


#: Decks, with the faces, the number of tetrahedra of volume 1/6, and the largest coordinates, all known from how they are made.
DECKS = {
    "surface": (NODES + CELL + BOTTOM, {"bottom": 1}, 1, (1, 1, 1)),
    "lower case": ((NODES + CELL + BOTTOM).lower(), {"bottom": 1}, 1, (1, 1, 1)),
    "comments and blank lines": ("** made\n\n" + NODES.replace("2, 1", "** two\n\n2, 1") + CELL + BOTTOM,
                                 {"bottom": 1}, 1, (1, 1, 1)),
    "keyword on two lines": (NODES + CELL + "*SURFACE, NAME=bottom,\nTYPE=ELEMENT\n1, S1\n", {"bottom": 1}, 1, (1, 1, 1)),
    "element on two lines": (NODES + "*ELEMENT, TYPE=C3D4\n1, 1, 2,\n3, 4\n" + BOTTOM, {"bottom": 1}, 1, (1, 1, 1)),
    "coordinates left out": (NODES.replace("1, 0, 0, 0", "1").replace("2, 1, 0, 0", "2, 1.D0") + CELL + BOTTOM,
                             {"bottom": 1}, 1, (1, 1, 1)),
    "reference node behind": (NODES + CELL + BOTTOM + "*NODE, NSET=ref\n9, 5, 5, 5\n", {"bottom": 1}, 1, (1, 1, 1)),
    "reference node before": (NODES + "*NODE\n9, 5, 5, 5\n" + CELL + BOTTOM, {"bottom": 1}, 1, (1, 1, 1)),
    "hybrid elements": (NODES + CELL.replace("C3D4", "C3D4H") + BOTTOM, {"bottom": 1}, 1, (1, 1, 1)),
    "springs beside": (NODES + CELL + "*ELEMENT, TYPE=SPRINGA, ELSET=s\n7, i.1, i.2\n*SPRING, ELSET=s\n" + BOTTOM, {"bottom": 1}, 1, (1, 1, 1)),
    "all sides of a set": (NODES + CELL + "*SURFACE, NAME=skin\nbody,\n", {"skin": 4}, 1, (1, 1, 1)),
    "internal sets": (NODES + CELL + "*ELSET, ELSET=_b_S1, INTERNAL\n1\n*SURFACE, NAME=b\n_b_S1, S1\n", {"b": 1}, 1, (1, 1, 1)),
    "generated set": (NODES + CELL + "*ELSET, ELSET=e, GENERATE\n1, 1, 1\n*SURFACE, NAME=b\ne, S2\n", {"b": 1}, 1, (1, 1, 1)),
    "set of sets": (NODES + CELL + "*NSET, NSET=a\n1, 2\n*NSET, NSET=b\nA, 3\n", {"b": 1}, 1, (1, 1, 1)),
    "set in two blocks": (NODES + CELL + "*NSET, NSET=b\n1, 2\n*NSET, NSET=b\n3\n", {"b": 1}, 1, (1, 1, 1)),
    "nodes of elements": (NODES + CELL + "*NSET, NSET=n, ELSET=body\n", {"n": 4}, 1, (1, 1, 1)),
    "surface of nodes": (NODES + CELL + "*NSET, NSET=b\n1, 2, 3\n*SURFACE, NAME=b, TYPE=NODE\nb, 1.0\n", {"b": 1}, 1, (1, 1, 1)),
    "shell": (NODES + CELL + "*ELEMENT, TYPE=S3, ELSET=b\n2, 1, 3, 2\n", {"b": 1}, 1, (1, 1, 1)),
    "shell of CalculiX": (NODES + "5, .5, 0, 0\n6, .5, .5, 0\n7, 0, .5, 0\n" + CELL + "*ELEMENT, TYPE=S6, ELSET=b\n2, 1, 2, 3, 5, 6, 7\n",
                          {"b": 1}, 1, (1, 1, 1)),
    "one part": (PART, {"bottom": 1}, 1, (1, 1, 1)),
    "instance": (assembly("") + "*END ASSEMBLY\n", {"bottom": 1}, 1, (1, 1, 1)),
    "instance moved": (assembly("10, 0, 5\n") + "*END ASSEMBLY\n", {"bottom": 1}, 1, (11, 1, 6)),
    # A quarter turn about the z-axis takes (x, y) to (−y, x).
    "instance turned": (assembly("0, 0, 0\n0, 0, 0, 0, 0, 1, 90\n") + "*END ASSEMBLY\n", {"bottom": 1}, 1, (0, 1, 1)),
    "two instances": (assembly("", "5, 0, 0\n") + "*END ASSEMBLY\n", {"bottom": 2}, 2, (6, 1, 1)),
    "set of an instance": (assembly("", "5, 0, 0\n").replace("*SURFACE, NAME=bottom\n_b, S1\n", "") +
                           "*NSET, NSET=b, INSTANCE=i1\n1, 2, 3\n*SURFACE, NAME=c\ni0._b, S2\n*END ASSEMBLY\n",
                           {"b": 1, "c": 1}, 2, (6, 1, 1)),
    "part not placed": (PART.replace("NAME=p", "NAME=q") + assembly("") + "*END ASSEMBLY\n", {"bottom": 1}, 1, (1, 1, 1)),
    "nodes in the instance": ("*PART, NAME=p\n*END PART\n*ASSEMBLY, NAME=a\n"
                              f"*INSTANCE, NAME=i, PART=p\n0, 0, 2\n{NODES}{CELL}*END INSTANCE\n*NSET, NSET=b, INSTANCE=i\n1, 2, 3\n*END ASSEMBLY\n", {"b": 1}, 1, (1, 1, 3)),
}


@pytest.mark.parametrize("kind", DECKS)
def test_decks_are_read_rightly(tmp_path, kind):
    text, faces, count, largest = DECKS[kind]
    (tmp_path / "part.inp").write_text(text)
    body = read(tmp_path / "part.inp", None, cut=False)
    assert volumes(body) == pytest.approx([1 / 6] * count)
    assert {name: list(body.faces.values()).count(name) for name in body.faces.values()} == faces
    np.testing.assert_allclose(body.points.max(axis=0), largest, atol=1e-15)
    # Each of several bodies can be named: by its instance where no set of elements does.
    if kind == "two instances":
        assert body.regions == ["I0", "I1"]
        assert read(tmp_path / "part.inp", ["bottom"], cut=False).regions == ["I0", "I1"]


def test_decks_in_several_files(tmp_path):
    (tmp_path / "nodes.inp").write_text(NODES)
    (tmp_path / "list.txt").write_text("1, 1, 2, 3, 4\n")
    (tmp_path / "part.inp").write_text("*INCLUDE, INPUT=nodes.inp\n*ELEMENT, TYPE=C3D4, INPUT=list.txt\n" + BOTTOM)
    body = read(tmp_path / "part.inp", None, cut=False)
    assert volumes(body) == pytest.approx([1 / 6]) and list(body.faces.values()) == ["bottom"]


@pytest.mark.parametrize(("text", "words"), [
    (NODES.replace("*NODE", "*NODE, SYSTEM=C") + CELL, "cylindrical"),
    (NODES + "*NGEN\n1, 4, 1\n" + CELL, r"\*NGEN makes nodes"),
    (NODES + CELL.replace("C3D4", "C3D27"), "elements of type C3D27 cannot be read"),
    (NODES + CELL.replace("C3D4", "COH3D8"), "elements of type COH3D8 cannot be read"),
    (NODES + CELL.replace("C3D4", "C3D10"), "has 4 nodes; expected 10"),
    (NODES.replace("4, 0, 0, 1\n", "") + CELL, "use node 4"),
    (NODES + NODES + CELL, "node 1 is defined twice"),
    (NODES + CELL + "*SURFACE, NAME=b\nother, S1\n", "'OTHER' is used and not defined"),
    (NODES + CELL + "*SURFACE, NAME=b\n1, S7\n", "side S7 of a tetra"),
    (NODES + CELL + "*NSET, NSET=n, GENERATE\n1\n", "GENERATE wants lines of first, last, step"),
    (PART + "*ASSEMBLY, NAME=a\n" + CELL, "stand in the assembly"),
    ("*INCLUDE, INPUT=gone.inp\n", "cannot read the included file.*gone.inp"),
    ("*INCLUDE, INPUT=part.inp\n", "does a file include itself"),
    ("*ASSEMBLY, NAME=a\n*INSTANCE, NAME=i, PART=p\n", "'p', which the file does not have"),
])
def test_decks_that_cannot_be_read_are_refused_by_name(tmp_path, text, words):
    (tmp_path / "part.inp").write_text(text)
    with pytest.raises(ConversionError, match=words):
        read(tmp_path / "part.inp", None, cut=False)


def small(name: str, *fields: object) -> str:
    """A card in fields of eight columns, continued by lines that begin with blanks."""
    texts = [f"{field!s:8}" for field in fields]
    lines = [f"{name:8}" + "".join(texts[:8])]
    return "\n".join(lines + [" " * 8 + "".join(texts[n : n + 8]) for n in range(8, len(texts), 8)]) + "\n"


def large(name: str, *fields: object) -> str:
    texts = [f"{field!s:16}" for field in fields]
    starts = [f"{name + '*':8}"] + [f"{'*':8}"] * 9
    return "".join(start + "".join(texts[4 * n : 4 * n + 4]) + "\n" for n, start in enumerate(starts) if texts[4 * n :])


def free(name: str, *fields: object) -> str:
    lines = [",".join(map(str, ["" if n else name, *fields[n : n + 8]])) for n in range(0, len(fields), 8)]
    return "\n".join(lines) + "\n"


CORNERS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]


def bulk(card, *, ten: bool = False, system: object = "", places=CORNERS, begin: str = "BEGIN BULK\n") -> str:
    places = [*places, *(tuple((np.array(places[a]) + places[b]) / 2) for a, b in EDGES)] if ten else places
    points = [card("GRID", n, system, *map(float, place)) for n, place in enumerate(places, start=1)]
    return begin + "".join(points) + card("CTETRA", 1, 3, *range(1, len(places) + 1)) + "ENDDATA\n"


@pytest.mark.parametrize("ten", [False, True])
@pytest.mark.parametrize("card", [small, large, free])
@pytest.mark.parametrize("variant", [
    str, str.lower, lambda text: text.replace("BEGIN BULK\n", ""), lambda text: text.replace("ENDDATA\n", ""),
    lambda text: text.replace("0.5", "5.-1").replace("1.0", ".1+1")])
def test_nastran_fields_are_read_rightly(tmp_path, card, ten, variant):
    (tmp_path / "part.bdf").write_text(variant(bulk(card, ten=ten)))
    body = read(tmp_path / "part.bdf", None, cut=False)
    assert volumes(body) == pytest.approx([1 / 6]) and body.regions == ["3"]
    if ten:
        middles = body.points[body.cells[0, 4:]]
        np.testing.assert_allclose(middles, [body.points[body.cells[0, list(edge)]].mean(axis=0) for edge in EDGES], atol=1e-15)


#: The four corners in systems whose origin is (2, 0, 0) and whose z-axis is the x-axis of the basic one; x is the y-axis.
TURNED = "2.0 0.0 0.0 3.0 0.0 0.0 2.0 1.0 0.0".split()
SYSTEMS = {
    "CORD2R": CORNERS,
    "CORD2C": [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 90.0, 0.0), (0.0, 0.0, 1.0)],
    "CORD2S": [(0.0, 0.0, 0.0), (1.0, 90.0, 0.0), (1.0, 90.0, 90.0), (1.0, 0.0, 0.0)],
}


@pytest.mark.parametrize("card", [small, large, free])
@pytest.mark.parametrize("name", SYSTEMS)
def test_nastran_systems_are_read_rightly(tmp_path, name, card):
    own = card(name, 5, 0, *TURNED)
    # A second one about the origin of the first, with the same axes, and one by grid points.
    nested = card(name, 6, 5, 0.0, 0.0, 0.0, *SYSTEMS[name][3], *SYSTEMS[name][1])
    by_points = "".join(card("GRID", n, 0, *map(float, TURNED[3 * k : 3 * k + 3])) for k, n in enumerate((91, 92, 93)))
    by_points += card(name.replace("2", "1"), 7, 91, 92, 93)
    for system, cards in ((5, own), (6, own + nested), (7, by_points), ("", own + card("GRDSET", "", 5))):
        text = bulk(card, system=system, places=SYSTEMS[name])
        (tmp_path / "part.bdf").write_text(text.replace("BEGIN BULK\n", "BEGIN BULK\n" + cards))
        body = read(tmp_path / "part.bdf", None, cut=False)
        # x, y, z of the system are y, z, x of the basic one.
        np.testing.assert_allclose(body.points, [(2, 0, 0), (2, 1, 0), (2, 0, 1), (3, 0, 0)], atol=1e-15)


@pytest.mark.parametrize(("text", "words"), [
    (bulk(small, system=9), "coordinate system 9, which the file does not define"),
    (bulk(small, system=9).replace("ENDDATA", small("CORD2C", 9, 9, *TURNED) + "ENDDATA"), "defined by itself"),
    (bulk(small).replace("CTETRA", "CTETX "), "card CTETX is not read"),
    (bulk(small).replace("ENDDATA", small("CTETRA", 2, 3, 1, 2, 3, 4, 1) + "ENDDATA"), "has 5 nodes, expected 4 or 10"),
    (bulk(small).replace("ENDDATA", small("CTETRA", 2, 3, 1, 2, 3, 8) + "ENDDATA"), "grid point 8, which is not defined"),
    ("BEGIN BULK\nINCLUDE 'gone.bdf'\n", "included file gone.bdf"),
])
def test_nastran_that_cannot_be_read_is_refused_by_name(tmp_path, text, words):
    (tmp_path / "part.bdf").write_text(text)
    with pytest.raises(ConversionError, match=words):
        read(tmp_path / "part.bdf", None, cut=False)


@pytest.mark.parametrize("settings", [{"binary": False}, {"compression": None}, {"compression": "zlib"}, {"compression": "lzma"}])
def test_arrays_of_cells_are_chosen(tetrahedra, tmp_path, settings):
    points, cells, _ = tetrahedra
    soft = points[cells].mean(axis=1)[:, 0] < 1.5
    data = {"material": [np.where(soft, 1, 2)], "ElementId": [np.arange(len(cells))], "zone": [np.where(soft, 2, 1)]}
    meshlane.vtu.write(tmp_path / "part.vtu", meshlane.Mesh(points, [("tetra", cells)], cell_data=data), **settings)
    with pytest.raises(ConversionError, match="overlap"):
        read(tmp_path / "part.vtu", None, cut=False)
    for chosen in (["material"], ["material=1", "material=2"]):
        body = read(tmp_path / "part.vtu", chosen, cut=False)
        assert [name == "material=1" for name in body.regions] == soft.tolist()
    assert read(tmp_path / "part.vtu", ["zone"], cut=False).regions.count("zone=2") == soft.sum()


def test_a_boundary_without_names_is_split(tmp_path):
    # A quarter of a ring of radii 1 and 1.5 and height 0.5 in cells of 15°: two cylinders and four planes.
    turn, across, up = np.meshgrid(np.radians(np.arange(7) * 15.0), [1.0, 1.5], [0.0, 0.5], indexing="ij")
    points = np.column_stack([(across * np.cos(turn)).ravel(), (across * np.sin(turn)).ravel(), up.ravel()])
    node = lambda i, j, k: 4 * i + 2 * j + k  # noqa: E731
    corners = [(0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0), (0, 0, 1), (0, 1, 1), (1, 1, 1), (1, 0, 1)]
    cells = np.array([[node(i + a, b, c) for a, b, c in corners] for i in range(6)])
    meshlane.Mesh(points, [("hexahedron", cells)]).write(tmp_path / "ring.vtk")
    body = convert(tmp_path / "ring.vtk", tmp_path / "ring.msh", cut=True)
    kinds = [body.shapes[f"face_{n}"].split(", x, y, z")[0] for n in range(1, 7)]
    # Six triangles of the area r² sin 15° / 2 for each radius.
    assert volumes(body).sum() == pytest.approx(6 * np.sin(np.radians(15)) / 2 * 1.25 * 0.5)
    assert kinds[0] == "cylinder, radius 1.5, axis 0, 0, 1 through 0, 0, 0.25"
    assert kinds[3] == "cylinder, radius 1, axis 0, 0, 1 through 0, 0, 0.25"
    planes = {f"plane, outward normal {normal}" for normal in ("0, 0, -1", "0, 0, 1", "0, -1, 0", "-1, 0, 0")}
    assert {kinds[n] for n in (1, 2, 4, 5)} == planes
    # Chords meet at 15°: with 10° each is a face of its own.
    assert len(convert(tmp_path / "ring.vtk", tmp_path / "ring.msh", cut=True, angle=10.0).shapes) == 4 + 12


def test_other_formats_as_the_mesh_of_a_scene_point_to_the_converter(tmp_path, program):
    (tmp_path / "part.inp").write_text(NODES + CELL)
    answer = subprocess.run([program, "inspect", "part.inp"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert answer.returncode == 2 and "python -m contact3d.convert part.inp part.msh" in " ".join(answer.stderr.split())


def test_a_mesh_that_cannot_be_written_leaves_the_former_one(tmp_path, monkeypatch):
    target = tmp_path / "part.msh"
    target.write_text("$MeshFormat of before", encoding="utf-8")

    def full(_):
        raise OSError("no space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="no space"):
        write_whole(target, "$MeshFormat of now")
    assert target.read_text(encoding="utf-8") == "$MeshFormat of before"
    assert os.listdir(tmp_path) == ["part.msh"]
    monkeypatch.undo()
    write_whole(target, "$MeshFormat of now")
    assert target.read_text(encoding="utf-8") == "$MeshFormat of now"
