#!/usr/bin/env python3
"""Puts README.md and every page and file that it leads to into one searchable site, which needs no network.

    sh scripts/site.sh                       # installs the generator, and makes target/site
    python3 scripts/docs_site.py FOLDER      # with Sphinx and myst-parser installed
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
project = "contact3d-pipe"
extensions = ["myst_parser"]
myst_heading_anchors = 6
html_theme_options = {"page_width": "1100px", "sidebar_width": "260px"}
html_copy_source = False
# Notebooks and sources are files to load, not pages.
exclude_patterns = ["**.ipynb"]
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
    """The first page: README.md, and the menu of all pages in their folders."""
    front = {"docs/index.md": "Documentation", "pipelines/README.md": "Gallery"}
    left = [page for page in pages if page not in front and page != "README.md"]
    groups = {"Start": [f"{title} <{page}>" for page, title in front.items()]}
    for folder, title in FOLDERS.items():
        groups[title] = [page for page in left if page.startswith(folder)]
        left = [page for page in left if page not in groups[title]]
    trees = [f"```{{toctree}}\n:hidden:\n:caption: {title}\n\n" + "\n".join(inside) + "\n```" for title, inside in groups.items()]
    return "\n\n".join(["```{include} README.md\n```", *trees]) + "\n"


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} FOLDER")
    files = [file.relative_to(ROOT) for file in reached()]
    with tempfile.TemporaryDirectory() as scratch:
        for file in files:
            copy = Path(scratch, "pages", file)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / file, copy)
        pages = [str(file) for file in files if file.suffix == ".md"]
        Path(scratch, "pages", "index.md").write_text(menu(pages))
        Path(scratch, "pages", "conf.py").write_text(CONFIGURATION)
        command = ["sphinx-build", "--quiet", "--fail-on-warning", "--keep-going", "-E", Path(scratch, "pages")]
        subprocess.run([*command, Path(sys.argv[1])], check=True)


if __name__ == "__main__":
    main()
