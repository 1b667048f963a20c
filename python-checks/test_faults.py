"""The fault tests in short; docs/validation/robustness.md has the long ones."""

import subprocess
import sys
from pathlib import Path

import pytest

from digest import renew_digest
from faults import bad_files, environment, kills, writes
from faults.mutations import fit_digests
from faults.program import Program
from faults.table import Row, Verdict, print_table

KILLED = ["mesh", "solve, with checkpoints", "run, old file"]


@pytest.fixture(scope="module")
def tested(program) -> Program:
    """The program as the fault tests run it."""
    return Program(program.resolve())


def wrong(rows: list[Row]) -> list[str]:
    """Everything wrong in a table."""
    return [f"{row.case}: {problem}" for row in rows for problem in row.wrong]


def test_killed_commands_go_on(tested, tmp_path):
    rows = list(kills.run(tested, tmp_path, count=9, seed=2, only=KILLED))
    assert sum(row.tried for row in rows) >= 15
    assert wrong(rows) == []


def test_hostile_surroundings(tested, tmp_path):
    rows = list(environment.run(tested, tmp_path, seed=2, trials=2))
    assert wrong(rows) == []
    assert sum(row.refused for row in rows) > 0


def test_failing_writes(tested, tmp_path):
    only = ["run, old file", "solve", "report", "export fclib-global"]
    rows = list(writes.run(tested, tmp_path, count=16, seed=2, only=only))
    assert wrong(rows) == []


def test_no_write_is_lost_unseen(tested, tmp_path):
    only = ["export fclib", "export vtkhdf", "export fclib-global"]
    rows = list(writes.lost_one_by_one(tested, tmp_path, only))
    assert wrong(rows) == []
    assert all(row.refused > row.tried / 2 for row in rows)


def test_campaigns_say_what_to_install():
    """Without their packages, as in a fresh Python."""
    folder = Path(__file__).parent
    for name in ("convex", "faults", "floating", "paths", "trust"):
        bare = [sys.executable, "-S", "-m", name]
        ended = subprocess.run(bare, cwd=folder, capture_output=True, text=True, check=False)
        assert ended.returncode == 2 and "requirements.txt" in ended.stderr, ended.stderr


def test_bad_files(tested, tmp_path):
    limits = {"flips": 24, "truncate_every": 1 << 17, "seed": 2, "alter_every": 40}
    # Every fifth of 56 links: each stage, and each of the eight targets with and without its name.
    rows = list(bad_files.run(tested, tmp_path, **limits, link_every=5))
    assert wrong(rows) == []
    assert all(row.tried > 0 for row in rows)


def test_wrong_answers_are_seen(tested, tmp_path):
    """A result altered with all its digests made to fit is distinguished from the true one."""
    bench = bad_files.Bench.of(tested, tmp_path, workers=1)

    def forge(path):
        with bad_files.editable(path) as file:
            file["post/resultants/strain_energy"][...] = 1.0
            fit_digests(file)
        renew_digest(path)

    row = Row("forged")
    bench.judge(lambda _: row, [("energy", forge)])
    assert any("status gave a wrong answer" in problem for problem in row.wrong)


def test_tables_say_what_is_wrong(capsys):
    row = Row("a fault")
    row.count(Verdict.WENT_ON)
    row.count(Verdict.REFUSED)
    assert print_table([row]) == 0
    row.count("it crashed")
    assert print_table([row]) == 1
    assert "| a fault | 3 | 1 | 1 | 1 |" in capsys.readouterr().out
