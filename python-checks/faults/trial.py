"""A command in a folder of its own: what was there before, and what it leaves without faults."""

import time
from dataclasses import dataclass
from pathlib import Path

from faults.program import Outcome, Program, fresh_copy, left_overs


@dataclass(frozen=True)
class Case:
    """A command and the commands that make the folder it starts from."""

    name: str
    command: tuple
    before: tuple[tuple, ...] = ()
    share: int = 4
    """Of the trials, beside other cases."""


@dataclass
class Trial:
    """One case with its undisturbed course."""

    program: Program
    case: Case
    scratch: Path
    states: tuple[dict, dict] = ({}, {})
    seconds: float = 0.0
    """Of the undisturbed course."""

    def state(self, folder: Path) -> dict[str, str]:
        """What the files of a folder hold that does not depend on the clock."""
        raise NotImplementedError

    @property
    def start(self) -> Path:
        """The folder before the command."""
        return self.scratch / "start"

    @property
    def work(self) -> Path:
        """Where the command is disturbed."""
        return self.scratch / "work"

    def prepare(self, sweep: str, env: dict[str, str] | None = None) -> None:
        """Make the folder before the command, and run it once undisturbed."""
        self.start.mkdir(parents=True)
        (self.start / "sweep.toml").write_text(sweep)
        for command in self.case.before:
            self.program.done(*command, cwd=self.start)
        fresh_copy(self.start, self.work)
        begun = time.monotonic()
        self.program.done(*self.case.command, cwd=self.work, env=env)
        self.seconds = time.monotonic() - begun
        self.states = (self.state(self.start), self.state(self.work))

    def again(self) -> Outcome:
        """Give the command again."""
        return self.program.run(*self.case.command, cwd=self.work)

    def problem_after(self) -> str | None:
        """What is wrong once the command was given again, and nothing disturbs it."""
        again = self.again()
        if again.code != 0:
            return f"did not go on: {again.fault or again.stderr}"
        if self.state(self.work) != self.states[1]:
            return "went on to another result"
        if left_overs(self.work):
            return f"left {left_overs(self.work)} for good"
        return None
