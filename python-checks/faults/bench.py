"""A good file, and the judgement of every command on damaged copies of it."""

import shutil
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from faults.commands import COMMANDS, Answer, Commands
from faults.mutations import Unfit
from faults.program import ROOT, Program, settings
from faults.table import Row, Verdict

SCENE = ROOT / "pipelines" / "hkl2011_table1.toml"
SMALL = settings(body__brick__cells="[6,2,2]", assemble__dual_operator='"explicit"')
Damage = Callable[[Path], None]


@dataclass
class Bench:
    """A good file and a few folders to judge damaged ones in, side by side."""

    scratch: Path
    good: Path
    commands: list[Commands]

    @classmethod
    def of(cls, program: Program, scratch: Path, workers: int = 2) -> "Bench":
        """Solve a small problem and take down what every command says of it."""
        good = scratch / "good.h5"
        program.done("run", SCENE, good, "--no-figures", *SMALL)
        shutil.copy(good, scratch / "outside.h5")
        folders = [scratch / f"worker{k}" for k in range(workers)]
        return cls(scratch, good, Commands.side_by_side(program, folders, good))

    def judge(
        self,
        row_of: Callable[[str], Row],
        damages: Iterable[tuple[str, Damage]],
        answer: Callable[[str], Answer] | None = None,
        report_every: int = 1,
    ) -> None:
        """Damage copies of the good file and count what every command makes of them.

        `report`, which takes longer than the others and reads what `post` reads, has its turn
        with every `report_every`-th copy.
        """
        shares = [
            list(damages)[k :: len(self.commands)] for k in range(len(self.commands))
        ]
        work = zip(self.commands, shares, strict=True)

        def one_share(pair):
            commands, share = pair
            found = []
            for index, (name, damage) in enumerate(share):
                left_out = () if index % report_every == 0 else ("report",)
                expected = (answer or same)(name)
                found += judge_one(commands, name, damage, expected, left_out)
            return found

        with ThreadPoolExecutor(len(self.commands)) as pool:
            for found in pool.map(one_share, work):
                for command, verdict in found:
                    row_of(command).count(verdict)


def judge_one(
    commands: Commands, name: str, damage: Damage, answer: Answer, left_out: tuple = ()
) -> list[tuple[str, Verdict | str]]:
    """What every command makes of one damaged file."""
    damaged = commands.folder / "damaged.h5"
    shutil.copy(commands.good, damaged)
    try:
        damage(damaged)
    except Unfit:
        return []
    found = []
    for command, verdict in commands.judge(damaged, answer, left_out).items():
        is_wrong = isinstance(verdict, str)
        found.append((command, f"{name}: {verdict}" if is_wrong else verdict))
    return found


def same(_: str) -> Answer:
    """The file is not what was written: no answer of it may differ."""
    return Answer.SAME


def one_row(case: str) -> tuple[list[Row], Callable[[str], Row]]:
    """A single row for all commands."""
    row = Row(case)
    return [row], lambda command: row


def row_each(case: str) -> tuple[list[Row], Callable[[str], Row]]:
    """A row for every command."""
    rows = {command: Row(f"{case}, `{command}`") for command in COMMANDS}
    return list(rows.values()), rows.__getitem__
