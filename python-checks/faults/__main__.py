"""The command line of the fault tests."""

import argparse
import sys
import tempfile
from pathlib import Path

if __package__ in (None, ""):
    # Run as a folder: the folder's parent holds this package and the readers it uses.
    sys.path[0] = str(Path(__file__).resolve().parent.parent)

from campaign import arguments, require

require("blake3", "h5py", "numpy")

from faults import bad_files, environment, kills, writes
from faults.program import Program
from faults.table import print_table


def asked_for() -> argparse.Namespace:
    """What was asked for."""
    parser = arguments("faults", __doc__)
    parser.add_argument("--scratch", type=Path, help="a folder for run files")
    parts = parser.add_subparsers(dest="part", required=True)
    part = parts.add_parser("kills", help="signals at random moments of every stage")
    part.add_argument("--count", type=int, default=300, help="SIGKILLs in all")
    part.add_argument("--only", nargs="*", help="names of stages")
    part = parts.add_parser("writes", help="failing calls of every command that writes")
    part.add_argument("--count", type=int, default=1000, help="failures in all")
    part.add_argument("--only", nargs="*", help="names of commands")
    parts.add_parser("environment", help="disk, permissions, other processes")
    part = parts.add_parser("files", help="damaged, altered and hostile files")
    part.add_argument(
        "--only",
        nargs="*",
        help="foreign versions links truncated altered metadata values",
    )
    part.add_argument(
        "--flips",
        type=int,
        default=4000,
        help="bytes flipped, half of them in metadata, half in values",
    )
    part.add_argument("--truncate-every", type=int, default=1024, metavar="BYTES")
    return parser.parse_args()


def main() -> int:
    """Run one part and print its table."""
    chosen = asked_for()
    program = Program.find(chosen.program)
    with tempfile.TemporaryDirectory(dir=chosen.scratch) as folder:
        scratch = Path(folder)
        if chosen.part == "kills":
            rows = kills.run(program, scratch, chosen.count, chosen.seed, chosen.only)
        elif chosen.part == "writes":
            rows = writes.run(program, scratch, chosen.count, chosen.seed, chosen.only)
        elif chosen.part == "environment":
            rows = environment.run(program, scratch, chosen.seed)
        else:
            limits = (chosen.flips, chosen.truncate_every)
            rows = bad_files.run(
                program, scratch, *limits, chosen.seed, only=chosen.only
            )
        return print_table(rows)


if __name__ == "__main__":
    sys.exit(main())
