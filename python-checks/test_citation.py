"""What papers cite agrees with the program."""

import json
import re
import tomllib

from conftest import ROOT

DOI = "10.1016/j.cam.2011.02.007"


def test_one_version_everywhere():
    version = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    citation = (ROOT / "CITATION.cff").read_text()
    assert re.search(r"^version: (.+)$", citation, re.MULTILINE).group(1) == version
    assert json.loads((ROOT / "codemeta.json").read_text())["version"] == version
    assert f"## {version}" in (ROOT / "CHANGELOG.md").read_text()


def test_reports_say_what_to_cite(contact3d, tight_path, tmp_path):
    contact3d("report", tight_path, tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert f"doi:{DOI}" in page.rsplit("<footer>", 1)[1]
    assert DOI in (ROOT / "CITATION.cff").read_text()
