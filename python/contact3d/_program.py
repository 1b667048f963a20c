"""Finding and running the program."""

import os
import shutil
import subprocess
import sysconfig
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import xarray as xr

from . import _toml
from ._tree import open as open_run

NAME = "contact3d-pipe"


class ProgramNotFound(FileNotFoundError):
    """There is no program to run."""


class ProgramError(RuntimeError):
    """The program ended with an exit code other than 0; the text is its message."""

    def __init__(self, message: str, exit_code: int, file: Path):
        super().__init__(message)
        self.exit_code = exit_code
        self.file = file


class NotConverged(ProgramError):
    """Exit code 1: not converged, or no equilibrium; what was computed is in ``file``."""


class BadInput(ProgramError, ValueError):
    """Exit code 2: a scene or file that cannot be used; nothing on disk has changed."""


class InternalError(ProgramError):
    """Exit code 3, or a signal: a defect of the program."""


class Interrupted(ProgramError):
    """Exit code 130: interrupted; what had been stored is kept."""


ERRORS = {1: NotConverged, 2: BadInput, 130: Interrupted}


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
    answer = subprocess.run([program(), "--version"], capture_output=True, text=True, check=True)
    return answer.stdout.split()[1]


def run(
    scene: str | os.PathLike[str] | Mapping[str, Any],
    file: str | os.PathLike[str],
    *,
    set: Mapping[str, Any] | None = None,
    figures: str | os.PathLike[str] | None = None,
    threads: int | None = None,
) -> xr.DataTree:
    """Solves a scene, or what of it is not up to date in ``file``, and opens the run file.

    :param scene: the path of a scene, its text (of more than one line), or a dict as ``tomllib`` makes it. Mesh files
        are looked for beside a scene with a path, else in the working directory.
    :param file: the run file, made or brought up to date.
    :param set: keys of the scene to change, such as ``{"friction.coefficient.constant": 0.4}``.
    :param figures: a folder for the pictures; none are drawn without it.
    :param threads: the processors that may compute; all by default. The results do not depend on it.
    :raises NotConverged, BadInput, InternalError, Interrupted: with the program's message.
    """
    file = Path(file)
    path, text, changes = _given(scene)
    command = [str(program()), "run", path, _name(file), "--quiet"]
    command += ["--no-figures"] if figures is None else ["--figures", _name(figures)]
    command += [] if threads is None else ["--threads", str(threads)]
    command += [f"--set={name}={_toml.value(item)}" for name, item in {**changes, **(set or {})}.items()]
    _perform(command, file, text)
    return open_run(file)


def export(
    file: str | os.PathLike[str],
    *,
    vtkhdf: str | os.PathLike[str] | None = None,
    fclib: str | os.PathLike[str] | None = None,
    sparse: bool = False,
) -> None:
    """Writes a part of a solved run file for other programs.

    :param file: the run file, which stays as it is.
    :param vtkhdf: a file for PyVista and ParaView, whose readers go by the suffix: ``NAME.vtkhdf``.
    :param fclib: a file of the Friction Contact Library, for Siconos: u = W r + q, with the dense W.
    :param sparse: in place of that the global problem M v = H r + f with sparse matrices.
    :raises BadInput: a run file that is not solved, a law that such a file cannot hold.
    """
    given = {"--vtkhdf": vtkhdf, "--fclib": fclib}
    for option, target in given.items():
        if target is not None:
            command = [str(program()), "export", _name(file), option, _name(target), "--quiet"]
            _perform(command + (["--global"] if sparse and option == "--fclib" else []), Path(file))


def _name(path: str | os.PathLike[str]) -> str:
    """A path as an argument, which no option looks like."""
    name = os.fspath(path)
    return os.path.join(os.curdir, name) if name.startswith("-") else name


def _perform(command: list[str], file: Path, text: str | None = None) -> None:
    """Runs a command that works on a file, with some standard input; errors as exceptions."""
    environment = {**os.environ, "NO_COLOR": "1"}
    answer = subprocess.run(command, input=text, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                            encoding="utf-8", env=environment)
    if answer.returncode != 0:
        error = ERRORS.get(answer.returncode, InternalError)
        message = answer.stderr.strip() or f"{NAME} ended with exit code {answer.returncode} and no message"
        raise error(message, answer.returncode, file)


def _given(scene: str | os.PathLike[str] | Mapping[str, Any]) -> tuple[str, str | None, dict[str, Any]]:
    """The path to give to the program, its standard input, and the keys that differ."""
    if isinstance(scene, Mapping):
        content, text = scene, _toml.document(scene)
    elif isinstance(scene, str) and "\n" in scene:
        text = scene
        try:
            content = tomllib.loads(scene)
        except tomllib.TOMLDecodeError:
            content = {}
    else:
        return _name(scene), None, {}
    body = content.get("body")
    mesh = body.get("gmsh") if isinstance(body, Mapping) else None
    changes = {}
    if isinstance(mesh, Mapping) and isinstance(mesh.get("file"), (str, os.PathLike)):
        changes["body.gmsh.file"] = str(Path(mesh["file"]).absolute())
    return "/dev/stdin", text, changes
