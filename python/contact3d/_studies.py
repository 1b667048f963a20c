"""The commands that solve, measure and write, each as a function with a typed result."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import pandas as pd

from . import _toml
from ._program import CompletedCommand, name, options, perform, pictures, settings
from ._plots import axes
from ._run import Run
from ._scene_input import SceneLike, given
from ._tree import open as open_run
from ._watch import STAGES

__all__ = ["Accuracy", "Branches", "Law", "Stability", "accuracy", "bound", "branches", "export", "friction_law", "report", "run", "stability"]

StrPath = str | os.PathLike[str]


@dataclass(frozen=True, repr=False)
class Study:
    """What a study found; ``data`` is all of it, as the program's ``--json`` has it.

    :param file: where it is stored; ``None`` if nowhere.
    """

    data: Any
    file: Path | None
    title: ClassVar[str] = "study"

    @property
    def tree(self) -> Run:
        """The stored datasets."""
        if self.file is None:
            raise ValueError(f"this {self.title} was not stored; give it a file")
        return open_run(self.file)

    def _lines(self) -> list[str]:
        return []

    def __repr__(self) -> str:
        stored = f" in {self.file}" if self.file else ""
        return "\n  ".join([f"{type(self).__name__}{stored}", *self._lines()])


@dataclass(frozen=True, repr=False)
class Accuracy(Study):
    """Errors of solvers and meshes, and what they cost."""

    title: ClassVar[str] = "convergence study"

    @property
    def solves(self) -> pd.DataFrame:
        """Algebraic error and cost of each method, operator and epsilon."""
        return pd.json_normalize(self.data["solves"])

    @property
    def levels(self) -> pd.DataFrame:
        """Each mesh: unknowns, error in the energy norm, quantities by their names in ``adapt.of``, each with its ``_order``, cost."""
        return pd.json_normalize(self.data["levels"])

    @property
    def limits(self) -> pd.DataFrame:
        """The limit of each quantity, or the ``concentration`` at which it grows with every finer mesh."""
        return pd.DataFrame(self.data["limits"])

    @property
    def advice(self) -> str:
        """What the study recommends, in words."""
        return self.data["advice"]

    def _lines(self) -> list[str]:
        return [f"{len(self.solves)} solves, {len(self.levels)} meshes", self.advice]


@dataclass(frozen=True, repr=False)
class Branches(Study):
    """Paths of solutions over a key of the scene."""

    title: ClassVar[str] = "search for paths"

    @property
    def key(self) -> str:
        """The key that changes."""
        return self.data["key"]

    @property
    def points(self) -> pd.DataFrame:
        """All points of all paths; ``path`` numbers them, ``kind`` names folds, kinks and branch points."""
        return pd.DataFrame([point for path in self.data["paths"] for point in path["points"]])

    @property
    def ends(self) -> list[str]:
        """How each path ends."""
        return [path["end"] for path in self.data["paths"]]

    @property
    def solutions(self) -> dict[float, pd.DataFrame]:
        """The solutions that were found at both ends of the range."""
        return {end["parameter"]: pd.DataFrame(end["solutions"]) for end in self.data["solutions"]}

    @property
    def is_followed(self) -> bool:
        """Whether every path was followed to its end. Other solutions may exist all the same."""
        return self.data["followed"]

    def plot(self, y: str = "normal_force", ax: Any = None) -> Any:
        """Draws the paths with matplotlib: a column of :attr:`points` over the key."""
        ax = axes(ax, 0.7)
        points = self.points
        for path, along in points.groupby("path"):
            ax.plot(along["parameter"], along[y], label=f"path {path + 1}")
            special = along[~along["kind"].isin(["regular", "start", "end"])]
            ax.plot(special["parameter"], special[y], "k.")
        ax.set(xlabel=self.key, ylabel=y.replace("_", " "))
        ax.legend()
        return ax

    def _lines(self) -> list[str]:
        found = [f"{self.key} from {self.data['from']} to {self.data['to']}: {len(self.ends)} paths"]
        found += [f"path {k + 1} goes {end}" for k, end in enumerate(self.ends)]
        return found + [f"{len(table)} solutions at {at}" for at, table in self.solutions.items()]


@dataclass(frozen=True, repr=False)
class Stability(Study):
    """How far solutions can be trusted: a row for each scene."""

    title: ClassVar[str] = "check"

    @property
    def table(self) -> pd.DataFrame:
        """Verdict, conditioning, disagreement of algorithms and variation, a row for each scene."""
        return pd.json_normalize(self.data)

    @property
    def passes(self) -> bool:
        """Whether no check failed."""
        return all(row["verdict"] != "fail" for row in self.data)

    def _lines(self) -> list[str]:
        return [" ".join(filter(None, [f"{row['name']}: {row['verdict']}", row["findings"]])) for row in self.data]


@dataclass(frozen=True, repr=False)
class Law(Study):
    """Bounds of the friction laws of a scene."""

    title: ClassVar[str] = "law"
    figures: list[Path] = field(default_factory=list)

    @property
    def faces(self) -> list[dict[str, Any]]:
        """The law of each contact face."""
        return self.data["faces"]

    @property
    def bounds(self) -> dict[str, Any]:
        """F_min, F_max, Lipschitz modulus and κ of the first face, each with the place where it is reached."""
        return self.faces[0]["bounds"] or {}

    def _lines(self) -> list[str]:
        words = []
        for face in self.faces:
            words.append(face["law"])
            bounds = (face["bounds"] or {}).items()
            words += [f"  {key} {bound['value']:.6g}" for key, bound in bounds if isinstance(bound, dict)]
        return words


Found = TypeVar("Found", bound=Study)


def run(
    scene: SceneLike,
    file: StrPath,
    *,
    set: Mapping[str, Any] | None = None,
    error: float | str | None = None,
    of: str | Mapping[str, Any] | None = None,
    budget: float | None = None,
    figures: StrPath | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> Run:
    """Solves a scene, or what of it is not up to date in ``file``, and opens the run file.

    :param scene: the path of a scene, its text (of more than one line), a dict as ``tomllib`` makes it, or a
        :class:`contact3d.scene.Scene`. Mesh files are looked for beside a scene with a path, else in the working directory.
    :param file: the run file, made or brought up to date.
    :param set: keys of the scene to change, such as ``{"friction.coefficient.constant": 0.4}``.
    :param error: refine the mesh until the estimated error is no larger, such as ``0.05`` or ``"5%"``.
    :param of: the quantity that ``error`` is meant of, such as ``"normal_force"`` or ``{"mean_pressure": {"box": [...]}}``; the
        energy norm without it.
    :param budget: seconds after which no mesh may end, by forecast.
    :param figures: a folder for the pictures; none are drawn without it.
    :param threads: the processors that may compute; all by default. The results do not depend on it.
    :param progress: a bar of tqdm; by default where someone watches, in a terminal or in Jupyter.
    :raises NotConverged, BadInput, InternalError, Interrupted: with the program's message.
    """
    of = of if of is None or isinstance(of, str) else _toml.value(of)
    asked = options(error=error, of=of, budget=budget, threads=threads)
    command = [*_on_file("run", scene, file), *asked, *pictures(figures)]
    total = STAGES if error is None else None
    _ask(command, scene, set, progress, total).check(Path(file))
    return open_run(file)


def accuracy(
    scene: SceneLike,
    file: StrPath,
    *,
    set: Mapping[str, Any] | None = None,
    coarsest: int | None = None,
    finest: int | None = None,
    unknowns: int | None = None,
    budget: float | None = None,
    figures: StrPath | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> Accuracy:
    """Measures the errors of solvers and meshes for a scene, and what each digit costs.

    :param coarsest: smallest n_div of the meshes of a brick.
    :param finest: n_div of the finest mesh of a brick, a multiple of the scene's.
    :param unknowns: most unknowns of the two finer meshes of a mesh file or of several bodies.
    :param budget: seconds, half of them for the solves of all methods; by default 10 for these solves alone.
    """
    measures = options(coarsest=coarsest, finest=finest, unknowns=unknowns, budget=budget, threads=threads)
    command = [*_on_file("accuracy", scene, file), *measures, *pictures(figures)]
    return _study(Accuracy, command, scene, set, progress, file)


def branches(
    scene: SceneLike,
    file: StrPath,
    parameter: str,
    start: float,
    end: float,
    *,
    set: Mapping[str, Any] | None = None,
    all: bool = False,
    series: StrPath | None = None,
    figures: StrPath | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> Branches:
    """Follows the solutions over a key of the scene.

    :param parameter: the key, a number such as ``friction.coefficient.constant``.
    :param start: its value where paths begin; ``end`` that at the other end of the range.
    :param all: search for all solutions at both ends, and follow each.
    :param series: a folder for the points of each path as a series that ParaView plays.
    """
    measures = [f"--from={start}", f"--to={end}", *options(parameter=parameter, all=all, series=series, threads=threads)]
    command = [*_on_file("branches", scene, file), *measures, *pictures(figures)]
    return _study(Branches, command, scene, set, progress, file)


def stability(
    scene: SceneLike | None = None,
    *,
    file: StrPath | None = None,
    set: Mapping[str, Any] | None = None,
    coarse: bool = False,
    only: str | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> Stability:
    """Checks conditioning, agreement of algorithms and invariance, for one scene or, without one, for all hard cases.

    :param file: where the table is stored; nowhere without it.
    :param coarse: small meshes of the hard cases only; ``only`` those of a family, or with this in their names.
    """
    measures = options(table=file, coarse=coarse, only=only, threads=threads)
    command = ["stability", *([] if scene is None else [_place(scene)]), *measures]
    return _study(Stability, command, scene, set, progress, file)


def bound(file: StrPath, *, threads: int | None = None) -> dict[str, Any]:
    """Bounds the discretisation error of a solved run file, and stores the bound in it.

    :param file: the run file.
    :returns: ``total``, the relative error in the energy norm that is not exceeded, None where friction follows the pressure;
        ``elements``, that for the contact stresses of the computed solution; and the parts of ``total``.
    :raises BadInput: a run file that is not solved, a scene whose error cannot be bounded.
    """
    completed = perform(["bound", name(file), *options(threads=threads)])
    completed.check(Path(file))
    return completed.data


def friction_law(scene: SceneLike, *, set: Mapping[str, Any] | None = None, figures: StrPath | None = None) -> Law:
    """Bounds the friction laws of a scene, without solving anything.

    :param figures: a folder for pictures of them.
    """
    completed = _ask(["friction-law", _place(scene), *pictures(figures)], scene, set, False)
    completed.check()
    return Law(completed.data, None, [Path(picture) for picture in completed.data["figures"]])


def report(file: StrPath, page: StrPath = "report.html", *, interactive: bool = False) -> Path:
    """Writes one HTML page, which needs no network, of a run file or of the folder of a sweep.

    :param interactive: the body of a run file in 3D.
    """
    perform(["report", name(file), name(page), *options(interactive=interactive)]).check(Path(file))
    return Path(page)


def export(
    file: StrPath,
    *,
    vtkhdf: StrPath | None = None,
    fclib: StrPath | None = None,
    sparse: bool = False,
) -> None:
    """Writes a part of a solved run file for other programs.

    :param file: the run file, which stays as it is.
    :param vtkhdf: a file for PyVista and ParaView, whose readers go by the suffix: ``NAME.vtkhdf``.
    :param fclib: a file of the Friction Contact Library, for Siconos: u = W r + q, with the dense W.
    :param sparse: in place of that the global problem M v = H r + f with sparse matrices.
    :raises BadInput: a run file that is not solved, a law that such a file cannot hold.
    """
    if vtkhdf is None and fclib is None:
        raise TypeError("export: name a target, vtkhdf= or fclib=")
    if vtkhdf is not None:
        perform(["export", name(file), name(vtkhdf), "--kind=vtkhdf"]).check(Path(file))
    if fclib is not None:
        kind = "fclib-global" if sparse else "fclib"
        perform(["export", name(file), name(fclib), f"--kind={kind}"]).check(Path(file))


def _place(scene: SceneLike) -> str:
    path, _, _ = given(scene)
    return "/dev/stdin" if path is None else name(path)


def _on_file(command: str, scene: SceneLike, file: StrPath) -> list[str]:
    return [command, _place(scene), name(file)]


def _ask(command: list[str], scene: SceneLike | None, changes: Mapping[str, Any] | None, progress: bool | None,
         total: int | None = None) -> CompletedCommand:
    _, text, ours = (None, None, {}) if scene is None else given(scene)
    return perform(command + settings({**ours, **(changes or {})}), text=text, total=total, progress=progress)


def _study(kind: type[Found], command: list[str], scene: SceneLike | None, changes: Mapping[str, Any] | None,
           progress: bool | None, file: StrPath | None) -> Found:
    """Runs a study; one that did not converge is in the error."""
    completed = _ask(command, scene, changes, progress)
    place = None if file is None else Path(file)
    found = kind(completed.data, place) if completed.exit_code in (0, 1) else None
    completed.check(place, found)
    assert found is not None
    return found
