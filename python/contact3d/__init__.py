"""Static contact with friction in 3D: run the program ``contact3d-pipe`` and read what it stores.

    >>> import contact3d
    >>> block = contact3d.run("pipelines/newton.toml", "newton.h5", set={"body.brick.cells": [12, 4, 4]})
    >>> block                                    # a summary
    >>> block.plot("pressure")                   # the contact face
    >>> block["solve/multiplier_normal"]         # an xarray.DataArray with units, by panes

:func:`run` solves a scene, :func:`sweep` many, :func:`open` reads a run file. :mod:`contact3d.scene` has the classes of a
scene, :mod:`contact3d.convert` reads meshes of other programs, :mod:`contact3d.theory` measures the constants of the paper.
"""

from . import _studies
from ._matrices import Matrices
from ._program import BadInput, InternalError, Interrupted, NotConverged, ProgramError, ProgramNotFound, program, version
from ._run import Run
from ._studies import *
from ._sweep import Sweep, open_sweep, sweep
from ._sweep_table import SweepTable
from ._tree import open
from ._watch import CasesWarning, SceneWarning
from .scene import Scene

__all__ = [
    "BadInput",
    "CasesWarning",
    "InternalError",
    "Interrupted",
    "Matrices",
    "NotConverged",
    "ProgramError",
    "ProgramNotFound",
    "Run",
    "Scene",
    "SceneWarning",
    "Sweep",
    "SweepTable",
    "open",
    "open_sweep",
    "program",
    "sweep",
    "version",
]
__all__ += _studies.__all__
