"""Static contact with friction in 3D: run the program ``contact3d-pipe`` and read what it stores.

    >>> import contact3d
    >>> tree = contact3d.run("pipelines/newton.toml", "newton.h5", set={"body.brick.cells": [12, 4, 4]})
    >>> tree["solve/multiplier_normal"]          # an xarray.DataArray with units, by panes

:func:`run` solves a scene, :func:`open` reads a run file, :func:`open_sweep` the table of a sweep; :func:`export` writes for
PyVista, ParaView and Siconos.
"""

from ._program import (
    BadInput,
    InternalError,
    Interrupted,
    NotConverged,
    ProgramError,
    ProgramNotFound,
    export,
    program,
    run,
    version,
)
from ._sweep import open_sweep
from ._tree import Matrices, open

__all__ = [
    "BadInput",
    "InternalError",
    "Interrupted",
    "Matrices",
    "NotConverged",
    "ProgramError",
    "ProgramNotFound",
    "export",
    "open",
    "open_sweep",
    "program",
    "run",
    "version",
]
