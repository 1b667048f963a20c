"""Hostile surroundings: full disks, read-only places, other programs at the same file."""

import os
import random
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from faults import company, limits
from faults.program import BAD_INPUT, INCOMPLETE, Outcome, Program, left_overs, settings
from faults.setting import LOOSE, RUN, SCENE, SMALL, SMALLER, TIGHT, Setting, sound
from faults.table import Row, Verdict

DISK = 16 << 20
"""Bytes of the small disk: a few times a run file."""
NOBODY = 65534


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
        limits.run,
        company.run,
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
        "mesh": ("mesh", SCENE, "run.h5", *SMALLER),
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
    if outcome.code in (INCOMPLETE, BAD_INPUT) and "stored before and kept" in outcome.stderr:
        # Earlier stages were stored before the disk was full, or only pictures do not fit; each commit is whole.
        left = left_overs(disk)
        verdict = f"{name} left {left}" if left else Verdict.WENT_ON
    else:
        verdict = refused(outcome, file, before)
    problem = sound(file) if file.exists() else None
    filler.unlink()
    if setting.program.run(*command, cwd=disk).code != 0:
        return f"{name} did not go on with room again"
    return problem or verdict


WRITERS = {
    "run": (*RUN, *settings(solve__epsilon=1e-3)),
    "mesh": ("mesh", SCENE, "run.h5"),
    "assemble": ("assemble", "run.h5"),
    "solve": TIGHT,
    "post": ("post", "run.h5", "--no-figures"),
    "accuracy": ("accuracy", SCENE, "run.h5", "--no-figures", *SMALL, "--finest", "4"),
}
"""Every command that writes a run file."""


def readers_and_writers(setting: Setting, row: Row, folder: Path, **options) -> None:
    """Where nothing can be written, every writer is refused and every reader works."""
    file = folder / "run.h5"
    before = file.read_bytes()
    for command in WRITERS.values():
        row.count(
            refused(setting.program.run(*command, cwd=folder, **options), file, before)
        )
    for command in (("status", "run.h5"), ("check", "run.h5")):
        outcome = setting.program.run(*command, cwd=folder, **options)
        row.count(Verdict.WENT_ON if outcome.code == 0 else repr(outcome))
    report = setting.scratch / f"report-{folder.name}"
    report.mkdir()
    report.chmod(0o777)
    command = ("report", "run.h5", report / "report.html")
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
