"""Every way to alter one dataset with h5py, digests left as they are or made to fit."""

from collections.abc import Callable, Iterator

import h5py
import numpy as np

from digest import dataset_digest, input_digest, stage_digest
from faults.integrity import rows_by_stage
from run_file import STAGES

HUGE = 1 << 50
"""Elements that no file holds: 2^53 bytes of doubles."""
Mutation = Callable[[h5py.File, str], None]


def leaves(file: h5py.File) -> Iterator[str]:
    """Paths of all datasets, those of matrices one by one."""
    found = []
    file.visititems(lambda n, i: found.append(f"/{n}") if is_array(i) else None)
    return iter(found)


def is_array(item) -> bool:
    """Whether an object of a file is a dataset."""
    return isinstance(item, h5py.Dataset)


def remove(file: h5py.File, path: str) -> None:
    """The dataset is gone."""
    del file[path]


def retype(file: h5py.File, path: str) -> None:
    """The same numbers as single floats, the same text as numbers."""
    old = file[path]
    text = h5py.check_string_dtype(old.dtype)
    data = np.zeros(old.shape, "f4") if text else old[()].astype("f4")
    replace(file, path, data=data)


def reshape(file: h5py.File, path: str) -> None:
    """One more element along the first axis; a vector instead of a scalar."""
    data = file[path][()]
    flat = np.atleast_1d(data)
    if flat.size == 0:
        raise Unfit
    replace(file, path, data=np.concatenate([flat, flat[:1]]), dtype=file[path].dtype)


def enlarge(file: h5py.File, path: str) -> None:
    """A size that only the header of the dataset has: chunks that were never written."""
    shape = (HUGE, *file[path].shape[1:])
    chunks = (1 << 10, *shape[1:])
    replace(file, path, shape=shape, dtype=file[path].dtype, chunks=chunks)


def alter(file: h5py.File, path: str) -> None:
    """Another value in the last place, as a person would write it with h5py."""
    data = file[path][()]
    if h5py.check_string_dtype(file[path].dtype):
        changed = data + b"x" if isinstance(data, bytes) else [t + b"x" for t in data]
    else:
        changed = np.array(data)
        flat = changed.reshape(-1)
        if flat.size == 0:
            raise Unfit
        flat[-1] = flat[-1] + 1 if flat[-1] == 0 else 0
    file[path][...] = changed


def not_finite(file: h5py.File, path: str) -> None:
    """NaN in the last place, all digests made to fit."""
    change_with_digests(file, path, np.nan)


def out_of_range(file: h5py.File, path: str) -> None:
    """An index or code that points nowhere, all digests made to fit."""
    change_with_digests(file, path, 1 << 40 if file[path].dtype == "i8" else 99)


def soft_link(file: h5py.File, path: str) -> None:
    """A link to another place of the same file."""
    relink(file, path, h5py.SoftLink("/scene/toml"))


def external_link(file: h5py.File, path: str) -> None:
    """A link to the same dataset of another file, outside the folder."""
    relink(file, path, h5py.ExternalLink("../outside.h5", path))


MUTATIONS: dict[str, Mutation] = {
    "dataset missing": remove,
    "dataset of another type": retype,
    "dataset of another shape": reshape,
    "dataset of a huge declared size": enlarge,
    "value altered by hand": alter,
    "NaN, digests made to fit": not_finite,
    "index out of range, digests made to fit": out_of_range,
    "soft link instead of a dataset": soft_link,
    "external link instead of a dataset": external_link,
}


KINDS: dict[Mutation, str] = {not_finite: "f", out_of_range: "iu"}
"""The kinds of numbers that a mutation is about."""


def fits(mutation: Mutation, dataset: h5py.Dataset) -> bool:
    """Whether a mutation is about the kind of values that a dataset holds."""
    return dataset.dtype.kind in KINDS.get(mutation, dataset.dtype.kind)


class Unfit(Exception):
    """The mutation makes no sense for this dataset."""


def replace(file: h5py.File, path: str, **options) -> None:
    """Another dataset with the attributes of the old one."""
    attributes = dict(file[path].attrs)
    del file[path]
    dataset = file.create_dataset(path, **options)
    for name, value in attributes.items():
        dataset.attrs[name] = value


def relink(file: h5py.File, path: str, link) -> None:
    """A link in the place of a dataset."""
    del file[path]
    file[path] = link


def change_with_digests(file: h5py.File, path: str, value: float) -> None:
    """Another value in the last place, and every digest from there on as if it belonged."""
    item = file[path]
    if item.size == 0:
        raise Unfit
    data = item[()]
    changed = np.array(data)
    changed.reshape(-1)[-1] = value
    item[...] = changed
    fit_digests(file)


def fit_digests(file: h5py.File) -> None:
    """Compute the digests of all stages again, upstream first."""
    upstream: list[str] = []
    for stage in (*STAGES, "VTKHDF", "scene"):
        if stage not in file:
            continue
        if stage in STAGES:
            settings = file[stage].attrs["settings"]
            file[stage].attrs["input_digest"] = input_digest(stage, settings, upstream)
        digests = {}
        for row in rows_by_stage()[stage]:
            if row["path"] not in file:
                continue
            if row["in_stage_digest"]:
                digests[row["path"]] = dataset_digest(file[row["path"]], row["type"])
        file[stage].attrs["digest"] = stage_digest(digests, file[stage].attrs["units"])
        upstream.append(file[stage].attrs["digest"])
