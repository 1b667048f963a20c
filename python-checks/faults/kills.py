"""Signals at random moments: the last good state opens, and the same command goes on."""

import csv
import random
import signal
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from faults.integrity import results, stage_digests
from faults.program import ROOT, Program, finish, fresh_copy, left_overs, settings
from faults.table import Row, Verdict
from faults.trial import Case, Trial

PUBLISHED = ROOT / "pipelines" / "hkl2011_table1.toml"
SMALL = settings(body__brick__cells="[12,4,4]", solve__epsilon=1e-6)
OTHER = settings(body__brick__cells="[6,2,2]")
LARGE = ("--linked", *settings(body__brick__cells="[48,16,16]", solve__method='"auto"'))
EXPLICIT = settings(assemble__dual_operator='"explicit"')
RUN = ("run", PUBLISHED, "run.h5", "--no-figures")
SIGNALS = (signal.SIGKILL, signal.SIGINT, signal.SIGTERM)
REMOVES_LEFT_OVERS = (signal.SIGINT, signal.SIGTERM)
LONGER = 1.05
"""Moments reach a little beyond the end, so that the last commit is met too."""


def accuracy() -> tuple:
    """Both studies on small meshes."""
    return ("accuracy", *RUN[1:], *SMALL, "--budget", "0.02", "--finest", "8")


CASES = (
    Case("mesh", ("mesh", PUBLISHED, "run.h5", *SMALL), ((*RUN, *OTHER),)),
    Case(
        "assemble",
        ("assemble", "run.h5"),
        ((*RUN, *OTHER), ("mesh", PUBLISHED, "run.h5", *SMALL)),
    ),
    Case(
        "solve, with checkpoints",
        ("solve", "run.h5", *settings(solve__epsilon="1e-8")),
        ((*RUN, *SMALL),),
    ),
    Case(
        "post",
        ("post", "run.h5"),
        ((*RUN, *SMALL), ("solve", "run.h5", *settings(solve__epsilon="1e-7"))),
    ),
    Case("run, new file", (*RUN, *SMALL), ()),
    Case("run, old file", (*RUN, *SMALL), ((*RUN, *OTHER),)),
    Case("run, linked assembly", (*RUN, *LARGE), ((*RUN, *OTHER),), share=1),
    Case("accuracy", accuracy(), ((*RUN, *SMALL),)),
    Case("sweep", ("sweep", "sweep.toml", "cases", "--jobs", "2"), ()),
)

SWEEP = f"""
scene = {str(PUBLISHED)!r}
[set]
"body.brick.cells" = [12, 4, 4]
[[axis]]
key = "friction.coefficient_1.ramp.initial"
values = [0.25, 0.3, 0.35]
[[axis]]
key = "traction.0.value"
values = [[1e7, 0.0, 2e7], [5e6, 8.6e6, 2e7]]
"""


@dataclass
class Killed(Trial):
    """A command that signals strike."""

    def state(self, folder: Path) -> dict[str, str]:
        """Digests of all results in a folder, each checked against the values."""
        return state(folder)

    def strike(self, moment: float, number: signal.Signals) -> Verdict | str:
        """Send one signal, look at what is left, and give the command again."""
        fresh_copy(self.start, self.work)
        name = str(self.case.command[0])
        process = self.program.start(*self.case.command, cwd=self.work)
        time.sleep(moment)
        process.send_signal(number)
        ended = finish(process, name)
        where = f"{number.name} at {moment:.3f} of {self.seconds:.3f} s"
        if ended.code not in (0, -number):
            return f"{where}: ended with {ended.code}: {ended.stderr[-300:]}"
        try:
            problem = self.problem_between(number) or self.problem_after()
        except (OSError, ValueError, KeyError, RuntimeError) as error:
            problem = repr(error)
        return f"{where}: {problem}" if problem else Verdict.WENT_ON

    def problem_between(self, number: signal.Signals) -> str | None:
        """What is wrong with the state that the signal left."""
        if number in REMOVES_LEFT_OVERS and left_overs(self.work):
            return f"left {left_overs(self.work)}"
        before, after = self.states
        now = state(self.work)
        for key, digest in now.items():
            if digest not in (before.get(key), after.get(key)):
                return f"{key} is neither the old nor the new one"
        if before and not now:
            return "the last good state is gone"
        for file in run_files(self.work):
            status = self.program.run("status", file)
            if status.code != 0:
                return f"status of {file.name}: {status.fault or status.stderr}"
        return None


def run_files(folder: Path) -> list[Path]:
    """The run files of a folder, not the tables of a sweep nor files that hold one stage."""
    found = [*folder.glob("run.h5"), *folder.glob("cases/*.h5")]
    return sorted(f for f in found if "-" not in f.name and f.name != "summary.h5")


def state(folder: Path) -> dict[str, str]:
    """Digests of all results in a folder, each checked against the values."""
    found = {}
    for file in run_files(folder):
        stage_digests(file)
        found |= {f"{file.name}/{stage}": d for stage, d in results(file).items()}
    figures = sorted(folder.glob("*-figures/*.svg"))
    found |= {figure.name: figure.read_text()[-40:] for figure in figures}
    table = folder / "cases" / "summary.csv"
    if table.exists():
        with table.open(newline="") as file:
            rows = list(csv.DictReader(file))
        # A sweep begins with a table that says of every case that it is missing.
        there = (row for row in rows if row["status"] != "missing")
        found |= {f"row {row['id']}": repr(drop(row, "seconds")) for row in there}
    return found


def drop(row: dict, key: str) -> dict:
    """A row without one column."""
    return {name: value for name, value in row.items() if name != key}


def run(
    program: Program,
    scratch: Path,
    count: int,
    seed: int,
    only: list[str] | None = None,
) -> Iterator[Row]:
    """SIGKILL `count` times over all cases; SIGINT and SIGTERM a fifth as often."""
    cases = [case for case in CASES if not only or case.name in only]
    shares = sum(case.share for case in cases)
    moments = random.Random(seed)
    for index, case in enumerate(cases):
        trial = Killed(program, case, scratch / str(index))
        trial.prepare(SWEEP)
        for number in SIGNALS:
            row = Row(f"{number.name}, {case.name}")
            often = 1 if number is signal.SIGKILL else 5
            for _ in range(-(-count * case.share // (shares * often))):
                moment = moments.uniform(0.0, LONGER * trial.seconds)
                row.count(trial.strike(moment, number))
            yield row
