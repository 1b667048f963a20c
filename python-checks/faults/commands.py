"""The commands that read a run file, and whether they tell the truth about a damaged one."""

import re
import shutil
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from faults.program import BAD_INPUT, Outcome, Program
from faults.table import Verdict

COMMANDS = {
    "status": ("status", "run.h5", "--json"),
    "check": ("check", "run.h5"),
    "solve": ("solve", "run.h5", "--json"),
    "post": ("post", "run.h5", "--no-figures", "--json"),
    "report": ("report", "run.h5", "report.html"),
}


class Answer(Enum):
    """What a command may say of a damaged file that it does not refuse."""

    SAME = "the same"
    SAME_RESULTS = "other digests, the same results"
    ANY = "anything"


SECTION = re.compile(r'<section id="(\w+)">(.*?)</section>', re.DOTALL)
COMPUTED = ("results", "panels", "details", "convergence", "certificate")


@dataclass(frozen=True)
class Commands:
    """The commands, what they say of the undamaged file, and a folder to run them in."""

    program: Program
    folder: Path
    good: Path
    truth: dict[str, object]

    @classmethod
    def side_by_side(cls, program: Program, folders: list[Path], good: Path) -> list["Commands"]:
        """Take down what each command says of a good file, for use in several folders."""
        for folder in folders:
            folder.mkdir(parents=True, exist_ok=True)
        truth = {}
        for name, command in COMMANDS.items():
            shutil.copy(good, folders[0] / "run.h5")
            truth[name] = said(name, program.done(*command, cwd=folders[0]), folders[0])
        return [cls(program, folder, good, truth) for folder in folders]

    def judge(
        self, damaged: Path, answer: Answer, left_out: tuple = ()
    ) -> dict[str, Verdict | str]:
        """What each command makes of a damaged file."""
        names = [name for name in COMMANDS if name not in left_out]
        return {name: self.judge_one(name, damaged, answer) for name in names}

    def judge_one(self, name: str, damaged: Path, answer: Answer) -> Verdict | str:
        """Refused with nothing changed on disk, or done with the right answer."""
        file = self.folder / "run.h5"
        shutil.copy(damaged, file)
        (self.folder / "report.html").unlink(missing_ok=True)
        outcome = self.program.run(*COMMANDS[name], cwd=self.folder)
        if outcome.fault:
            return outcome.fault
        if outcome.code == BAD_INPUT:
            same = file.read_bytes() == damaged.read_bytes()
            return Verdict.REFUSED if same else f"{name} refused, but changed the file"
        if outcome.code != 0:
            return f"{name} ended with {outcome.code}: {outcome.stderr[-200:]}"
        if answer is Answer.ANY:
            return Verdict.WENT_ON
        reported = said(name, outcome, self.folder)
        if is_true(name, reported, self.truth[name], answer):
            return Verdict.WENT_ON
        return f"{name} gave a wrong answer"


def said(name: str, outcome: Outcome, folder: Path) -> object:
    """What a command says that does not depend on the clock."""
    if name == "check":
        return None
    if name == "report":
        sections = SECTION.findall((folder / "report.html").read_text())
        return {key: text for key, text in sections if key in COMPUTED}
    answer = outcome.json
    if name == "status":
        stages = {s["stage"]: (s["state"], s["digest"]) for s in answer["stages"]}
        return {"stages": stages, "results": without_seconds(answer["results"])}
    return without_seconds(answer)


def without_seconds(answer: object) -> object:
    """Results without timings."""
    if isinstance(answer, dict):
        kept = {k: v for k, v in answer.items() if "seconds" not in k and k != "stages"}
        return {key: without_seconds(value) for key, value in kept.items()}
    if isinstance(answer, list):
        return [without_seconds(value) for value in answer]
    return answer


def is_true(name: str, reported: object, truth: object, answer: Answer) -> bool:
    """Whether an answer is that of the good file, or says which of it cannot be used."""
    if name == "status":
        fresh = [k for k, v in reported["stages"].items() if v[0] == "fresh"]
        other = any(reported["stages"][k] != truth["stages"][k] for k in fresh)
        if other and answer is Answer.SAME:
            return False
        return reported["results"] in (None, truth["results"])
    # A report of a file with a stale stage says so and shows no results.
    return reported == truth or (name == "report" and reported == {})
