"""The command line: python3 python-checks/paths --scenes 80 --nodes 1 --law ramp."""

import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

if __package__ in (None, ""):
    # Run as a folder: the folder's parent holds this package and the readers it uses.
    sys.path[0] = str(Path(__file__).resolve().parent.parent)

from campaign import arguments, require

require("blake3", "h5py", "numpy", "scipy")

from faults.program import Program
from paths.compare import compare, table
from paths.scenes import LAWS


def main() -> int:
    """Compare random scenes; 1 where a solution is missed."""
    parser = arguments("paths", __doc__)
    parser.set_defaults(seed=0)
    parser.add_argument("--scenes", type=int, default=20, help="scenes of each kind")
    parser.add_argument("--nodes", type=int, nargs="*", default=[1, 2, 3])
    parser.add_argument("--law", choices=LAWS, nargs="*", default=LAWS)
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument("--keep", type=Path, help="folder for the scenes")
    chosen = parser.parse_args()
    program = Program.find(chosen.program)
    compared = []
    with tempfile.TemporaryDirectory() as scratch:
        root = chosen.keep or Path(scratch)
        for nodes in chosen.nodes:
            for law in chosen.law:
                for number in range(chosen.first, chosen.first + chosen.scenes):
                    folder = root / f"{nodes}_{number}"
                    one = compare(program, folder, nodes, law, number, chosen.seed)
                    compared.append(one)
                    if not one.is_good:
                        print(one, file=sys.stderr)
    print(table(compared))
    return int(any(not one.is_good for one in compared))


if __name__ == "__main__":
    sys.exit(main())
