"""Texts that come whole or not at all."""

import os
import secrets
import stat
from pathlib import Path


def write_whole(file: Path, text: str) -> None:
    """Writes a text under a hidden name beside its place, and renames it."""
    part = file.with_name(f".{file.name}.part-{secrets.token_hex(4)}")
    try:
        with part.open("x", encoding="utf-8") as opened:
            opened.write(text)
            opened.flush()
            os.fsync(opened.fileno())
        if file.exists():
            part.chmod(stat.S_IMODE(file.stat().st_mode))
        part.replace(file)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
