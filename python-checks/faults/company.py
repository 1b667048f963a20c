"""Other programs at the same file: they meddle with it, write it too, read it meanwhile."""

import shutil
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import h5py

from faults.integrity import results
from faults.program import BAD_INPUT, Outcome, Program, finish, left_overs, settings
from faults.setting import RUN, SMALLER, TIGHT, Setting, sound
from faults.table import Row, Verdict


def run(setting: Setting) -> Iterator[Row]:
    """Everything that company does."""
    yield from meddled(setting)
    yield from two_writers(setting)
    yield from reader_meanwhile(setting)


@dataclass(frozen=True)
class Truth:
    """What a file may hold that two programs had their hands on."""

    expected: dict[str, str]
    pairs: frozenset[tuple[str, str]]
    other: Path

    @classmethod
    def of(cls, setting: Setting) -> "Truth":
        """Solve both problems with both settings."""
        folder = setting.scratch / "truth"
        setting.fresh(folder)
        other = folder / "other.h5"
        cells = SMALLER
        setting.program.done(*RUN[:2], other, *RUN[3:], *cells)
        found = []
        for source in (setting.good, other):
            file = Path(shutil.copy(source, folder / "run.h5"))
            found.append(results(file))
            setting.program.done(*TIGHT, cwd=folder)
            found.append(results(file))
        pairs = frozenset((digests["mesh"], digests["solve"]) for digests in found)
        return cls(found[0], pairs, other)


def meddle(
    setting: Setting, case: str, truth: Truth, action: Callable[[Path], object]
) -> Row:
    """Do something to the file while a solve is at work on it."""
    row = Row(case)
    folder = setting.scratch / "meddled"
    setting.fresh(folder)
    started = time.monotonic()
    setting.program.done(*TIGHT, cwd=folder)
    seconds = time.monotonic() - started
    for _ in range(setting.trials):
        file = setting.fresh(folder)
        process = setting.program.start(*TIGHT, cwd=folder)
        time.sleep(setting.chance.uniform(0.0, seconds))
        action(file)
        row.count(judge_meddled(setting, finish(process, "solve"), file, truth))
    return row


def judge_meddled(
    setting: Setting, outcome: Outcome, file: Path, truth: Truth
) -> Verdict | str:
    """Refused, or stored in time; never a mixture of two files, and `run` goes on."""
    if outcome.fault:
        return outcome.fault
    if left_overs(file.parent):
        return f"left {left_overs(file.parent)}"
    if file.exists() and h5py.is_hdf5(file):
        if problem := sound(file) or mixture(setting.program, file, truth):
            return problem
    else:
        file.unlink(missing_ok=True)
    again = setting.program.run(*RUN, cwd=file.parent)
    if again.code != 0 or results(file) != truth.expected:
        return f"run did not go on: {again.stderr}"
    return Verdict.REFUSED if outcome.code == BAD_INPUT else Verdict.WENT_ON


def mixture(program: Program, file: Path, truth: Truth) -> str | None:
    """A solution that counts as fresh beside a mesh it was not computed on."""
    stages = program.done("status", file, "--json").json["stages"]
    fresh = {s["stage"]: s["digest"] for s in stages if s["state"] == "fresh"}
    if "solve" in fresh and (fresh["mesh"], fresh["solve"]) not in truth.pairs:
        return "a solution counts as fresh beside a mesh it was not computed on"
    return None


def meddled(setting: Setting) -> list[Row]:
    """The run file disappears, or another file takes its place."""
    truth = Truth.of(setting)
    actions: dict[str, Callable[[Path], object]] = {
        "removed": lambda file: file.unlink(missing_ok=True),
        "replaced by another": lambda file: put(truth.other, file),
        "overwritten by another": lambda file: shutil.copy(truth.other, file),
        "replaced by text": lambda file: file.write_text("a letter"),
    }
    case = "run file {} during `solve`"
    return [meddle(setting, case.format(n), truth, a) for n, a in actions.items()]


def put(source: Path, target: Path) -> None:
    """Rename a copy over a file."""
    copy = target.with_name("copy.h5")
    shutil.copy(source, copy)
    copy.replace(target)


def two_writers(setting: Setting) -> list[Row]:
    """Two commands at once: one is told to wait, or both have their turn."""
    row = Row("two writers at once")
    folder = setting.scratch / "writers"
    file = setting.fresh(folder)
    setting.program.done(*TIGHT, cwd=folder)
    expected = results(file)
    for _ in range(setting.trials):
        setting.fresh(folder)
        first = setting.program.start(*TIGHT, cwd=folder)
        time.sleep(setting.chance.uniform(0.0, 0.1))
        second = setting.program.start(*TIGHT, cwd=folder)
        outcomes = [finish(process, "solve") for process in (first, second)]
        codes = sorted(outcome.code for outcome in outcomes)
        messages = "".join(outcome.stderr for outcome in outcomes)
        if codes == [0, BAD_INPUT] and "busy" not in messages:
            row.count(f"refused for another reason: {messages}")
        elif codes not in ([0, 0], [0, BAD_INPUT]):
            row.count(f"exit codes {codes}: {messages}")
        elif results(file) != expected:
            row.count("another result")
        else:
            row.count(Verdict.REFUSED if BAD_INPUT in codes else Verdict.WENT_ON)
    return [row]


def reader_meanwhile(setting: Setting) -> list[Row]:
    """h5py reads and checks every value, again and again, while stages are written."""
    row = Row("h5py reads while stages are written")
    folder = setting.scratch / "reader"
    file = setting.fresh(folder)
    finished = threading.Event()

    def write() -> None:
        for epsilon in (1e-3, 1e-5, 1e-4, 1e-6):
            setting.program.run(*RUN, *settings(solve__epsilon=epsilon), cwd=folder)
            cells = SMALLER
            setting.program.run(*RUN, *cells, cwd=folder)
        finished.set()

    writer = threading.Thread(target=write)
    writer.start()
    while not finished.is_set():
        row.count(sound(file) or Verdict.WENT_ON)
    writer.join()
    return [row]
