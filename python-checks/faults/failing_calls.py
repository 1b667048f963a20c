"""The program with system calls that fail on purpose; `failing_calls.c` says how."""

import errno
import os
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

SOURCE = Path(__file__).with_name("failing_calls.c")
LOSES = ("write", "sync", "rename", "truncate", "unlink", "mkdir", "chmod", "link")
"""Calls that change what is on the disk; `close` is left out where nothing hears of it."""
NEVER = 1 << 30


def build(folder: Path) -> Path | None:
    """The library to preload; `None` without a C compiler or off Linux."""
    compiler = shutil.which(os.environ.get("CC", "cc"))
    if compiler is None or not Path("/proc").exists():
        return None
    library = folder / "failing_calls.so"
    command = [compiler, "-O1", "-shared", "-fPIC", "-o", library, SOURCE, "-ldl"]
    subprocess.run(command, check=True)
    return library


@dataclass(frozen=True)
class Fault:
    """Which calls fail and how."""

    call: str
    first: int = 1
    last: int = NEVER
    how: str = "error"
    number: int = errno.ENOSPC
    percent: int = 100
    seed: int = 1
    more: dict = field(default_factory=dict)

    def __str__(self) -> str:
        last = "" if self.last == NEVER else f" to {self.last}"
        how = errno.errorcode[self.number] if self.how == "error" else self.how
        return f"{self.call} {self.first}{last}, {self.percent} % ({self.seed}): {how}"

    def environment(self, library: Path) -> dict[str, str]:
        """The environment of a process that meets the fault."""
        settings = {
            "LD_PRELOAD": library,
            "FAULT_CALL": self.call,
            "FAULT_FROM": self.first,
            "FAULT_UNTIL": self.last,
            "FAULT_HOW": self.how,
            "FAULT_ERRNO": self.number,
            "FAULT_PERCENT": self.percent,
            "FAULT_SEED": self.seed,
            **self.more,
        }
        return {**os.environ, **{key: str(value) for key, value in settings.items()}}


def counting(library: Path, file: Path) -> dict[str, str]:
    """The environment of a process that counts its calls and lets all of them pass."""
    return Fault("none", more={"FAULT_COUNTS": file}).environment(library)


def counts(file: Path) -> dict[str, int]:
    """The calls of a process."""
    lines = (line.split() for line in file.read_text().splitlines())
    return {name: int(count) for name, count in lines}


def draw(chance: Random, calls: dict[str, int]) -> Fault:
    """A fault that a command with so many calls meets: mostly of writes."""
    possible = [call for call in LOSES if calls[call] > 0]
    call = "write" if chance.random() < 0.7 else chance.choice(possible)
    number = chance.choice([errno.ENOSPC, errno.EIO])
    first = chance.randint(1, calls[call])
    if call != "write":
        last = chance.choice([first, NEVER])
        return Fault(call, first, last, number=number)
    kind = chance.randrange(6)
    if kind == 0:
        return Fault(call, first, number=number)
    if kind == 1:
        seed = chance.randrange(1, 1 << 30)
        percent = chance.choice([1, 3, 10, 30])
        return Fault(call, percent=percent, seed=seed, number=number)
    if kind == 2:
        return Fault(call, first, first, how="short")
    if kind == 3:
        return Fault(call, first, first, how="lose")
    return Fault(call, first, first, number=number)
