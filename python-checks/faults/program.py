"""Running the program and judging what it did."""

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
SECONDS = 120
"""A command that takes longer hangs; the scenes here take less than one second."""
ADDRESS_SPACE = 4 << 30
"""No command on the small files here needs a tenth of this; a huge size must not get it."""
BAD_INPUT = 2
INCOMPLETE = 1


@dataclass(frozen=True)
class Outcome:
    """How a command ended."""

    command: str
    code: int | None
    stdout: str
    stderr: str

    @property
    def fault(self) -> str | None:
        """A crash or a hang, in words; `None` if the program ended as it should."""
        if self.code is None:
            return f"{self.command} hung"
        if self.code < 0:
            return f"{self.command} died of {signal.Signals(-self.code).name}"
        if self.code not in (0, INCOMPLETE, BAD_INPUT):
            return f"{self.command} ended with {self.code}: {self.stderr[-300:]!r}"
        if self.code == BAD_INPUT and "error:" not in self.stderr:
            return f"{self.command} refused without a message"
        return None

    @property
    def json(self) -> dict:
        """What it printed for programs."""
        return json.loads(self.stdout)


@dataclass(frozen=True)
class Program:
    """The program under test."""

    path: Path

    @classmethod
    def find(cls, given: Path | None = None) -> "Program":
        """The given one, CONTACT3D_PIPE, or target/release/contact3d-pipe."""
        default = ROOT / "target" / "release" / "contact3d-pipe"
        path = Path(given or os.environ.get("CONTACT3D_PIPE", default)).resolve()
        if not path.is_file():
            print(
                f"error: no program at {path}; run `cargo build --release`, or give --program",
                file=sys.stderr,
            )
            raise SystemExit(BAD_INPUT)
        return cls(path)

    def start(
        self, *arguments, limit: Callable[[], None] | None = None, **options
    ) -> subprocess.Popen:
        """Start a command on one thread; its messages are kept unless said otherwise."""
        command = [str(self.path), "--quiet", "--threads", "1", *map(str, arguments)]
        options.setdefault("stdout", subprocess.PIPE)
        options.setdefault("stderr", subprocess.PIPE)
        limit = limit or limit_address_space
        return subprocess.Popen(command, text=True, preexec_fn=limit, **options)

    def run(self, *arguments, **options) -> Outcome:
        """Run a command to its end."""
        return finish(self.start(*arguments, **options), str(arguments[0]))

    def done(self, *arguments, **options) -> Outcome:
        """Run a command that must succeed."""
        outcome = self.run(*arguments, **options)
        if outcome.code != 0:
            raise RuntimeError(f"{arguments}: {outcome.code} {outcome.stderr}")
        return outcome


def finish(process: subprocess.Popen, name: str) -> Outcome:
    """Wait for a command, and end it if it hangs."""
    try:
        stdout, stderr = process.communicate(timeout=SECONDS)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return Outcome(name, None, "", "")
    return Outcome(name, process.returncode, stdout or "", stderr or "")


def limit_address_space() -> None:
    """A size that a file only declares must not become memory."""
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))


def settings(**changes) -> list[str]:
    """Command line arguments that change keys of a scene; `__` stands for a dot."""
    pairs = (f"{key.replace('__', '.')}={value}" for key, value in changes.items())
    return [part for pair in pairs for part in ("--set", pair)]


def fresh_copy(source: Path, target: Path) -> Path:
    """A folder with the contents of another, and nothing else."""
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(source, target)
    return target


def left_overs(folder: Path) -> list[str]:
    """Temporary files that nobody removed."""
    names = (path.name for path in folder.rglob("*"))
    return sorted(name for name in names if ".part" in name or ".previous" in name)
