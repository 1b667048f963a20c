"""What came of many trials of one kind, as a line of a Markdown table."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum


class Verdict(Enum):
    """What came of one trial, where it is not wrong."""

    WENT_ON = "went on"
    REFUSED = "refused"


@dataclass
class Row:
    """One kind of fault."""

    case: str
    went_on: int = 0
    refused: int = 0
    wrong: list[str] = field(default_factory=list)
    note: str = ""

    @property
    def tried(self) -> int:
        """Number of trials."""
        return self.went_on + self.refused + len(self.wrong)

    def count(self, verdict: Verdict | str) -> None:
        """Count a trial; a text says what is wrong."""
        if verdict is Verdict.WENT_ON:
            self.went_on += 1
        elif verdict is Verdict.REFUSED:
            self.refused += 1
        else:
            self.wrong.append(verdict)

    def line(self) -> str:
        """The line of the table."""
        if self.tried == 0:
            return f"| {self.case} | 0 | | | skipped: {self.note} |"
        cells = (self.case, self.tried, self.went_on, self.refused, len(self.wrong))
        return f"| {' | '.join(map(str, cells))} |"


HEADER = (
    "| case | tried | opened and went on | typed error | wrong |\n|---|---|---|---|---|"
)


def print_table(rows: Iterable[Row]) -> int:
    """Print the table line by line as it comes, then what is wrong; the exit code."""
    print(HEADER, flush=True)
    wrong = []
    for row in rows:
        print(row.line(), flush=True)
        wrong += [f"WRONG {row.case}: {problem}" for problem in row.wrong]
    print("\n".join(wrong))
    return int(bool(wrong))
