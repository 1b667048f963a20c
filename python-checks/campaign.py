"""What the campaigns share: packages that must be there, and arguments. Imports nothing that may be missing."""

import argparse
import sys
from importlib.util import find_spec
from pathlib import Path

BAD_INPUT = 2


def require(*packages: str) -> None:
    """End with what to install where a package is missing."""
    missing = [package for package in packages if find_spec(package) is None]
    if missing:
        listed = Path(__file__).resolve().with_name("requirements.txt")
        names = ", ".join(missing)
        print(
            f"error: {names} not found; run `{sys.executable} -m pip install -r {listed}`",
            file=sys.stderr,
        )
        raise SystemExit(BAD_INPUT)


def arguments(name: str, description: str | None) -> argparse.ArgumentParser:
    """The arguments that all campaigns have."""
    parser = argparse.ArgumentParser(prog=name, description=description)
    parser.add_argument("--seed", type=int, default=1, help="of all that is random")
    parser.add_argument("--program", type=Path, help="target/release/contact3d-pipe")
    return parser
