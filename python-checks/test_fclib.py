"""Exported problems: read by FCLIB's own library and recomputed from the raw run file.

The library is Debian's libfclib0; without it the tests that need it are skipped and say so.
"""

import ctypes
import ctypes.util
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import splu

from run_file import open_run, read_matrix

PIPELINES = Path(__file__).resolve().parent.parent / "pipelines"
SCENE = "newton.toml"
SMALL = "body.brick.cells=[12,4,4]"

# One half with orthotropic friction, one without any.
HALVES = (
    'contact=[{face="z_min",name="dry",box=[[0.0,0.0,0.0],[1.0,1.0,0.0]],'
    "friction={coefficient_1={constant=0.6},coefficient_2={constant=0.4}}},"
    '{face="z_min",name="greased",box=[[1.5,0.0,0.0],[3.0,1.0,0.0]]}]'
)

# The scene and what is changed in it. The laws follow the slip, are constant, act on one face of two, or on none.
CASES = {
    "HKL Table 1": (SCENE, [SMALL]),
    "isotropic": (SCENE, [SMALL, "friction={coefficient={constant=0.3}}", "contact.gap=1e-5"]),
    "implicit": (SCENE, [SMALL, 'assemble.dual_operator="implicit"']),
    "two faces": ("dry_and_greased.toml", ["body.brick.cells=[12,4,2]", HALVES]),
}


class Matrix(ctypes.Structure):
    """struct fclib_matrix."""

    _fields_ = [
        ("nzmax", ctypes.c_int),
        ("m", ctypes.c_int),
        ("n", ctypes.c_int),
        ("p", ctypes.POINTER(ctypes.c_int)),
        ("i", ctypes.POINTER(ctypes.c_int)),
        ("x", ctypes.POINTER(ctypes.c_double)),
        ("nz", ctypes.c_int),
        ("info", ctypes.c_void_p),
    ]

    def read(self) -> sparse.csc_matrix:
        """The matrix as the library's own products take it: triplets have columns in p."""
        x = np.ctypeslib.as_array(self.x, (self.nzmax,))
        i = np.ctypeslib.as_array(self.i, (self.nzmax,))
        if self.nz >= 0:
            p = np.ctypeslib.as_array(self.p, (self.nz,))
            return sparse.csc_matrix((x, (i, p)), (self.m, self.n))
        assert self.nz == -1
        p = np.ctypeslib.as_array(self.p, (self.n + 1,))
        return sparse.csc_matrix((x, i, p), (self.m, self.n))


class Info(ctypes.Structure):
    """struct fclib_info."""

    _fields_ = [(name, ctypes.c_char_p) for name in ("title", "description", "math_info")]


class Local(ctypes.Structure):
    """struct fclib_local."""

    _fields_ = [
        *((name, ctypes.POINTER(Matrix)) for name in "WVR"),
        *((name, ctypes.POINTER(ctypes.c_double)) for name in ("mu", "q", "s")),
        ("spacedim", ctypes.c_int),
        ("info", ctypes.POINTER(Info)),
    ]


class Global(ctypes.Structure):
    """struct fclib_global."""

    _fields_ = [
        *((name, ctypes.POINTER(Matrix)) for name in "MHG"),
        *((name, ctypes.POINTER(ctypes.c_double)) for name in ("mu", "f", "b", "w")),
        ("spacedim", ctypes.c_int),
        ("info", ctypes.POINTER(Info)),
    ]


class Solution(ctypes.Structure):
    """struct fclib_solution."""

    _fields_ = [(name, ctypes.POINTER(ctypes.c_double)) for name in "vurl"]


@pytest.fixture(scope="session")
def libfclib():
    """FCLIB's own library."""
    name = ctypes.util.find_library("fclib")
    if name is None:
        pytest.skip("libfclib is not installed (Debian: apt-get install libfclib0)")
    library = ctypes.CDLL(name)
    library.fclib_read_local.restype = ctypes.POINTER(Local)
    library.fclib_read_global.restype = ctypes.POINTER(Global)
    library.fclib_read_solution.restype = ctypes.POINTER(Solution)
    library.fclib_read_guesses.restype = ctypes.POINTER(Solution)
    return library


@pytest.fixture(scope="session", params=list(CASES))
def exported(request, contact3d, tmp_path_factory):
    """A run file, its local and its global problem."""
    scene, changes = CASES[request.param]
    folder = tmp_path_factory.mktemp("fclib")
    run, local, whole = (folder / name for name in ("run.h5", "local.hdf5", "global.hdf5"))
    settings = [part for change in changes for part in ("--set", change)]
    contact3d("run", PIPELINES / scene, run, "--no-figures", *settings)
    contact3d("export", run, local, "--kind", "fclib")
    contact3d("export", run, whole, "--kind", "fclib-global")
    return run, local, whole


def stored_matrix(group: h5py.Group) -> sparse.csc_matrix:
    """A matrix by columns or of triplets."""
    shape = (int(group["m"][0]), int(group["n"][0]))
    p, i, x = group["p"][:], group["i"][:], group["x"][:]
    if group["nz"][0] == -1:
        return sparse.csc_matrix((x, i, p), shape)
    return sparse.csc_matrix((x, (i, p)), shape)


def natural_map_error(w, q, mu, r) -> float:
    """|r - P(r - u^)| / max(|q|, |r|, |u|), the projection by its optimality conditions along the cone's generator."""
    u = (w @ r + q).reshape(-1, 3)
    r = r.reshape(-1, 3)
    size = max(map(np.linalg.norm, (q, r, u)))
    z = r - u
    z[:, 0] -= mu * np.linalg.norm(u[:, 1:], axis=1)
    slope = np.linalg.norm(z[:, 1:], axis=1)
    # The generator (1, mu t) of the cone in the plane of z; its multiple nearest to z, but not below the apex.
    along = np.maximum(z[:, 0] + mu * slope, 0.0) / (1.0 + mu**2)
    direction = np.divide(z[:, 1:], slope[:, None], out=np.zeros_like(z[:, 1:]), where=slope[:, None] > 0)
    nearest = np.column_stack([along, (mu * along)[:, None] * direction])
    inside = slope <= mu * z[:, 0]
    nearest[inside] = z[inside]
    return np.linalg.norm(r - nearest) / size


class Raw:
    """What the exported arrays must be, from the arrays of the run file.

    Panes with friction come first; T of the others is not in the file, so `known` leaves their tangential components out.
    """

    def __init__(self, path: Path):
        with open_run(path) as file:
            assemble, solve = file["assemble"], file["solve"]
            self.stiffness = sparse.csc_matrix(read_matrix(assemble["stiffness"]))
            self.area, self.load = file["mesh/pane_area"][:], file["load/force"][:]
            self.h = file["load/dual_rhs"][:]
            dof = assemble["degree_of_freedom"][:]
            names = ("normal", "tangential")
            rows = [read_matrix(assemble[f"coupling_{name}"]) for name in names]
            rows = sparse.vstack(rows, format="csr")
            self.friction = 1.0 / solve["friction_inverse"][:]
            stresses = [solve[f"multiplier_{name}"][:].ravel() for name in names]
            self.u = np.empty(self.load.size)
            self.u[dof[dof >= 0]] = solve["displacement"][:][dof >= 0]
        m, pairs = len(self.area), len(self.friction)
        ours = [(3 * i, i) for i in range(m)]
        ours += [(3 * i + k, m + 2 * i + k - 1) for i in range(pairs) for k in (1, 2)]
        theirs, places = np.array(sorted(ours)).T
        self.known = theirs
        self.rows = rows[places] / self.area[theirs // 3][:, None]
        self.rows = sparse.csr_matrix(self.rows)
        self.offset = -self.h[places] / self.area[theirs // 3]
        self.force = np.concatenate(stresses)[places] * self.area[theirs // 3]
        self.m, self.pairs = m, pairs


def scaling(file: h5py.File) -> tuple[np.ndarray, float]:
    """D and t."""
    group = file["contact3d"]
    return group["scale"][:].ravel(), float(group["unit"][0])


def check_friction(file: h5py.File, raw: Raw, mu: np.ndarray) -> None:
    """Powers of two times diag(1, F1, F2) with mu = 1, or times 1 with mu = F."""
    scale = scaling(file)[0].reshape(-1, 3)
    power = np.log2(scale[:, 0])
    assert np.array_equal(power, np.round(power))
    ratio = scale[:, 1:] / scale[:, :1]
    # One reciprocal and one product on either side.
    near = {"rtol": 1e-14, "atol": 0.0}
    np.testing.assert_allclose(ratio[: raw.pairs] * mu[: raw.pairs, None], raw.friction, **near)
    assert (ratio[raw.pairs :] == 1.0).all() and (mu[raw.pairs :] == 0.0).all()
    np.testing.assert_array_equal(file["contact3d/pane_area"][:], raw.area)


def test_a_local_problem_is_that_of_the_run_file(exported):
    raw = Raw(exported[0])
    with h5py.File(exported[1]) as file:
        local = file["fclib_local"]
        w, q, mu = stored_matrix(local["W"]), local["vectors/q"][:], local["vectors/mu"][:]
        r, u = file["solution/r"][:], file["solution/u"][:]
        check_friction(file, raw, mu)
        (scale, unit), known = scaling(file), raw.known
        guess = file["guesses/1/u"][:], file["guesses/1/r"][:]
        assert file["guesses/number_of_guesses"][0] == 1
        assert local["spacedim"][0] == 3 and local["W/nz"][0] == -1
        assert {local[f"W/{name}"].dtype for name in ("p", "i", "nz", "m", "n", "nzmax")} == {np.dtype(np.int32)}
        assert local["info"].attrs["numberOfDegreeOfFreedom"][0] == len(raw.load)
    d = scale[known]
    expected = raw.rows @ splu(raw.stiffness).solve(raw.rows.T.toarray())
    expected = d[:, None] * expected * d
    # Two factorisations of a stiffness of condition about 1e4.
    np.testing.assert_allclose(w[known][:, known].toarray(), expected, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(q[known], raw.offset * d / unit, rtol=0.0, atol=1e-11)
    assert 0.05 < w.diagonal().mean() < 2.0 and 0.5 <= abs(q).max() <= 2.0
    # The scaling is by numbers that are stored to the last digit.
    np.testing.assert_allclose(r[known] * unit * d, raw.force, rtol=1e-14, atol=0.0)
    np.testing.assert_allclose(u, w @ r + q, rtol=0.0, atol=1e-12)
    closed = raw.rows @ raw.u
    opened = raw.offset + raw.rows @ splu(raw.stiffness).solve(raw.load)
    np.testing.assert_allclose(u[known], (opened - closed) * d / unit, rtol=0.0, atol=1e-9)
    assert (guess[0] == q).all() and (guess[1] == 0.0).all()
    # What is asked of exported solutions.
    assert natural_map_error(w, q, mu, r) <= 1e-10


def test_a_global_problem_is_that_of_the_run_file(exported):
    raw = Raw(exported[0])
    with h5py.File(exported[2]) as file:
        whole = file["fclib_global"]
        m, h = stored_matrix(whole["M"]), stored_matrix(whole["H"])
        vectors = {name: whole[f"vectors/{name}"][:] for name in ("f", "w", "mu")}
        v, u, r = (file[f"solution/{name}"][:] for name in "vur")
        check_friction(file, raw, vectors["mu"])
        (scale, unit), known = scaling(file), raw.known
        c = float(file["contact3d/displacement_scale"][0])
        assert whole["M/nz"][0] == whole["M/nzmax"][0] and whole["H/nz"][0] == whole["H/nzmax"][0]
    d = scale[known]
    assert abs(m - raw.stiffness * c**2).max() == 0.0
    near = {"rtol": 1e-14, "atol": 0.0}
    np.testing.assert_allclose(h[:, known].toarray(), -c * (raw.rows.T.toarray() * d), **near)
    np.testing.assert_allclose(vectors["f"], raw.load * c / unit, **near)
    np.testing.assert_allclose(v * c * unit, raw.u, **near)
    size = abs(vectors["f"]).max()
    # Equilibrium and the relative displacement, to the rounding of displacements at a condition of about 1e4.
    assert abs(m @ v - h @ r - vectors["f"]).max() <= 1e-9 * size
    np.testing.assert_allclose(u, h.T @ v + vectors["w"], rtol=0.0, atol=1e-12 * abs(u).max())
    # W and q of the local problem, by way of M.
    solve = splu(m).solve
    w, q = h.T @ solve(h.toarray()), h.T @ solve(vectors["f"]) + vectors["w"]
    assert natural_map_error(w, q, vectors["mu"], r) <= 1e-9


def test_fclib_reads_the_local_problem(exported, libfclib):
    path = str(exported[1]).encode()
    problem = libfclib.fclib_read_local(path).contents
    solution = libfclib.fclib_read_solution(path).contents
    count = ctypes.c_int()
    # Opens the file to write to it, so before h5py locks it.
    guess = libfclib.fclib_read_guesses(path, ctypes.byref(count))[0]
    assert count.value == 1
    with h5py.File(exported[1]) as file:
        local = file["fclib_local"]
        n = len(local["vectors/mu"])
        assert abs(problem.W.contents.read() - stored_matrix(local["W"])).max() == 0.0
        assert not problem.V and not problem.R and problem.spacedim == 3
        for name, size in (("q", 3 * n), ("mu", n)):
            read = np.ctypeslib.as_array(getattr(problem, name), (size,))
            np.testing.assert_array_equal(read, local[f"vectors/{name}"][:])
        title = local["info/title"][()].decode()
        assert problem.info.contents.title.decode() == title and title
        for stored, read in ((file["solution"], solution), (file["guesses/1"], guess)):
            for name in "ur":
                values = np.ctypeslib.as_array(getattr(read, name), (3 * n,))
                np.testing.assert_array_equal(values, stored[name][:])


def test_fclib_reads_the_global_problem(exported, libfclib):
    path = str(exported[2]).encode()
    problem = libfclib.fclib_read_global(path).contents
    with h5py.File(exported[2]) as file:
        whole = file["fclib_global"]
        for name in "MH":
            read = getattr(problem, name).contents.read()
            assert abs(read - stored_matrix(whole[name])).max() == 0.0
        assert not problem.G and problem.spacedim == 3
        for name in ("f", "w", "mu"):
            stored = whole[f"vectors/{name}"][:]
            read = np.ctypeslib.as_array(getattr(problem, name), stored.shape)
            np.testing.assert_array_equal(read, stored)
        solution = libfclib.fclib_read_solution(path).contents
        for name in "vur":
            stored = file[f"solution/{name}"][:]
            read = np.ctypeslib.as_array(getattr(solution, name), stored.shape)
            np.testing.assert_array_equal(read, stored)
