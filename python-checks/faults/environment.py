"""Hostile surroundings: full disks, read-only places, other programs at the same file."""

import os
import random
import shutil
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import h5py

from faults.integrity import results, stage_digests
from faults.program import (
    BAD_INPUT,
    ROOT,
    Outcome,
    Program,
    finish,
    left_overs,
    settings,
)
from faults.table import Row, Verdict

SCENE = ROOT / "pipelines" / "hkl2011_table1.toml"
SMALL = settings(body__brick__cells="[12,4,4]", solve__epsilon=1e-6)
LOOSE = ("solve", "run.h5", "--epsilon", "1e-4")
TIGHT = ("solve", "run.h5", "--epsilon", "1e-8")
RUN = ("run", SCENE, "run.h5", "--no-figures", *SMALL)
DISK = 16 << 20
"""Bytes of the small disk: a few times a run file."""
NOBODY = 65534


@dataclass(frozen=True)
class Setting:
    """The program and a finished run file to start from."""

    program: Program
    scratch: Path
    good: Path
    chance: random.Random
    trials: int

    def fresh(self, folder: Path) -> Path:
        """The finished run file alone in a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for path in folder.iterdir():
            path.unlink() if path.is_file() else shutil.rmtree(path)
        return Path(shutil.copy(self.good, folder / "run.h5"))


def run(program: Program, scratch: Path, seed: int, trials: int = 24) -> Iterator[Row]:
    """All surroundings."""
    good = scratch / "good.h5"
    program.done("run", SCENE, good, "--no-figures", *SMALL)
    setting = Setting(program, scratch, good, random.Random(seed), trials)
    for surroundings in (
        full_disk,
        read_only_disk,
        read_only_folder,
        read_only_file,
        meddled,
        two_writers,
        reader_meanwhile,
    ):
        yield from surroundings(setting)


@contextmanager
def small_disk(folder: Path) -> Iterator[Path | None]:
    """A tmpfs of its own; `None` where this process may not mount one."""
    folder.mkdir(parents=True)
    mount = ["mount", "-t", "tmpfs", "-o", f"size={DISK}", "tmpfs", str(folder)]
    mounted = subprocess.run(mount, capture_output=True, check=False).returncode == 0
    try:
        yield folder if mounted else None
    finally:
        if mounted:
            subprocess.run(["umount", str(folder)], check=True)


def refused(outcome: Outcome, file: Path, before: bytes | None) -> Verdict | str:
    """Bad input, and nothing on disk changed."""
    if outcome.fault:
        return outcome.fault
    if outcome.code != BAD_INPUT:
        return f"{outcome.command} ended with {outcome.code}"
    now = file.read_bytes() if file.exists() else None
    if now != before:
        return f"{outcome.command} refused, but changed the file"
    if left_overs(file.parent):
        return f"{outcome.command} left {left_overs(file.parent)}"
    return Verdict.REFUSED


def full_disk(setting: Setting) -> list[Row]:
    """Less and less room for the new state, for each stage; then room again."""
    commands = {
        "run": RUN,
        "mesh": ("mesh", SCENE, "run.h5", *settings(body__brick__cells="[6,2,2]")),
        "assemble": ("assemble", "run.h5"),
        "solve": LOOSE,
        "post": ("post", "run.h5", "--no-figures"),
    }
    rows = []
    with small_disk(setting.scratch / "disk") as disk:
        for name, command in commands.items():
            row = Row(f"disk full during `{name}`", note="a tmpfs needs root")
            rows.append(row)
            if disk is None:
                continue
            for step in range(setting.trials):
                share = step / setting.trials
                row.count(fill_and_run(setting, disk, command, name, share))
    return rows


def fill_and_run(
    setting: Setting, disk: Path, command: tuple, name: str, share: float
) -> Verdict | str:
    """Leave a share of what the command needs, and give the room back afterwards."""
    file = setting.fresh(disk)
    if name == "run":
        file.unlink()
    before = file.read_bytes() if file.exists() else None
    room = int(share * setting.good.stat().st_size * (3 if name == "run" else 1))
    filler = disk / "filler"
    filler.write_bytes(bytes(max(shutil.disk_usage(disk).free - room, 0)))
    outcome = setting.program.run(*command, cwd=disk)
    if outcome.code == 0:
        return sound(file) or Verdict.WENT_ON
    if name == "run" and file.exists():
        # Earlier stages were stored before the disk was full; each commit is whole.
        before = file.read_bytes()
    verdict = refused(outcome, file, before)
    problem = sound(file) if file.exists() else None
    filler.unlink()
    if setting.program.run(*command, cwd=disk).code != 0:
        return f"{name} did not go on with room again"
    return problem or verdict


def sound(file: Path) -> str | None:
    """What h5py finds wrong with a file."""
    try:
        stage_digests(file)
    except (OSError, ValueError, KeyError) as error:
        return f"{file.name}: {error!r}"
    return None


WRITERS = {
    "run": (*RUN, *settings(solve__epsilon=1e-3)),
    "mesh": ("mesh", SCENE, "run.h5"),
    "assemble": ("assemble", "run.h5"),
    "solve": TIGHT,
    "post": ("post", "run.h5", "--no-figures"),
    "accuracy": ("accuracy", SCENE, "run.h5", "--no-figures", *SMALL, "--finest", "4"),
}
"""Every command that writes a run file."""


def readers_and_writers(
    setting: Setting, row: Row, folder: Path, **options
) -> None:
    """Where nothing can be written, every writer is refused and every reader works."""
    file = folder / "run.h5"
    before = file.read_bytes()
    for command in WRITERS.values():
        row.count(refused(setting.program.run(*command, cwd=folder, **options), file, before))
    for command in (("status", "run.h5"), ("check", "run.h5")):
        outcome = setting.program.run(*command, cwd=folder, **options)
        row.count(Verdict.WENT_ON if outcome.code == 0 else repr(outcome))
    report = setting.scratch / f"report-{folder.name}"
    report.mkdir()
    report.chmod(0o777)
    command = ("report", "run.h5", "-o", report / "report.html")
    outcome = setting.program.run(*command, cwd=folder, **options)
    row.count(Verdict.WENT_ON if outcome.code == 0 else repr(outcome))


def read_only_disk(setting: Setting) -> list[Row]:
    """A disk mounted read-only."""
    row = Row("read-only disk", note="a tmpfs needs root")
    with small_disk(setting.scratch / "read-only") as disk:
        if disk is not None:
            setting.fresh(disk)
            remount = ["mount", "-o", "remount,ro", str(disk)]
            subprocess.run(remount, check=True)
            readers_and_writers(setting, row, disk)
    return [row]


def read_only_folder(setting: Setting) -> list[Row]:
    """A folder in which the user may not make files; root may everywhere, so it becomes nobody."""
    row = Row("read-only folder")
    folder = setting.scratch / "folder"
    setting.fresh(folder).chmod(0o644)
    folder.chmod(0o555)
    reachable(folder)
    options = {"user": NOBODY, "group": NOBODY} if os.geteuid() == 0 else {}
    readers_and_writers(setting, row, folder, **options)
    folder.chmod(0o755)
    return [row]


def reachable(folder: Path) -> None:
    """Let everybody walk to a folder that this process owns."""
    for parent in folder.parents:
        if parent.stat().st_uid == os.geteuid() and not parent.stat().st_mode & 0o001:
            parent.chmod(parent.stat().st_mode | 0o111)


def read_only_file(setting: Setting) -> list[Row]:
    """A run file without write permission, in a folder that has it."""
    row = Row("read-only file")
    folder = setting.scratch / "file"
    setting.fresh(folder).chmod(0o444)
    readers_and_writers(setting, row, folder)
    return [row]


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
        cells = settings(body__brick__cells="[6,2,2]")
        setting.program.done(*RUN[:2], other, *RUN[3:], *cells)
        found = []
        for source in (setting.good, other):
            file = Path(shutil.copy(source, folder / "run.h5"))
            found.append(results(file))
            setting.program.done(*TIGHT, cwd=folder)
            found.append(results(file))
        pairs = frozenset((digests["mesh"], digests["solve"]) for digests in found)
        return cls(found[0], pairs, other)


def meddle(setting: Setting, case: str, truth: Truth, action: Callable[[Path], object]) -> Row:
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
            cells = settings(body__brick__cells="[6,2,2]")
            setting.program.run(*RUN, *cells, cwd=folder)
        finished.set()

    writer = threading.Thread(target=write)
    writer.start()
    while not finished.is_set():
        row.count(sound(file) or Verdict.WENT_ON)
    writer.join()
    return [row]
