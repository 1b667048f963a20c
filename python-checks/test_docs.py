"""Every link of a page leads somewhere, and every page and picture of docs is linked from README.md on."""

import re
from pathlib import Path
from urllib.parse import unquote

from conftest import ROOT

LINK = re.compile(r"\]\(([^()\s]+(?:\([^()\s]*\))?)\)")
CODE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)


def pages() -> list[Path]:
    """The front pages, those of docs and of the benchmarks."""
    return sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *ROOT.glob("benches/**/README.md")])


def text(page: Path) -> str:
    """A page without its blocks of code."""
    return CODE.sub("", page.read_text())


def anchors(page: Path) -> set[str]:
    """What headings are called in links: small letters, hyphens for spaces, no other punctuation."""
    headings = re.findall(r"^#+ (.*)$", text(page), re.MULTILINE)
    plain = (re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading) for heading in headings)
    return {re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-") for heading in plain}


def targets(page: Path) -> list[tuple[Path, str]]:
    """Files and headings that a page links to; other sites are not visited."""
    links = [link for link in LINK.findall(text(page)) if not re.match(r"\w+:", link)]
    parts = (unquote(link).partition("#") for link in links)
    return [((page.parent / path).resolve() if path else page, anchor) for path, _, anchor in parts]


def test_every_link_leads_somewhere():
    broken = [
        f"{page.relative_to(ROOT)}: {target}#{anchor}"
        for page in pages()
        for target, anchor in targets(page)
        if not target.exists() or (anchor and target.suffix == ".md" and anchor not in anchors(target))
    ]
    assert not broken, "\n".join(broken)


def test_no_page_or_picture_is_an_orphan():
    reached, ahead = set(), [ROOT / "README.md"]
    while ahead:
        page = ahead.pop()
        found = {target for target, _ in targets(page) if target.is_file()} - reached
        reached |= found
        ahead += [target for target in found if target.suffix == ".md"]
    docs = {path for path in (ROOT / "docs").rglob("*") if path.suffix in {".md", ".png", ".svg"}}
    assert len(docs) > 30, "the folder was searched"
    orphans = sorted(str(path.relative_to(ROOT)) for path in docs - reached)
    assert not orphans, orphans
