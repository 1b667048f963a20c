"""The HTML report as a parser sees it: whole, self-contained, well-formed drawings."""

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import pytest

from conftest import ROOT

SCENE = ROOT / "pipelines" / "newton.toml"
SMALL = ["--set", "body.brick.cells=[12,4,4]"]
VOID = {"meta", "link", "br", "hr", "img", "input"}
SECTIONS = [
    "panels",
    "results",
    "stress",
    "discretisation-error",
    "details",
    "convergence",
    "certificate",
    "scene",
    "timings",
    "accuracy",
]


class Page(HTMLParser):
    """Ids, links and the nesting of a page."""

    def __init__(self, text: str):
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.sections: list[str] = []
        self.references: list[str] = []
        self.tags: set[str] = set()
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.handle_startendtag(tag, attrs)
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.add(tag)
        for name, value in attrs:
            if name == "id":
                self.ids.append(value)
                self.sections += [value] if tag == "section" else []
            if name in ("src", "href", "xlink:href", "action", "data", "srcset"):
                self.references.append(value)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, f"</{tag}> closes nothing"


def drawings(text: str) -> list[ElementTree.Element]:
    return [
        ElementTree.fromstring(svg)
        for svg in re.findall(r"<svg\b.*?</svg>", text, flags=re.DOTALL)
    ]


def hovers(svg: ElementTree.Element) -> list[str]:
    name = "{http://www.w3.org/2000/svg}title"
    return [title.text or "" for title in svg.iter(name)][1:]


def check_is_self_contained(text: str) -> Page:
    page = Page(text)
    assert all(link.startswith(("#", "data:")) for link in page.references)
    assert "script" not in page.tags and "@import" not in text
    assert all(u.startswith("url(#") for u in re.findall(r"url\([^)]*", text))
    assert len(page.ids) == len(set(page.ids))
    anchors = [link[1:] for link in page.references if link.startswith("#")]
    assert anchors == page.sections
    return page


@pytest.fixture(scope="module")
def report(contact3d, tmp_path_factory) -> str:
    """The report of a file with a run and both studies."""
    folder: Path = tmp_path_factory.mktemp("report")
    file, out = folder / "run.h5", folder / "report.html"
    contact3d("run", SCENE, file, "--no-figures", *SMALL)
    sizes = ["--coarsest", "2", "--finest", "8", "--budget", "20"]
    contact3d("accuracy", SCENE, file, "--no-figures", *SMALL, *sizes)
    contact3d("report", file, out)
    return out.read_text(encoding="utf-8")


def test_a_whole_file_has_every_section(report):
    page = check_is_self_contained(report)
    assert page.sections == SECTIONS
    assert "discretisation error is" in report


def test_every_drawing_is_well_formed_and_says_its_values(report):
    panels, stress, error, history, convergence, work = drawings(report)
    assert "von Mises [MPa]" in "".join(stress.itertext())
    assert "error per volume" in "".join(error.itertext())
    panes = [text for text in hovers(panels) if text.startswith("pane ")]
    # Twelve panes in maps (a), (b), (e), (f) and (d), where those in contact have an ellipse too.
    n_open = sum(", open" in text for text in panes)
    assert 0 < n_open < 12
    assert len(panes) == 12 * 6 - n_open
    assert all(re.match(r"step \d+: \d", text) for text in hovers(history))
    assert any(text.startswith("24 x 8 x 8 cells: ") for text in hovers(convergence))
    assert any("epsilon 1e-6: energy error" in text for text in hovers(work))


def test_a_file_without_a_part_has_no_section_of_it(contact3d, tmp_path):
    file, out = tmp_path / "mesh.h5", tmp_path / "report.html"
    contact3d("mesh", SCENE, file, *SMALL)
    contact3d("report", file, out)
    text = out.read_text(encoding="utf-8")
    assert check_is_self_contained(text).sections == ["scene", "timings"]
    assert "Results are left out: assemble is needed" in text


def test_a_sweep_becomes_a_table_and_charts(contact3d, tmp_path):
    sweep, out, page = tmp_path / "sweep.toml", tmp_path / "out", tmp_path / "page.html"
    sweep.write_text(
        f"""scene = "{SCENE}"
[[axis]]
key = "friction.coefficient_1.ramp.initial"
values = [0.3, 0.4]
[[axis]]
keys = ["title", "body.brick.cells"]
rows = [["<b>", [6, 2, 2]], ["x & y", [8, 2, 2]]]
"""
    )
    plan = json.loads(contact3d("sweep", "plan", sweep, out).stdout)
    assert len(plan) == 4
    for case in plan[:3]:
        contact3d("sweep", "run-case", sweep, out, case["id"])
    contact3d("sweep", "summary", sweep, out)
    contact3d("report", out, page)
    text = page.read_text(encoding="utf-8")
    parsed = check_is_self_contained(text)
    assert parsed.sections == ["charts", "summary"] and "b" not in parsed.tags
    assert "normal_force [N]" in text and "x &amp; y" in text and "missing" in text
    # Each chart has a point for each case that was run, on a line for each mesh.
    for chart in drawings(text):
        assert len(hovers(chart)) == 3
        assert any(hover.startswith("<b>") for hover in hovers(chart))
