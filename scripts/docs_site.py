#!/usr/bin/env python3
"""Puts README.md and every page and file that it leads to into one searchable site, which needs no network.

    sh scripts/site.sh                       # installs the generator, and makes target/site
    python3 scripts/docs_site.py FOLDER      # with mkdocs-material installed
"""

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from urllib.parse import unquote

ROOT = Path(__file__).resolve().parent.parent
LINK = re.compile(r"\]\(([^()\s]+(?:\([^()\s]*\))?)\)")
CODE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)

CONFIGURATION = """
site_name: contact3d-pipe
docs_dir: pages
use_directory_urls: false
theme:
  name: material
  font: false
  features: [navigation.top, search.highlight, toc.follow]
plugins: [search, offline]
markdown_extensions:
  - tables
  - toc:
      permalink: true
      slugify: !!python/object/apply:pymdownx.slugs.slugify {kwds: {case: lower}}
  - pymdownx.highlight
  - pymdownx.superfences
validation: {anchors: warn}
nav:
"""

# Folders of pages in the menu; pages stand in the order in which docs/index.md names them.
FOLDERS = {
    "docs/tutorials": "Tutorials",
    "docs/how_to": "How to",
    "docs/reference": "Reference",
    "docs/explanation": "Explanation",
    "docs/validation": "Validation",
    "": "Project",
}


def text(page: Path) -> str:
    """A page without its blocks of code."""
    return CODE.sub("", page.read_text())


def targets(page: Path) -> list[tuple[Path, str]]:
    """Files and headings that a page links to; other sites are not visited."""
    links = [link for link in LINK.findall(text(page)) if not re.match(r"\w+:", link)]
    parts = (unquote(link).partition("#") for link in links)
    return [((page.parent / path).resolve() if path else page, anchor) for path, _, anchor in parts]


def reached() -> list[Path]:
    """README.md, and the files that it leads to, each once."""
    found, ahead = {ROOT / "docs/index.md": None, ROOT / "README.md": None}, [ROOT / "docs/index.md", ROOT / "README.md"]
    while ahead:
        page = ahead.pop(0)
        new = dict.fromkeys(target for target, _ in targets(page) if target.is_file() and target not in found)
        found |= new
        ahead += [target for target in new if target.suffix == ".md"]
    return list(found)


def menu(pages: list[str]) -> str:
    """The menu: front pages, then folders."""
    front = {"README.md": "Home", "docs/index.md": "Documentation", "pipelines/README.md": "Gallery"}
    lines = [f"  - {title}: {page}" for page, title in front.items()]
    left = [page for page in pages if page not in front]
    for folder, title in FOLDERS.items():
        inside = [page for page in left if page.startswith(folder)]
        left = [page for page in left if page not in inside]
        lines += [f"  - {title}:", *(f"    - {page}" for page in inside)]
    return "\n".join(lines) + "\n"


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} FOLDER")
    files = [file.relative_to(ROOT) for file in reached()]
    with tempfile.TemporaryDirectory() as scratch:
        for file in files:
            copy = Path(scratch, "pages", file)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / file, copy)
        configuration = Path(scratch, "mkdocs.yml")
        configuration.write_text(CONFIGURATION + menu([str(file) for file in files if file.suffix == ".md"]))
        command = ["mkdocs", "build", "--quiet", "--strict", "--config-file", configuration]
        subprocess.run([*command, "--site-dir", Path(sys.argv[1]).resolve()], check=True)


if __name__ == "__main__":
    main()
