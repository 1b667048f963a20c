"""Damaged, altered and hostile run files: a typed error, or the right answer."""

import random
from collections.abc import Iterator
from pathlib import Path

import h5py

from digest import renew_digest
from faults.bench import Bench, Damage, one_row, row_each, same
from faults.commands import Answer
from faults.mutations import MUTATIONS, Mutation, fits, leaves
from faults.program import Program
from faults.table import Row

HISTORY = ("/solve/history/", "/solve/newton/", "/assemble/seconds/")
"""What happened on the way; numbers that are not finite may stand there."""
STRIKES = (0x01, 0x80, 0xFF, 0x5A)
FOREIGN = {
    "empty": b"",
    "text": b"a letter to a friend\n" * 100,
    "zeros": bytes(4096),
    "a picture": b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 16,
    "an HDF5 signature alone": b"\x89HDF\r\n\x1a\n",
    "an HDF5 signature, then zeros": b"\x89HDF\r\n\x1a\n" + bytes(4096),
    "an HDF5 signature, then ones": b"\x89HDF\r\n\x1a\n" + b"\xff" * 4096,
}


def usable(leaf: str) -> Answer:
    """With digests that fit it is another file, whose results must be numbers all the same."""
    return Answer.ANY if leaf.startswith(HISTORY) else Answer.SAME_RESULTS


def another(_: str) -> Answer:
    """With digests that fit, another index or count is another file."""
    return Answer.ANY


EXPECTED = {
    "NaN, digests made to fit": usable,
    "index out of range, digests made to fit": another,
}


def run(
    program: Program,
    scratch: Path,
    flips: int,
    truncate_every: int,
    seed: int,
    alter_every: int = 1,
    link_every: int = 1,
    only: list[str] | None = None,
) -> Iterator[Row]:
    """Bad files of all kinds, or some; of datasets to alter and of links every few."""
    bench = Bench.of(program, scratch)
    kinds = {
        "foreign": lambda: foreign(bench),
        "versions": lambda: headers(bench),
        "links": lambda: linked_groups(bench, link_every),
        "truncated": lambda: truncations(bench, truncate_every),
        "altered": lambda: altered(bench, alter_every),
        "metadata": lambda: flipped(bench, flips // 2, seed, in_values=False),
        "values": lambda: flipped(bench, flips // 2, seed, in_values=True),
    }
    for kind in only or kinds:
        yield from kinds[kind]()


def editable(path: Path) -> h5py.File:
    """A file open for changes; without locks, which a process just forked may still hold."""
    return h5py.File(path, "r+", locking=False)


def foreign(bench: Bench) -> list[Row]:
    """Files that are not HDF5, and an HDF5 file of something else."""
    rows, row_of = one_row("not one of our files")
    damages = [(name, writer(content)) for name, content in FOREIGN.items()]
    damages.append(("HDF5 of something else", someone_elses))
    bench.judge(row_of, damages)
    return rows


def writer(content: bytes) -> Damage:
    """Puts other bytes in the place of the file."""
    return lambda path: path.write_bytes(content)


def someone_elses(path: Path) -> None:
    """An HDF5 file without our attributes."""
    with h5py.File(path, "w") as file:
        file["x"] = [1.0]


def truncations(bench: Bench, every: int) -> list[Row]:
    """The file cut off at every few bytes."""
    whole = bench.good.read_bytes()
    rows, row_of = one_row(f"cut off at every {every} bytes")
    cuts = range(0, len(whole), every)
    bench.judge(row_of, [(f"at {cut}", writer(whole[:cut])) for cut in cuts])
    return rows


def flipped(bench: Bench, flips: int, seed: int, in_values: bool) -> list[Row]:
    """Single bytes changed, spread evenly over metadata or over values."""
    whole = bench.good.read_bytes()
    values = value_bytes(bench.good)
    places = [k for k in range(len(whole)) if (k in values) == in_values]
    step = max(len(places) / flips, 1.0)
    chosen = [places[int(k * step)] for k in range(int(len(places) / step))]
    chance = random.Random(seed)
    damages = [(f"byte {k}", flip(k, chance.choice(STRIKES))) for k in chosen]
    kind = "values" if in_values else "metadata"
    rows, row_of = row_each(f"a byte of {kind} flipped ({len(chosen)} places)")
    bench.judge(row_of, damages, report_every=10)
    return rows


def flip(position: int, strike: int) -> Damage:
    """Changes some bits of one byte."""

    def damage(path: Path) -> None:
        with path.open("r+b") as file:
            file.seek(position)
            byte = file.read(1)[0]
            file.seek(position)
            file.write(bytes([byte ^ strike]))

    return damage


def value_bytes(path: Path) -> set[int]:
    """The positions of all bytes that hold values of arrays."""
    found: set[int] = set()
    with h5py.File(path, "r") as file:
        for leaf in leaves(file):
            dataset = file[leaf]
            if h5py.check_string_dtype(dataset.dtype):
                continue
            if dataset.chunks:
                pieces = [
                    dataset.id.get_chunk_info(k)
                    for k in range(dataset.id.get_num_chunks())
                ]
                extents = [(piece.byte_offset, piece.size) for piece in pieces]
            elif (offset := dataset.id.get_offset()) is not None:
                extents = [(offset, dataset.id.get_storage_size())]
            else:
                extents = []
            for start, size in extents:
                found.update(range(start, start + size))
    return found


def headers(bench: Bench) -> list[Row]:
    """Root attributes of another program or another version of this one."""
    rows, row_of = one_row("newer, older or unreadable format version")
    versions = [
        [2, 0],
        [2, 99],
        [1, 11],
        [0, 9],
        [-1, 0],
        [2],
        [2, 0, 3],
        [2.5, 0.5],
        "2.0",
        None,
    ]
    bench.judge(row_of, [(f"version {v}", versioned(v)) for v in versions])
    return rows


def versioned(version: object) -> Damage:
    """Puts another format version in the file."""

    def damage(path: Path) -> None:
        with editable(path) as file:
            del file.attrs["format_version"]
            if version is not None:
                file.attrs["format_version"] = version

    return damage


def altered(bench: Bench, every: int) -> Iterator[Row]:
    """Every way to alter a dataset."""
    for k, (name, mutation) in enumerate(MUTATIONS.items()):
        yield from mutated(bench, name, mutation, every, k / len(MUTATIONS))


def mutated(
    bench: Bench, name: str, mutation: Mutation, every: int, phase: float
) -> list[Row]:
    """One way to alter a dataset, for all datasets of the file that it fits, or as many as every few are."""
    with h5py.File(bench.good, "r") as file:
        paths = list(leaves(file))
        fitting = [path for path in paths if fits(mutation, file[path])]
    paths = spread(fitting, -(-len(paths) // every), phase)
    rows, row_of = row_each(f"{name} (each of {len(paths)})")

    def damage(leaf: str) -> Damage:
        def change(path: Path) -> None:
            with editable(path) as file:
                mutation(file, leaf)
            if name in EXPECTED:
                renew_digest(path)

        return change

    damages = [(leaf, damage(leaf)) for leaf in paths]
    bench.judge(row_of, damages, EXPECTED.get(name, same))
    return rows


def spread(paths: list[str], count: int, phase: float) -> list[str]:
    """So many of the paths, evenly spread; another phase from 0 to 1 picks others."""
    count = min(count, len(paths))
    return [paths[int((k + phase) * len(paths) / count)] for k in range(count)]


def linked_groups(bench: Bench, every: int) -> list[Row]:
    """A whole stage replaced by a link that leads out of the folder, or nowhere; every few of all pairs."""
    rows, row_of = one_row("a stage replaced by a link")
    with h5py.File(bench.good, "r") as file:
        stages = list(file)
    targets = [
        "../outside.h5",
        str(bench.scratch / "outside.h5"),
        "nowhere.h5",
        "run.h5",
    ]

    def damage(stage: str, target: str, named: bool) -> Damage:
        def change(path: Path) -> None:
            with editable(path) as file:
                del file[stage]
                file[stage] = h5py.ExternalLink(target, f"/{stage}")
                if named:
                    file.attrs[f"{stage}_file"] = target

        return change

    damages = [
        (f"{stage} to {target}", damage(stage, target, named))
        for stage in stages
        for target in targets
        for named in (False, True)
    ]
    bench.judge(row_of, damages[::every])
    return rows
