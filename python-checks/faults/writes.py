"""Calls that fail in every command that writes: no corrupt file passes for a good one."""

import hashlib
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

import h5py
import numpy as np

from faults.failing_calls import Fault, build, counting, counts, draw
from faults.integrity import results, stage_digests
from faults.program import INCOMPLETE, ROOT, Outcome, Program, fresh_copy
from faults.program import settings
from faults.table import Row, Verdict
from faults.trial import Case, Trial

SCENE = ROOT / "pipelines" / "newton.toml"
SMALL = settings(body__brick__cells="[4,2,2]")
OTHER = settings(body__brick__cells="[2,2,2]")
RUN = ("run", SCENE, "run.h5", *SMALL)
PLAIN = (*RUN, "--no-figures")
OLD = ("run", SCENE, "run.h5", *OTHER)
FCLIB = ("export", "run.h5", "out.hdf5", "--kind", "fclib")
NUMBER = re.compile(rb"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")
OF_THE_MOMENT = re.compile(r"error\.txt$|seconds\.\w+$")
"""Errors of failed cases, and charts of the clock."""
CLOCKED = {"seconds", "date"}
"""Attributes that depend on the clock."""
GATHERED = ("cases/summary", "cases/figures", "series/")

SWEEP = f"""
scene = {str(SCENE)!r}
[set]
"body.brick.cells" = [4, 2, 2]
[[axis]]
key = "friction.coefficient_1.ramp.initial"
values = [0.25, 0.3]
"""


SOLVED_AGAIN = ("solve", "run.h5", *settings(solve__epsilon="1e-8"))
MESHES = ("--budget", "0.01", "--coarsest", "2", "--finest", "4")
PATH = ("--parameter", "friction.coefficient_1.ramp.initial", "--from", "0.3")

CASES = (
    Case("run, new file", RUN),
    Case("run, old file", RUN, (OLD,)),
    Case("run --linked", (*PLAIN, "--linked"), (OLD,)),
    Case("mesh", ("mesh", SCENE, "run.h5", *SMALL), (OLD,)),
    Case("assemble", ("assemble", "run.h5"), (("mesh", SCENE, "run.h5", *SMALL),)),
    Case("solve", SOLVED_AGAIN, (PLAIN,)),
    Case("post", ("post", "run.h5"), (PLAIN, SOLVED_AGAIN)),
    Case("sweep", ("sweep", "sweep.toml", "cases", "--series", "series")),
    Case("report", ("report", "run.h5", "page.html"), (PLAIN,)),
    Case("export fclib", FCLIB, (PLAIN,)),
    Case("export fclib-global", (*FCLIB[:-1], "fclib-global"), (PLAIN, FCLIB)),
    Case("export vtkhdf", ("export", "run.h5", "out.vtkhdf", "--kind", "vtkhdf"), (PLAIN,)),
    Case("accuracy", ("accuracy", *PLAIN[1:], *MESHES), (OLD,)),
    Case(
        "branches",
        ("branches", *RUN[1:], *PATH, "--to", "0.31", "--series", "paths"),
        (OLD,),
    ),
    Case("friction-law", ("friction-law", SCENE, "--figures", "law")),
    Case("man", ("man", "man")),
)


@dataclass
class Failing(Trial):
    """A command whose calls fail."""

    library: Path | None = None
    calls: dict[str, int] = field(default_factory=dict)

    def state(self, folder: Path) -> dict[str, str]:
        """What the files of a folder hold that does not depend on the clock."""
        return state(folder)

    def count(self) -> None:
        """Prepare, and count the calls."""
        counted = self.scratch / "calls"
        self.prepare(SWEEP, counting(self.library, counted))
        self.calls = counts(counted)

    def again(self) -> Outcome:
        """Give the command again; cases of a sweep that failed are tried again when asked for."""
        again = super().again()
        if again.code == 0 or self.case.name != "sweep":
            return again
        retried = (*self.case.command, "--retry-failed")
        return self.program.run(*retried, cwd=self.work)

    def meet(self, fault: Fault) -> Verdict | str:
        """Let calls fail, look at what is left, and give the command again."""
        fresh_copy(self.start, self.work)
        environment = fault.environment(self.library)
        ended = self.program.run(*self.case.command, cwd=self.work, env=environment)
        try:
            problem = self.problem_between(ended)
            if problem is None and self.may_go_on_otherwise(ended):
                problem = self.problem_after()
        except (OSError, ValueError, KeyError, RuntimeError) as error:
            problem = repr(error)
        if problem:
            return f"{fault}: exit {ended.code}, {problem} {ended.stderr[-200:]!r}"
        return Verdict.WENT_ON if ended.code in (0, INCOMPLETE) else Verdict.REFUSED

    def may_go_on_otherwise(self, ended: Outcome) -> bool:
        """Whether the command given again would do anything but what it does without faults."""
        return ended.code != 0 and all_bytes(self.work) != all_bytes(self.start)

    def problem_between(self, ended: Outcome) -> str | None:
        """What is wrong with how it ended and what it left."""
        if ended.fault:
            return ended.fault
        before, after = self.states
        now = state(self.work)
        if ended.code == 0 and now != after:
            keys = sorted({*now, *after})
            different = [key for key in keys if now.get(key) != after.get(key)]
            return f"as if all were well, but {different} are different"
        # A case of a sweep may fail, and be told in the tables, before a series does.
        told = ended.code != 0 and any(self.work.rglob("*.error.txt"))
        incomplete = ended.code == INCOMPLETE or told
        for key, value in now.items():
            if incomplete and key.startswith(GATHERED):
                continue  # tables and charts of the cases that are there
            if value not in (before.get(key), after.get(key)):
                return f"{key} is neither the old nor the new one"
        lost = [key for key in before if key not in now and key in after]
        if lost:
            return f"lost {lost}"
        return None


def state(folder: Path) -> dict[str, str]:
    """What the files of a folder hold that does not depend on the clock."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        hidden = path.name.startswith(".")
        if not path.is_file() or hidden or OF_THE_MOMENT.search(name):
            continue
        if not h5py.is_hdf5(path):
            text = NUMBER.sub(b"#", path.read_bytes())
            found[name] = hashlib.sha256(text).hexdigest()
        elif is_run_file(path):
            stage_digests(path)
            found |= {f"{name}/{stage}": d for stage, d in results(path).items()}
        else:
            found[name] = contents(path)
    return found


def all_bytes(folder: Path) -> dict[Path, bytes]:
    """Everything in a folder, empty locks left out."""
    files = (path for path in folder.rglob("*") if path.is_file())
    found = {path.relative_to(folder): path.read_bytes() for path in files}
    return {path: content for path, content in found.items() if path.suffix != ".lock"}


def is_run_file(path: Path) -> bool:
    """Whether a file is a run file by its name, not one of its stages nor the table of a sweep."""
    plain = "-" not in path.name and path.name != "summary.h5"
    return path.name == "run.h5" or (path.parent.name == "cases" and plain)


def contents(path: Path) -> str:
    """A digest of all values and attributes of an HDF5 file, clocks left out."""
    digest = hashlib.sha256()

    def add(name: str, item: h5py.HLObject) -> None:
        if "seconds" in name:
            return
        for key in sorted({*item.attrs} - CLOCKED):
            value = item.attrs[key]
            targets = [file[one].name for one in references(value)]
            digest.update(repr((name, key, targets or value)).encode())
        if isinstance(item, h5py.Dataset):
            values = item[()]
            is_text = item.dtype == object
            digest.update(name.encode())
            digest.update(repr(values).encode() if is_text else values.tobytes())

    with h5py.File(path, "r") as file:
        add("/", file)
        file.visititems(add)
    return digest.hexdigest()


def references(value: object) -> list[h5py.Reference]:
    """The references of an attribute, as dimension scales have them: by themselves, in lists, beside numbers."""
    if isinstance(value, h5py.Reference):
        return [value]
    if isinstance(value, np.ndarray | np.void) and value.dtype.kind in "OV":
        return [one for item in value.tolist() for one in references(item)]
    if isinstance(value, list | tuple):
        return [one for item in value for one in references(item)]
    return []


def lost_one_by_one(program: Program, scratch: Path, only: list[str]) -> Iterator[Row]:
    """Each write of a command claims to be done and is not, one at a time."""
    library = build(scratch)
    for case in (case for case in CASES if case.name in only):
        row = Row(f"each write lost, {case.name}", note="needs a C compiler and Linux")
        if library is not None:
            trial = Failing(program, case, scratch / case.name, library=library)
            trial.count()
            for number in range(1, trial.calls["write"] + 1):
                row.count(trial.meet(Fault("write", number, number, how="lose")))
        yield row


def run(
    program: Program,
    scratch: Path,
    count: int,
    seed: int,
    only: list[str] | None = None,
) -> Iterator[Row]:
    """`count` failures over all cases, as many for each."""
    chance = Random(seed)
    library = build(scratch)
    cases = [case for case in CASES if not only or case.name in only]
    for index, case in enumerate(cases):
        row = Row(f"calls fail, {case.name}", note="needs a C compiler and Linux")
        if library is not None:
            trial = Failing(program, case, scratch / str(index), library=library)
            trial.count()
            for _ in range(-(-count // len(cases))):
                row.count(trial.meet(draw(chance, trial.calls)))
        yield row
