"""The whole work from Python: runs and studies with typed results, warnings, progress, sweeps on executors."""

import fcntl
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future, ProcessPoolExecutor

import numpy as np
import pandas as pd
import pytest

from conftest import ROOT, SCENE

import contact3d as package
from contact3d.scene import Brick, Scene

PIPELINES = ROOT / "pipelines"
SMALL = {"body.brick.cells": [6, 2, 2]}
NEWTON = PIPELINES / "newton.toml"
AXES = {
    "friction.coefficient_1": [{"constant": 0.1}, {"constant": 0.3}],
    ("traction.0.value.0", "traction.0.value.2"): [[1e7, 2e7], [5e6, 2e7]],
}


@pytest.fixture(scope="module", autouse=True)
def environment(program):
    """This package and this program, in processes of executors too."""
    before = dict(os.environ)
    os.environ.update(CONTACT3D_PIPE=str(program), PYTHONPATH=str(ROOT / "python"), MPLBACKEND="Agg")
    yield
    os.environ.clear()
    os.environ.update(before)


@pytest.fixture(scope="module")
def loop(tmp_path_factory):
    return package.run(PIPELINES / "history.toml", tmp_path_factory.mktemp("loop") / "loop.h5")


@pytest.fixture(scope="module")
def greased(tmp_path_factory):
    return package.run(PIPELINES / "dry_and_greased.toml", tmp_path_factory.mktemp("greased") / "run.h5")


def test_a_run_shows_itself_as_a_summary(loop):
    for text in (repr(loop), str(loop), loop._repr_html_()):
        assert "Steel block pulled to and fro" in text and "contact force" in text and "MN on the body" in text
    assert loop.summary["history"] == "25 increments, time 1 to 5 s"
    assert "VTKHDF" not in loop.children and "certificate" not in loop["post"].children
    with package.open(loop.file, everything=True) as whole:
        assert "VTKHDF" in whole.children
        stored = whole["post/certificate"].to_dataset(inherit=False)
        assert loop.certificate == {name: value.item() for name, value in stored.data_vars.items()}


def test_histories_go_by_time_and_forces_by_their_names(loop):
    history = loop.history
    np.testing.assert_array_equal(history["time"].values[[0, -1]], [1.0, 5.0])
    assert history["dissipation"].sel(time=3.0).item() == history["dissipation"].values[12]
    assert list(loop.forces["source"].values) == ["clamp.0", "pull", "weight", "contact"]
    assert list(loop.forces["key"].values) == ["clamp.0", "traction.0", "pressure.0", "contact"]
    # A body at rest: all forces in all increments add up to rounding of the largest.
    total = np.abs(history["forces"].sum("source")).max().item()
    assert total < 1e-9 * np.abs(history["forces"]).max().item()
    pulled = history["forces"].sel(source="pull", axis="x")
    # 1.2e7 Pa on one square metre, times the factor of the step, which the steps raise and lower by sixths of 1 and 2.
    np.testing.assert_allclose(pulled.sel(time=[1.0, 2.0, 3.0, 3.5]), [0.0, 1.2e7, -1.2e7, 0.0], atol=1.0)
    table = loop.to_dataframe("history")
    assert table.index.name == "time" and len(table) == 25
    assert table["forces_pull_x"].tolist() == pulled.values.tolist()


def test_panes_of_a_brick_are_a_grid(loop, greased):
    panes = loop.panes()
    assert panes["pressure"].dims == ("y", "x") and panes["pressure"].shape == (2, 6)
    stored = loop["solve/multiplier_normal"]
    for n in range(12):
        there = panes.sel(x=stored.pane_x[n].item(), y=stored.pane_y[n].item())
        assert there["pressure"].item() == stored[n].item()
        assert there["zone"].item() == loop["post/contact_zone"][n].item()
    assert loop.panes(history=True)["slip"].dims == ("time", "friction_axis", "y", "x")
    last = loop.panes(history=True)["friction_stress"].isel(time=-1)
    np.testing.assert_array_equal(last.values, loop.panes()["friction_stress"].values)
    # Two faces and a strip between them that touches nothing.
    both = greased.panes()
    assert greased.faces == ["dry", "greased"] and both["pressure"].shape == (4, 12)
    held = both["pressure"].notnull()
    assert held.any("y").values.tolist() == [True] * 4 + [False] * 2 + [True] * 6
    assert both["area"].sum().item() == pytest.approx(2.5, rel=1e-14)  # A sum of products of coordinates.
    assert greased.panes("dry")["area"].sum().item() == pytest.approx(1.0, rel=1e-14)
    # 0.1 / 10 is no binary number: centres of one column differ by rounding.
    decimal = {"body.brick": {"size": [0.1, 0.04, 0.02], "cells": [10, 4, 2]}}
    decimal = package.run(NEWTON, greased.file.parent / "decimal.h5", set=decimal)
    assert decimal.panes()["pressure"].dims == ("y", "x") and decimal.panes()["pressure"].notnull().all()
    row = package.run(PIPELINES / "gmsh_foot.toml", greased.file.parent / "foot.h5").panes()
    assert row["pressure"].dims == ("pane",)


def test_pictures_tables_and_grids(loop, greased):
    for drawn in (loop.plot(), loop.plot("zone", time=2.1), greased.plot("slip.t1"), greased.plot("zone", "dry")):
        drawn.figure.canvas.draw()
        assert drawn.collections
    assert len(loop.to_dataframe("panes")) == 12 and len(loop.to_dataframe("nodes")) == 325
    body, face = loop.to_pyvista(), greased.to_pyvista("contact")
    assert body.compute_cell_sizes()["Volume"].sum() == pytest.approx(3.0, rel=1e-13)
    assert face.area == pytest.approx(2.5, rel=1e-6)  # VTK adds areas up in single precision.
    np.testing.assert_array_equal(body["displacement"], loop["solve/displacement"].values)
    quadratic = package.run(PIPELINES / "quadratic.toml", loop.file.parent / "quadratic.h5", set=SMALL)
    assert quadratic.to_pyvista().compute_cell_sizes()["Volume"].sum() == pytest.approx(3.0, rel=1e-13)
    for wrong in (lambda: loop.plot("heat"), lambda: loop.plot("slip"), lambda: loop.panes("z_max"), lambda: greased.history):
        with pytest.raises(ValueError, match="|".join(("pressure, ", "slip.t1", "z_min", "no history"))):
            wrong()


def test_studies_have_typed_results(tmp_path):
    accuracy = package.accuracy(NEWTON, tmp_path / "accuracy.h5", set=SMALL, budget=20, coarsest=2, finest=4)
    assert isinstance(accuracy.solves, pd.DataFrame) and list(accuracy.levels["n_div"]) == [2, 4] and accuracy.advice
    limits = accuracy.limits.set_index("name")
    assert limits.loc["largest_von_mises", "concentration"] == "clamp" and limits["limit"].isna().all()
    isotropic = PIPELINES / "coulomb_isotropic.toml"
    paths = package.branches(isotropic, tmp_path / "b.h5", "friction.coefficient.constant", 0.1, 0.5, set=SMALL)
    assert paths.ends == ["to the end of the range"] and list(paths.solutions) == [0.1, 0.5]
    assert paths.points["parameter"].iloc[[0, -1]].tolist() == [0.1, 0.5]
    assert paths.plot().lines and "branches" in paths.tree.children
    stability = package.stability(NEWTON, set=SMALL)
    assert stability.passes and len(stability.table) == 1
    assert package.friction_law(NEWTON).bounds["f_max"]["value"] == 0.3
    assert [face["law"] for face in package.friction_law(PIPELINES / "dry_and_greased.toml").faces] == ["orthotropic", "capped"]
    assert package.report(tmp_path / "accuracy.h5", tmp_path / "page.html").read_text().startswith("<!DOCTYPE html>")
    run = package.run(NEWTON, tmp_path / "run.h5", set=SMALL)
    assert "<script" in package.report(run.file, tmp_path / "page.html", interactive=True).read_text()
    with pytest.raises(package.BadInput, match="friction.coefficient_9"):
        package.branches(NEWTON, tmp_path / "x.h5", "friction.coefficient_9", 0.1, 0.5, set=SMALL)
    assert not (tmp_path / "x.h5").exists()


def test_an_error_may_be_asked_for(tmp_path):
    run = package.run(NEWTON, tmp_path / "run.h5", set=SMALL, error="30%")
    bound = package.bound(tmp_path / "run.h5")
    assert bound["total"] is None and 0 < bound["elements"] < 1
    assert run["post/discretisation_error/total"].item() <= 0.3
    assert run.summary["levels"].startswith(f"{run['adapt/status'].item()}: {run['adapt/levels/n_free'].size} solved, ")
    force = run.to_dataframe("quantities").loc["normal_force"]
    assert force["value"] == run["post/resultants/normal_force"].item() and force["unit"] == "N"
    bar = max(force["largest"] - force["value"], force["value"] - force["smallest"]) / force["value"]
    assert force["error_bar"] == pytest.approx(bar * force["value"], rel=1e-12)  # rounding of the two differences
    said = subprocess.run([os.environ["CONTACT3D_PIPE"], "status", run.file], capture_output=True, text=True, check=True).stdout
    assert all(f" {words}\n" in said for name, words in run.summary.items() if name not in ("title", "levels"))
    told = run.summary["normal force"].split(" ± ")[1].removesuffix(" %")
    assert float(told) == pytest.approx(100 * bar, rel=0.05)  # two digits
    with pytest.warns(package.SceneWarning, match="hardly be met"), pytest.raises(package.NotConverged, match="budget"):
        package.run(NEWTON, tmp_path / "short.h5", set=SMALL, error="0.0001%", budget=0.001)
    with pytest.raises(package.BadInput, match="write 3% or 0.03"):
        package.run(NEWTON, tmp_path / "run.h5", set=SMALL, error="little")


def test_warnings_are_those_of_python(tmp_path):
    scene = Scene.from_toml(NEWTON)
    scene.parameters = {"unused": 3.0}
    with pytest.warns(package.SceneWarning, match="parameters.unused") as caught:
        package.run(scene, tmp_path / "run.h5", set=SMALL)
    assert caught[0].filename == __file__


def test_progress_is_a_bar(tmp_path, capsys):
    package.run(NEWTON, tmp_path / "run.h5", set=SMALL, progress=True)
    shown = capsys.readouterr().err
    assert "5/5" in shown and "solve" in shown
    package.run(NEWTON, tmp_path / "run.h5", set=SMALL)
    assert capsys.readouterr().err == "", "nobody watches"
    with pytest.raises(package.BadInput) as refused:
        package.run({"title": "nothing else"}, tmp_path / "x.h5", progress=True)
    assert "missing key `body`" in str(refused.value) and "\x1b" not in str(refused.value)


LONG = """
import contact3d
try:
    contact3d.run({scene!r}, "run.h5", set={{"body.brick.cells": [96, 32, 32]}}, threads=1)
except KeyboardInterrupt as stopped:
    print("stopped:", *stopped.__notes__)
"""


def test_an_interruption_ends_the_program_too(tmp_path):
    command = [sys.executable, "-c", LONG.format(scene=str(NEWTON))]
    # Under a command in the background of a shell interruptions are ignored, and so they would be here.
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, text=True,
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    lock = tmp_path / ".run.h5.lock"
    while not lock.exists() and process.poll() is None:
        time.sleep(0.02)
    # Python alone is told, as by the button of a notebook; it has to tell the program.
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate(timeout=60)
    assert said == "stopped: interrupted: nothing was stored yet\n"
    assert not (tmp_path / "run.h5").exists()
    with lock.open() as held:
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)  # The program has gone.


def test_nonsense_is_refused(tmp_path, monkeypatch):
    for nonsense in (5, None, [1.0]):
        with pytest.raises(TypeError, match="a scene is a path"):
            package.run(nonsense, tmp_path / "run.h5")
    with pytest.raises(TypeError, match="not NoneType"):
        package.run(NEWTON, tmp_path / "run.h5", set={"title": None})
    with pytest.raises(TypeError, match="target"):
        package.export(tmp_path / "run.h5")
    with pytest.raises(FileNotFoundError, match="there is no run file"):
        package.open(tmp_path / "run.h5")
    with pytest.raises(IsADirectoryError, match="contact3d.open_sweep"):
        package.open(tmp_path)
    with pytest.raises(FileNotFoundError, match="contact3d.sweep makes one"):
        package.open_sweep(tmp_path / "out")
    with pytest.raises(OSError, match="is no run file"):
        package.open(NEWTON)
    with pytest.raises(TypeError, match="a scene with axes"):
        package.sweep(Scene.from_toml(NEWTON), tmp_path / "out")
    monkeypatch.setenv("CONTACT3D_PIPE", str(tmp_path / "nowhere"))
    with pytest.raises(package.ProgramNotFound, match="nowhere"):
        package.run(NEWTON, tmp_path / "run.h5")
    assert not list(tmp_path.iterdir())


def digests(sweep):
    """The digest of each case's answer."""
    return {case["id"]: package.open(case["file"])["solve"].attrs["digest"] for case in sweep.cases}


def test_a_sweep_is_the_same_on_every_executor(tmp_path):
    from dask.distributed import Client

    alone = package.sweep(NEWTON, tmp_path / "alone", AXES, set=SMALL)
    assert (alone.computed, alone.kept, alone.failed) == (4, 0, {})
    assert alone.table["normal_force"].shape == (2, 2, 1)
    assert alone.table["traction.0.value.0"].attrs["units"] == "Pa"
    chosen = alone.case({"friction.coefficient_1": {"constant": 0.1}, "traction.0.value.0": 5e6})
    assert chosen["post/resultants/normal_force"].item() == alone.table["normal_force"].values[0, 1, 0]
    with ProcessPoolExecutor(2) as executor:
        pool = package.sweep(NEWTON, tmp_path / "pool", AXES, set=SMALL, executor=executor)
        assert (pool.computed, pool.kept) == (4, 0) and digests(pool) == digests(alone)
        lost = pool.cases[1]["file"]
        os.remove(lost)
        again = package.sweep(NEWTON, tmp_path / "pool", AXES, set=SMALL, executor=executor)
    assert (again.computed, again.kept) == (1, 3) and digests(again) == digests(alone)
    with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
        dask = package.sweep(NEWTON, tmp_path / "dask", AXES, set=SMALL, executor=client)
    assert dask.computed == 4 and digests(dask) == digests(alone)


def test_cases_wait_for_the_one_that_they_start_from(tmp_path):
    axes = {"friction.coefficient_1.constant": [0.1, 0.2, 0.3]}
    shared = SMALL | {"friction.coefficient_1": {"constant": 0.3}}
    alone = package.sweep(NEWTON, tmp_path / "alone", axes, set=shared, warm_start=True)
    with ProcessPoolExecutor(2) as executor:
        pool = package.sweep(NEWTON, tmp_path / "pool", axes, set=shared, warm_start=True, executor=executor)
    assert [case["start"] for case in pool.cases] == [None, *[case["id"] for case in pool.cases[:-1]]]
    assert digests(pool) == digests(alone)


def test_an_interrupted_sweep_has_a_table(tmp_path):
    class Stopped:
        """Runs one case."""

        ran = 0

        def submit(self, task, *arguments):
            if self.ran == 1:
                raise KeyboardInterrupt
            self.ran += 1
            future = Future()
            future.set_result(task(*arguments))
            return future

    with pytest.raises(KeyboardInterrupt):
        package.sweep(NEWTON, tmp_path, AXES, set=SMALL, executor=Stopped())
    assert sorted(package.open_sweep(tmp_path).to_dataframe()["status"]) == ["converged", "missing", "missing", "missing"]


def test_cases_that_do_not_converge_are_a_warning(tmp_path):
    shared = SMALL | {"solve.method": "fixed-point"}
    with pytest.warns(package.CasesWarning, match="1 not converged"):
        sweep = package.sweep(NEWTON, tmp_path / "out", {"solve.max_outer_steps": [1, 100]}, set=shared)
    assert sweep.not_converged == 1 and not sweep.failed
    # What a case without a solution came to last is no result.
    table = package.open_sweep(tmp_path / "out")
    assert list(table["status"].values == "converged") == [False, True]
    assert table["error"].values[0].startswith("out of outer steps at a change of ") and table["error"].values[1] == ""
    for name, missing in {"normal_force": np.nan, "contact_force": np.nan, "largest_pressure": np.nan, "zone_counts": -1}.items():
        unsolved, solved = table[name].values
        assert np.array_equal(unsolved, np.full_like(unsolved, missing), equal_nan=True) and np.isfinite(solved).all(), name
    before = (tmp_path / "out" / "sweep.toml").read_text()
    for folder in ("bad", "out"):
        with pytest.raises(package.BadInput, match="expected a finite positive number"):
            package.sweep(NEWTON, tmp_path / folder, {"friction.coefficient_1": [{"constant": -1.0}]}, set=SMALL)
    assert not (tmp_path / "bad").exists() and (tmp_path / "out" / "sweep.toml").read_text() == before


def test_classes_of_a_scene_are_those_of_the_schema():
    command = [sys.executable, ROOT / "scripts" / "scene_classes.py", "--check"]
    answer = subprocess.run(command, capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stdout


def test_classes_hold_every_scene(tmp_path):
    import tomllib

    scenes = [path for path in sorted(PIPELINES.glob("*.toml")) if not path.stem.startswith("sweep")]
    assert len(scenes) > 40
    for path in scenes:
        scene = Scene.from_toml(path)
        assert scene.to_dict() == tomllib.loads(path.read_text())
        assert Scene.from_toml(scene.to_toml()) == scene
    with pytest.raises(TypeError, match="sizes"):
        Brick(sizes=[1.0, 1.0, 1.0], cells=[2, 2, 2])
    with pytest.raises(TypeError, match="Scene has no key 'titel'"):
        Scene.from_dict({"titel": "a slip of the pen"})
    whole = Scene.from_toml(SCENE)
    whole.body.brick.cells = np.array([6, 2, 2])
    typed = package.run(whole, tmp_path / "typed.h5")
    assert typed["solve"].attrs["digest"] == package.run(SCENE, tmp_path / "path.h5", set=SMALL)["solve"].attrs["digest"]


def test_a_law_is_fitted_to_a_loop(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pipelines").symlink_to(PIPELINES)
    command = [sys.executable, ROOT / "python" / "examples" / "fit.py"]
    answer = subprocess.run(command, capture_output=True, text=True, check=True)
    values = [line.replace(",", "").split() for line in answer.stdout.splitlines()]
    for _, value, _, error, _, _, truth in values:
        # Three standard deviations hold the truth 997 times of 1000, and the noise has a fixed seed.
        assert abs(float(value) - float(truth)) <= 3.0 * float(error) < 0.1


def test_the_reference_does_what_it_says(tmp_path, monkeypatch):
    """The blocks of Python of two pages, the first of each."""
    import re

    monkeypatch.chdir(tmp_path)
    (tmp_path / "newton.toml").write_text(NEWTON.read_text())
    for page in ("reference/python.md", "how_to/cluster.md"):
        block = re.search(r"```python\n(.*?)```", (ROOT / "docs" / page).read_text(), re.DOTALL)
        exec(compile(block[1], page, "exec"), {})
    assert (tmp_path / "pressure.png").stat().st_size > 5_000
