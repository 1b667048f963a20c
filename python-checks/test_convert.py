"""Meshes of other programs as Gmsh files: formats, sets as faces and regions, hexahedra, errors."""

import itertools
import os
import subprocess
import sys

import meshio
import numpy as np
import pytest

from conftest import ROOT

import contact3d as package
from contact3d.convert import ConversionError, convert, read

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
    meshio.Mesh(points, [("hexahedron", cells)]).write(file)
    body = read(file, None, cut=True)
    sides = np.sort(body.cells[:, [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]].reshape(-1, 3), axis=1)
    bottom = [side for side in sides if np.all(body.points[side][:, 2] == 0.0)]
    return body.points, body.cells, np.array(bottom)


def test_hexahedra_are_refused_or_cut(tmp_path):
    points, cells = hexahedra()
    meshio.Mesh(points, [("hexahedron", cells)], point_sets={"left": on(points, 0, 0.0)}).write(tmp_path / "part.inp")
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
    meshio.Mesh(points, [(kind, np.array(cells))]).write(tmp_path / "part.vtu")
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
        meshio.Mesh(points, blocks, cell_sets=of_cells, point_sets=of_nodes).write(file)
    elif file.suffix == ".med":
        families = np.where(points[:, 0] == 0.0, 2, np.where(points[:, 0] == 3.0, 3, 0))
        data = {"cell_tags": [np.where(soft, -6, 0), np.full(len(bottom), -7)]}
        mesh = meshio.Mesh(points, blocks, cell_data=data, point_data={"point_tags": families})
        mesh.cell_tags, mesh.point_tags = {-6: ["soft"], -7: ["bottom"]}, {2: ["left"], 3: ["right"]}
        mesh.write(file)
    else:
        name = {".bdf": "nastran:ref"}.get(file.suffix, "CellEntityIds")
        meshio.Mesh(points, blocks, cell_data={name: [np.where(soft, 1, 2), np.full(len(bottom), 7)]}).write(file)


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
        # meshio reads what was written, which it does where all cells have names.
        again = meshio.read(tmp_path / "part.msh")
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
    meshio.Mesh(whole, [("tetra10", ten)], point_sets=faces).write(tmp_path / "part.inp")
    convert(tmp_path / "part.inp", tmp_path / "part.msh")
    run = package.run(scene(tmp_path / "part.msh", "P2"), tmp_path / "run.h5")
    edges = run["mesh/tetrahedra"].values[:, [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]]
    nodes = run["mesh/coordinates"].values
    np.testing.assert_allclose(nodes[run["mesh/tetrahedron_mid_edges"].values], nodes[edges].mean(axis=2), rtol=1e-14)


def test_sets_that_overlap_are_chosen_from(tetrahedra, tmp_path):
    points, cells, _ = tetrahedra
    sets = {"left": on(points, 0, 0.0), "lower": np.flatnonzero(points[:, 2] <= 1.0)}
    meshio.Mesh(points, [("tetra", cells)], point_sets=sets).write(tmp_path / "part.inp")
    with pytest.raises(ConversionError, match="'left' and 'lower' overlap.*--sets"):
        convert(tmp_path / "part.inp", tmp_path / "part.msh")
    assert set(convert(tmp_path / "part.inp", tmp_path / "part.msh", sets=["left"]).faces.values()) == {"left"}
    with pytest.raises(ConversionError, match="no set 'top'; there are left, lower"):
        convert(tmp_path / "part.inp", tmp_path / "part.msh", sets=["top"])


def test_errors_are_lines_and_exit_code_2(tetrahedra, tmp_path):
    points, _, bottom = tetrahedra
    meshio.Mesh(points, [("triangle", bottom)]).write(tmp_path / "shell.vtu")
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
