"""A finished run file to start from, and commands that change it."""

import random
import shutil
from dataclasses import dataclass
from pathlib import Path

from faults.integrity import stage_digests
from faults.program import ROOT, Program, settings

SCENE = ROOT / "pipelines" / "hkl2011_table1.toml"
SMALL = settings(body__brick__cells="[12,4,4]", solve__epsilon=1e-6)
SMALLER = settings(body__brick__cells="[6,2,2]")
LOOSE = ("solve", "run.h5", *settings(solve__epsilon="1e-4"))
TIGHT = ("solve", "run.h5", *settings(solve__epsilon="1e-8"))
RUN = ("run", SCENE, "run.h5", "--no-figures", *SMALL)


@dataclass(frozen=True)
class Setting:
    """The program and a finished run file to start from."""

    program: Program
    scratch: Path
    good: Path
    chance: random.Random
    trials: int

    def fresh(self, folder: Path) -> Path:
        """The finished run file alone in a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for path in folder.iterdir():
            path.unlink() if path.is_file() else shutil.rmtree(path)
        return Path(shutil.copy(self.good, folder / "run.h5"))


def sound(file: Path) -> str | None:
    """What h5py finds wrong with a file."""
    try:
        stage_digests(file)
    except (OSError, ValueError, KeyError) as error:
        return f"{file.name}: {error!r}"
    return None
