"""Print what a run file of contact3d-pipe holds: a first script to copy from.

Works on partly finished files: what is not there yet is said so.
"""

import argparse
import sys

import h5py
import numpy as np

from run_file import (
    STAGES,
    RunFileError,
    open_run,
    read_enum,
    read_scene,
    stored_stages,
)


def print_stages(file: h5py.File) -> None:
    """One line per stage: when it ended and how long it took."""
    print("stages")
    present = stored_stages(file)
    for stage in STAGES:
        if stage in present:
            a = file[stage].attrs
            print(f"  {stage:<9} {a['date']}  {a['seconds']:.3f} s")
        else:
            print(f"  {stage:<9} not run yet")


def print_mesh(mesh: h5py.Group) -> None:
    """Sizes and quality of the mesh."""
    quality = mesh["quality"]
    print("mesh")
    print(f"  nodes               {mesh['coordinates'].shape[0]}")
    print(f"  tetrahedra          {mesh['tetrahedra'].shape[0]}")
    print(f"  panes               {mesh['pane_area'].shape[0]}")
    print(f"  longest edge        {quality['longest_edge'][()]:.6g} m")
    print(f"  smallest shape      {quality['smallest_shape'][()]:.4f} (1 is regular)")


def print_assembly(assemble: h5py.Group) -> None:
    """Sizes of the algebraic problem."""
    free = assemble["stiffness/indptr"].shape[0] - 1
    print("assembly")
    print(f"  unknowns            {free} primal")
    if "values" in assemble["factor"]:
        print(f"  factor              {assemble['factor/values'].shape[0]} coefficients")


def print_load(load: h5py.Group) -> None:
    """Size of the load."""
    print("load")
    print(f"  norm                {np.linalg.norm(load['force'][:]):.6e} N")
    if "dual_rhs" in load:
        print(f"  multipliers         {load['dual_rhs'].shape[0]}")


def print_solution(solve: h5py.Group) -> None:
    """How the solve went."""
    outer = solve["history/change"].shape[0]
    newton = solve["newton/residual"].shape[0]
    print("solution")
    print(f"  status              {read_enum(solve['status'])}")
    print(f"  steps               {outer} outer, {newton} Newton")
    print(f"  accuracy            {solve['accuracy'][()]:.2e}")
    print(f"  applications n_A    {solve['applications'][()]}")


def print_report(post: h5py.Group) -> None:
    """Zone counts, resultants and the certificate, with the units of the file."""
    counts = dict(zip(("open", "stick", "slip"), post["zone_counts"][:], strict=True))
    print("contact zones")
    print("  " + ", ".join(f"{zone} {count}" for zone, count in counts.items()))
    for group in ("resultants", "certificate"):
        print(group)
        for name, dataset in post[group].items():
            if dataset.ndim == 2:
                continue
            values = [float(value) for value in dataset[()].flat]
            unit = "" if dataset.attrs["units"] == "1" else dataset.attrs["units"]
            numbers = ", ".join(f"{value:.6e}" for value in values)
            print(f"  {name:<21} {numbers} {unit}".rstrip())


def print_run(file: h5py.File) -> None:
    """Everything the finished stages have to say."""
    print(read_scene(file)["title"])
    print(f"{file.filename}, written by {file.attrs['creator']}")
    print_stages(file)
    printers = (
        print_mesh,
        print_assembly,
        print_load,
        print_solution,
        print_report,
    )
    present = stored_stages(file)
    for stage, printer in zip(STAGES, printers, strict=True):
        if stage in present:
            printer(file[stage])


def main() -> int:
    """Run the command line; 0 when printed, 2 for an unusable file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", help="a run file, such as table1.h5")
    arguments = parser.parse_args()
    try:
        with open_run(arguments.file) as file:
            print_run(file)
    except RunFileError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
