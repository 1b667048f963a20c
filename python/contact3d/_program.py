"""Finding and running the program."""

import json
import os
import shutil
import subprocess
import sysconfig
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import _toml, _watch

NAME = "contact3d-pipe"


class ProgramNotFound(FileNotFoundError):
    """There is no program to run."""


class ProgramError(RuntimeError):
    """The program ended with an exit code other than 0; the text is its message."""

    def __init__(self, message: str, exit_code: int, file: Path | None = None, result: Any = None):
        super().__init__(message)
        self.exit_code = exit_code
        self.file = file
        self.result = result

    def __reduce__(self) -> tuple[Any, ...]:
        """Executors send errors from one process to another."""
        return type(self), (str(self), self.exit_code, self.file, self.result)


class NotConverged(ProgramError):
    """Exit code 1: not converged, or no equilibrium; what was computed is in ``file``, that of a study also in ``result``."""


class BadInput(ProgramError, ValueError):
    """Exit code 2: a scene or file that cannot be used; nothing on disk has changed."""


class InternalError(ProgramError):
    """Exit code 3, or a signal: a defect of the program."""


class Interrupted(ProgramError):
    """Exit code 130: interrupted; what had been stored is kept."""


ERRORS = {1: NotConverged, 2: BadInput, 130: Interrupted}


@dataclass(frozen=True)
class CompletedCommand:
    """What the program printed: its JSON, its exit code, its message."""

    data: Any
    exit_code: int
    message: str

    def check(self, file: Path | None = None, result: Any = None) -> None:
        """Raises the error that an exit code stands for."""
        if self.exit_code != 0:
            error = ERRORS.get(self.exit_code, InternalError)
            message = self.message or f"{NAME} ended with exit code {self.exit_code} and no message"
            raise error(message, self.exit_code, file, result)


def program() -> Path:
    """The program: ``$CONTACT3D_PIPE``, else the one installed beside this package, else the one on the PATH."""
    named = os.environ.get("CONTACT3D_PIPE")
    if named:
        return Path(named)
    suffix = ".exe" if os.name == "nt" else ""
    schemes = [sysconfig.get_default_scheme(), f"{os.name}_user"]
    folders = [sysconfig.get_path("scripts", scheme) for scheme in schemes if scheme in sysconfig.get_scheme_names()]
    for folder in folders:
        candidate = Path(folder) / f"{NAME}{suffix}"
        if candidate.is_file():
            return candidate
    found = shutil.which(NAME)
    if found is None:
        raise ProgramNotFound(f"{NAME} is neither beside this package nor on the PATH; name it in $CONTACT3D_PIPE")
    return Path(found)


def version() -> str:
    """The version of the program."""
    completed = subprocess.run([_found(), "--version"], capture_output=True, text=True, check=True)
    return completed.stdout.split()[1]


def perform(command: Sequence[str], *, text: str | None = None, total: int | None = None,
            progress: bool | None = False) -> CompletedCommand:
    """Runs a command with some standard input; its warnings become Python's, its progress a bar."""
    executable = _found()
    environment = {**os.environ, "NO_COLOR": "1"}
    with (tempfile.TemporaryFile() as given, tempfile.TemporaryFile() as results,
          _watch.bar(command[0], total, progress) as shown):
        given.write((text or "").encode())
        given.seek(0)
        watcher = _watch.Watcher(shown)
        ours, theirs = _watch.listening_post(shown is not None)
        try:
            exit_code = _watch.follow([executable, *command, "--json", "--verbose"], ours, watcher, errors=theirs, stdin=given,
                                      stdout=results, env=environment)
        finally:
            os.close(ours)
        results.seek(0)
        printed = results.read()
    _watch.warn(watcher.warnings)
    message = "\n".join(watcher.messages).strip().replace("/dev/stdin", "the scene")
    return CompletedCommand(json.loads(printed) if printed.strip() else None, exit_code, message)


def _found() -> Path:
    executable = shutil.which(program())
    if executable is None:
        raise ProgramNotFound(f"$CONTACT3D_PIPE names {program()}, which is no program that can be run")
    return Path(executable)


def name(path: str | os.PathLike[str]) -> str:
    """A path as an argument, which no option looks like."""
    plain = os.fspath(path)
    return os.path.join(os.curdir, plain) if plain.startswith("-") else plain


def options(**given: Any) -> list[str]:
    """Options of the command line: None and False are left out, a list repeats its option."""
    found = []
    for option, value in given.items():
        flag = "--" + option.replace("_", "-")
        for item in value if isinstance(value, (list, tuple)) else [value]:
            if item is True:
                found.append(flag)
            elif item is not None and item is not False:
                found.append(f"{flag}={os.fspath(item) if isinstance(item, os.PathLike) else item}")
    return found


def pictures(folder: str | os.PathLike[str] | None) -> list[str]:
    """Where pictures go; nowhere if no folder is named."""
    return ["--no-figures"] if folder is None else ["--figures", name(folder)]


def settings(changes: Mapping[str, Any] | None) -> list[str]:
    """Changes of keys as options."""
    return [f"--set={key}={_toml.value(item)}" for key, item in (changes or {}).items()]
