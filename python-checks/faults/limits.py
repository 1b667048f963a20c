"""Little of something: descriptors, file size, memory, stack; wrong clocks."""

import resource
from collections.abc import Iterator
from pathlib import Path

from faults.failing_calls import Fault, build
from faults.program import Outcome, left_overs
from faults.setting import RUN, Setting, sound
from faults.table import Row, Verdict

FILES = (4, 5, 6, 7, 8, 9)
FILE_SIZES = (0, 1 << 12, 1 << 16, 1 << 18)
ADDRESS_SPACES = tuple(megabytes << 20 for megabytes in range(16, 64, 3))
STACKS = tuple(kilobytes << 10 for kilobytes in (48, 64, 80, 96, 112, 128, 256))
VARIABLES = (
    {"HDF5_DRIVER": "bogus"},
    {"HDF5_VOL_CONNECTOR": "bogus"},
    {"HDF5_DRIVER": "family"},
)
CLOCKS = (-1000, 1 << 40)


def run(setting: Setting) -> Iterator[Row]:
    """Each limit on its own."""
    yield limited(setting, "open files", resource.RLIMIT_NOFILE, FILES)
    yield limited(setting, "file size", resource.RLIMIT_FSIZE, FILE_SIZES)
    # Here the system itself may end a process; it must only never claim to have succeeded.
    yield limited(setting, "address space", resource.RLIMIT_AS, ADDRESS_SPACES, dies=True)
    yield limited(setting, "stack", resource.RLIMIT_STACK, STACKS, dies=True)
    yield from wrong_environments(setting)


def limited(
    setting: Setting, name: str, what: int, sizes: tuple, dies: bool = False
) -> Row:
    """A run under a limit that the program survives where it has nothing to do."""
    row = Row(f"little {name}")
    for size in sizes[:: max(1, len(sizes) // setting.trials)]:

        def limit(size: int = size) -> None:
            resource.setrlimit(what, (size, size))

        if setting.program.run("--version", limit=limit).code == 0:
            row.count(judged(setting, f"{name} {size}", dies, limit=limit))
    return row


def wrong_environments(setting: Setting) -> Iterator[Row]:
    """Variables that change how HDF5 opens files, clocks outside 1970 to 9999."""
    row = Row("foreign means of opening files")
    for variables in VARIABLES:
        fault = Fault("none", more=variables)
        row.count(judged(setting, str(variables), env=fault.environment("")))
    yield row
    library = build(setting.scratch)
    row = Row("wrong clock", note="needs a C compiler and Linux")
    for clock in CLOCKS if library else ():
        fault = Fault("none", more={"FAULT_CLOCK": clock})
        row.count(judged(setting, f"clock {clock}", env=fault.environment(library)))
    yield row


def judged(
    setting: Setting, name: str, dies: bool = False, **options
) -> Verdict | str:
    """A run over an old file: a success, or an end with a message and the file as it was."""
    folder = setting.scratch / "limits"
    file = setting.fresh(folder)
    before = file.read_bytes()
    command = (*RUN, "--set", "solve.epsilon=1e-5")
    outcome = setting.program.run(*command, cwd=folder, **options)
    problem = problem_of(outcome, file, before, dies)
    if problem:
        return f"{name}: {problem}"
    return Verdict.WENT_ON if outcome.code == 0 else Verdict.REFUSED


def problem_of(outcome: Outcome, file: Path, before: bytes, dies: bool) -> str | None:
    """What is wrong with an end."""
    if outcome.code == 0:
        return sound(file)
    if outcome.code is None or (outcome.fault and not dies):
        return outcome.fault
    if file.read_bytes() != before:
        return f"ended with {outcome.code} and changed the file"
    if outcome.code > 0 and left_overs(file.parent):
        return f"left {left_overs(file.parent)}"
    return None
