"""Many cases of a scene: by the program itself, or by an executor that runs a case at a time."""

import os
import queue
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import pandas as pd

from . import _toml, _watch
from ._files import write_whole
from ._program import Interrupted, name, options, perform
from ._run import Run
from ._scene_input import SceneLike, given
from ._sweep_table import SUMMARY, SweepTable, open_sweep
from ._tree import open as open_run

StrPath = str | os.PathLike[str]


class Executor(Protocol):
    """What ``concurrent.futures``, ``mpi4py.futures``, joblib's loky and ``dask.distributed.Client`` have in common."""

    def submit(self, task: Any, /, *arguments: Any) -> Any:
        """A future with ``result``, ``cancel`` and ``add_done_callback``."""


@dataclass(frozen=True, repr=False)
class Sweep:
    """The cases of a sweep and what became of them.

    :param folder: where their run files and tables are.
    :param cases: name, run file, start and settings of each.
    :param computed: cases that this call ran; ``kept`` those that had been run before.
    :param failed: the messages of cases that failed, by name.
    :param busy: cases that another process is at work on.
    :param not_converged: cases that did not converge.
    """

    folder: Path
    cases: list[dict[str, Any]]
    computed: int
    kept: int
    failed: dict[str, str]
    busy: int
    not_converged: int

    @property
    def table(self) -> SweepTable:
        """Settings and main results, a dimension for each axis."""
        return open_sweep(self.folder)

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each case: its keys, then its results."""
        return self.table.to_dataframe()

    def case(self, chosen: Mapping[str, Any]) -> Run:
        """The run file of the only case with these settings."""
        found = [case for case in self.cases if all(case["settings"].get(key) == value for key, value in chosen.items())]
        if len(found) != 1:
            raise KeyError(f"{len(found)} cases have {dict(chosen)}; the axes are {', '.join(self.cases[0]['settings'])}")
        return open_run(found[0]["file"])

    def __repr__(self) -> str:
        counts = f"{self.computed} computed, {self.kept} kept, {len(self.failed)} failed; {self.not_converged} not converged"
        failed = [f"\n  {case}: {message}" for case, message in self.failed.items()]
        return f"Sweep in {self.folder}: {len(self.cases)} cases, {counts}" + "".join(failed)


def sweep(
    source: SceneLike,
    folder: StrPath,
    axes: Mapping[str | tuple[str, ...], Sequence[Any]] | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    warm_start: bool = False,
    executor: Executor | None = None,
    threads: int | None = None,
    jobs: int | None = None,
    memory: float | None = None,
    retry_failed: bool = False,
    self_contained: bool = False,
    series: StrPath | None = None,
    figures: bool = False,
    progress: bool | None = None,
) -> Sweep:
    """Runs all cases that are not done yet; a call after a kill goes on where it stopped.

    :param source: the path of a sweep file, or with ``axes`` a scene as :func:`contact3d.run` takes it.
    :param folder: the run files and tables, made or continued; all machines see it.
    :param axes: the values of each key, such as ``{"friction.coefficient.constant": [0.1, 0.3]}``; a tuple of keys changes
        together, with a row of values for each case. The sweep and its scene are then written into ``folder``.
    :param set: keys that all cases share, with ``axes``.
    :param warm_start: start each case from its neighbour on the last axis, with ``axes``.
    :param executor: runs the cases one by one, such as ``ProcessPoolExecutor()``, ``MPIPoolExecutor()`` or a dask
        ``Client``; without it the program runs them on this machine. The results are the same to the bit.
    :param threads: processors of this machine, or those of each case with an executor, where one is the default.
    :param jobs: cases at the same time, and ``memory`` the gigabytes for assembled problems, without an executor.
    :param retry_failed: try cases again that failed before.
    :param self_contained: copy shared data into each run file.
    :param series: a folder for the cases as series that ParaView plays.
    :param figures: charts of what varies, in ``folder/figures``.
    :raises BadInput: a sweep or scene that cannot be used, or a folder that is another sweep's.

    Cases that fail or do not converge are no error but a warning; :attr:`Sweep.failed` has their messages.
    """
    folder = Path(folder)
    if folder.is_file():
        raise NotADirectoryError(f"{folder} is a file, and the cases of a sweep want a folder")
    with _kept_if_refused(folder):
        place = [_written(source, folder, axes, set, warm_start), name(folder)]
        plan = perform(["sweep", "plan", *place])
        plan.check(folder)
    how = options(retry_failed=retry_failed, self_contained=self_contained)
    computed = 0
    if executor is not None:
        if jobs is not None or memory is not None:
            raise TypeError("jobs and memory are for sweeps without an executor, which decides that itself")
        with _table_if_interrupted(place):
            events = _run_cases(executor, place, plan.data, [*how, *options(threads=threads or 1)], progress)
        computed = events.count("computed")
        how = options(self_contained=self_contained)
    limits = options(jobs=jobs, memory=memory, threads=threads, no_figures=not figures, series=series)
    with _table_if_interrupted(place):
        completed = perform(["sweep", *place, *how, *limits], total=len(plan.data), progress=progress and executor is None)
        counts = completed.data or {}
        if completed.exit_code != 1 or "cases" not in counts:
            completed.check(folder)
    computed += counts["computed"]
    found = Sweep(folder, plan.data, computed, len(plan.data) - computed - counts["failed"] - counts["busy"],
                  _failures(folder), counts["busy"], counts["not_converged"])
    if completed.exit_code == 1:
        _watch.warn([repr(found)], _watch.CasesWarning)
    return found


def _written(source: SceneLike, folder: Path, axes: Mapping[str | tuple[str, ...], Sequence[Any]] | None,
             changes: Mapping[str, Any] | None, warm_start: bool) -> str:
    """The sweep file: the given one, or one that is made of a scene and axes."""
    if axes is None:
        if not isinstance(source, (str, os.PathLike)) or changes or warm_start:
            raise TypeError("a sweep is the path of its file, which says all, or a scene with axes")
        return name(source)
    path, text, ours = given(source)
    folder.mkdir(parents=True, exist_ok=True)
    if text is not None:
        _write(folder / "scene.toml", text)
    scene = "scene.toml" if path is None else str(Path(path).absolute())
    rows = [{"keys": list(key), "rows": values} if isinstance(key, tuple) else {"key": key, "values": values}
            for key, values in axes.items()]
    whole = {"scene": scene, "warm_start": warm_start, "set": {**ours, **(changes or {})}, "axis": rows}
    _write(folder / "sweep.toml", _toml.document(whole))
    return name(folder / "sweep.toml")


@contextmanager
def _kept_if_refused(folder: Path) -> Iterator[None]:
    """Leaves the folder as it was where the sweep that is written into it is refused."""
    was_there = folder.exists()
    former = {file: file.read_bytes() if file.is_file() else None for file in (folder / "sweep.toml", folder / "scene.toml")}
    try:
        yield
    except BaseException:
        for file, content in former.items():
            if content is None:
                file.unlink(missing_ok=True)
            else:
                file.write_bytes(content)
        if not was_there and folder.is_dir():
            folder.rmdir()
        raise


@contextmanager
def _table_if_interrupted(place: list[str]) -> Iterator[None]:
    """Writes the table of the cases that are done, where an interruption keeps the program from it."""
    try:
        yield
    except (KeyboardInterrupt, Interrupted):
        perform(["sweep", "summary", *place])
        raise


def _write(file: Path, text: str) -> None:
    """Writes a text in one step, if it is not there yet."""
    if not file.is_file() or file.read_text(encoding="utf-8") != text:
        write_whole(file, text)


def run_case(place: list[str], case: str, how: list[str]) -> str:
    """Runs one case where an executor wants it, and tells what became of it; each case that failed has recorded its error."""
    completed = perform(["sweep", "run-case", *place, case, *how])
    if "event" not in (completed.data or {}):
        completed.check()
    return str(completed.data["event"])


def _run_cases(executor: Executor, place: list[str], cases: list[dict[str, Any]], how: list[str],
               progress: bool | None) -> list[str]:
    """Hands the cases to an executor, each once the one that it starts from has ended, and waits for all."""
    place = [os.path.abspath(path) for path in place]
    waiting: dict[str | None, list[str]] = {}
    for case in cases:
        waiting.setdefault(case["start"], []).append(case["id"])
    ended: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()
    running: dict[str, Any] = {}
    events: list[str] = []

    def submit(start: str | None) -> None:
        for case in waiting.pop(start, []):
            running[case] = executor.submit(run_case, place, case, how)
            running[case].add_done_callback(lambda future, case=case: ended.put((case, future)))

    with _watch.bar("sweep", len(cases), progress) as bar:
        try:
            submit(None)
            while running:
                case, future = ended.get()
                running.pop(case)
                events.append(future.result())
                if bar is not None:
                    bar.update()
                submit(case)
        finally:
            for future in running.values():
                future.cancel()
    return events


def _failures(folder: Path) -> dict[str, str]:
    """The errors of failed cases in the table."""
    table = open_run(folder / SUMMARY)["cases"].to_dataset(inherit=False)
    chosen = zip(table["id"].values, table["error"].values, table["status"].values, table["planned"].values, strict=True)
    return {str(case): str(error) for case, error, status, planned in chosen if planned and status == "failed"}
