"""Every link of a page leads somewhere, every page and picture of docs and gallery is linked from README.md on, and the gallery has all scenes."""

import re
import sys
from pathlib import Path

from conftest import ROOT

sys.path.insert(0, str(ROOT / "scripts"))
from docs_site import reached, targets, text


def pages() -> list[Path]:
    """The front pages, those of docs and of the benchmarks."""
    return sorted([*ROOT.glob("*.md"), ROOT / "pipelines/README.md", *(ROOT / "docs").rglob("*.md"), *ROOT.glob("benches/**/README.md")])


def anchors(page: Path) -> set[str]:
    """What headings are called in links: small letters, hyphens for spaces, no other punctuation."""
    headings = re.findall(r"^#+ (.*)$", text(page), re.MULTILINE)
    plain = (re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading) for heading in headings)
    return {re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-") for heading in plain}


def test_every_link_leads_somewhere():
    broken = [
        f"{page.relative_to(ROOT)}: {target}#{anchor}"
        for page in pages()
        for target, anchor in targets(page)
        if not target.exists() or (anchor and target.suffix == ".md" and anchor not in anchors(target))
    ]
    assert not broken, "\n".join(broken)


def test_no_page_or_picture_is_an_orphan():
    folders = [ROOT / "docs", ROOT / "pipelines" / "gallery"]
    files = (path for folder in folders for path in folder.rglob("*"))
    docs = {path for path in files if path.suffix in {".md", ".png", ".svg"}}
    assert len(docs) > 30, "the folder was searched"
    orphans = sorted(str(path.relative_to(ROOT)) for path in docs - set(reached()))
    assert not orphans, orphans


def test_the_gallery_says_of_every_scene_what_it_says_itself():
    page = (ROOT / "pipelines" / "README.md").read_text()
    scenes = sorted((ROOT / "pipelines").glob("*.toml"))
    assert len(scenes) > 45
    for scene in scenes:
        shows, expect = (line.partition(": ")[2].rstrip(".") for line in scene.read_text().splitlines()[:2])
        assert f"[{scene.stem}]({scene.name})" in page, f"python3 scripts/gallery.py {scene.stem}"
        assert shows in page and expect in page, f"python3 scripts/gallery.py {scene.stem}"
