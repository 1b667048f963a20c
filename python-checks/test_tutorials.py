"""Every block of README.md and docs/tutorials: files are written, commands and Python are run, and print what the page says."""

import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import pytest

from conftest import ROOT

TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("*.md"))
PAGES = [ROOT / "README.md", *TUTORIALS]
BLOCK = re.compile(r"(<!-- not run: [^\n]+ -->\n)?```(\w*)\n(.*?)```", re.DOTALL)
NUMBER = re.compile(r"\d+\.\d+(?:e[+-]?\d+)?")


@dataclass
class Block:
    """What a page has between fences, and what it says is printed."""

    language: str
    text: str
    printed: str | None


def blocks_of(page: str) -> list[Block]:
    """The blocks to run; one without a language is the output of the block before, wherever that is run."""
    blocks, run = [], False
    for skipped, language, text in BLOCK.findall(page):
        if language:
            run = not skipped
            if run:
                blocks.append(Block(language, text, None))
        elif run:
            blocks[-1].printed = text
    return blocks


def assert_printed(said: str, shown: str) -> None:
    """Lines are equal in turn; a line `…` stands for any lines, `…` at the end of a line for its rest."""
    lines = iter(shown.splitlines())
    anything = False
    for expected in said.splitlines():
        if expected.strip() == "…":
            anything = True
            continue
        found = next((line for line in lines if not anything or same(expected, line)), None)
        assert found is not None and same(expected, found), f"the page says {expected!r}, printed is {found!r}"
        anything = False
    assert anything or next(lines, None) is None, "more is printed than the page says"


def same(expected: str, line: str) -> bool:
    """Whether a line is the expected one."""
    if expected.endswith("…"):
        expected = expected[:-1]
        line = line[: len(expected)]
    said, shown = NUMBER.findall(expected), NUMBER.findall(line)
    return NUMBER.split(expected) == NUMBER.split(line) and all(map(equal, said, shown))


def equal(said: str, shown: str) -> bool:
    """Whether two numbers differ by a last digit at most, or by a relative 1e-12: another processor rounds otherwise."""
    digits, _, exponent = said.partition("e")
    last_digit = 10.0 ** (int(exponent or 0) - len(digits.partition(".")[2]))
    # 1.001: the last digit itself as a difference of two decimal numbers.
    return abs(float(said) - float(shown)) <= max(1.001 * last_digit, 1e-12 * abs(float(said)))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_page_does_what_it_says(page, program, tmp_path, monkeypatch, capsys):
    """In an empty folder that has the `pipelines` of the clone beside it."""
    matplotlib.use("Agg")
    folder, bin = tmp_path / "work", tmp_path / "bin"
    folder.mkdir()
    bin.mkdir()
    (bin / "contact3d-pipe").symlink_to(program.resolve())
    (folder / "pipelines").symlink_to(ROOT / "pipelines")
    monkeypatch.chdir(folder)
    monkeypatch.setenv("PATH", f"{bin}:{os.environ['PATH']}")
    monkeypatch.setenv("CONTACT3D_PIPE", str(program.resolve()))
    monkeypatch.syspath_prepend(str(ROOT / "python"))
    names: dict = {}
    for block in blocks_of(page.read_text()):
        if block.language == "toml":
            name = re.match(r"# (\S+\.toml)\b", block.text)
            assert name, f"a scene without its name: {block.text}"
            Path(name[1]).write_text(block.text)
            continue
        if block.language == "sh":
            run = subprocess.run(["sh", "-e", "-c", block.text], capture_output=True, text=True, check=False)
            assert run.returncode == 0, f"{block.text}: {run.stderr}"
            shown = run.stdout
        else:
            assert block.language == "python", f"no way to run {block.language!r}"
            exec(compile(block.text, page.name, "exec"), names)
            shown = capsys.readouterr().out
        if block.printed is not None:
            assert_printed(block.printed, shown)


def test_the_demo_ends_with_solutions_to_rounding(program, tmp_path):
    command = [sys.executable, ROOT / "pipelines" / "hkl2011_demo.py", tmp_path, "--n-div", "4"]
    environment = os.environ | {"CONTACT3D_PIPE": str(program.resolve())}
    run = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    assert (tmp_path / "table1-figures" / "overview.png").exists()
    first_screen, table = run.stdout.split("\n\n")
    assert "converged" in first_screen
    rows = [line.split() for line in table.splitlines()[2:-1]]
    assert [row[-2:] for row in rows[:2]] == [["6", "779"], ["11", "66"]], "as published"
    errors = [float(row[-2]) for row in rows[2:]]
    # The paper's method stops when multipliers change by 1e-4; their error is larger by what its steps still have to go.
    assert len(errors) == 4 and all(1e-4 < error < 0.1 for error in errors[:2]), table
    assert all(error < 1e-11 for error in errors[2:]), table


def test_the_drawing_is_that_of_the_clone():
    drawing = (ROOT / "pipelines" / "meshes" / "foot.geo").read_text()
    assert drawing in (ROOT / "docs" / "tutorials" / "gmsh_part.md").read_text()


def test_every_page_runs_something():
    assert len(TUTORIALS) >= 4
    for page in PAGES:
        languages = [block.language for block in blocks_of(page.read_text())]
        assert {"toml", "sh", "python"} <= set(languages), f"{page.name} runs only {languages}"


@pytest.mark.parametrize(
    "said, shown",
    [
        ("force 1.5e7 N\n", "force 1.7e7 N\n"),
        ("force 52997546.768639915\n", "force 52997546.768739915\n"),
        ("a\nb\n", "a\n"),
        ("a\n", "a\nb\n"),
        ("a\n…\nb\n", "a\nc\n"),
        ("slip 10\n", "slip 11\n"),
        ("moved by …\n", "moves by 1.0\n"),
    ],
)
def test_what_differs_is_seen(said, shown):
    with pytest.raises(AssertionError):
        assert_printed(said, shown)


def test_what_may_differ_passes():
    assert_printed("…\nforce 1.5e7 N\nmoved by …\n…\n", "title\nforce 1.6e7 N\nmoved by 3e-17\nrest\n")
