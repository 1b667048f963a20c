"""Pictures of contact faces with matplotlib."""

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from ._grids import pane_triangles

if TYPE_CHECKING:
    from ._run import Run

ZONES = {"open": "lightgrey", "stick": "tab:blue", "slip": "tab:orange"}


def draw_panes(run: "Run", name: str, face: str | None, time: float | None, ax: Any, style: dict[str, Any]) -> Any:
    """A figure of the panes as colours on the contact face, seen along the axis in which it is thinnest."""
    row = run.row_of_panes(face, history=time is not None)
    if time is not None:
        row = row.sel(time=time, method="nearest")
    values = figure(row, name)
    triangles, of_triangle = pane_triangles(run)
    shown = np.isin(of_triangle, row["number"].values)
    if shown.any():
        points, triangles = run["mesh/coordinates"].values, triangles[shown]
        place = np.searchsorted(row["number"].values, of_triangle[shown])
    else:
        points, triangles = np.column_stack([row[axis].values for axis in "xyz"]), None
        place = np.arange(row.sizes["pane"])
    corners = points if triangles is None else points[np.unique(triangles)]
    across = int(np.argmin(np.ptp(corners, axis=0)))
    first, second = (k for k in range(3) if k != across)
    ax = axes(ax, float(np.ptp(corners[:, second]) / np.ptp(corners[:, first])))
    words = name.replace("_", " ").replace(".", ", ")
    unit = values.attrs.get("units", "1")
    is_zone = values.dtype.kind in "UO"
    codes = np.array([list(ZONES).index(word) for word in values.values]) if is_zone else values.values
    style = {**(zone_style() if is_zone else {}), **style}
    if triangles is None:
        colours = ax.scatter(points[:, first], points[:, second], c=codes, **style)
    else:
        colours = ax.tripcolor(points[:, first], points[:, second], triangles, facecolors=codes[place], **style)
    if is_zone:
        add_legend(ax)
    else:
        size, unit = multiple(values, unit)
        ticks = lambda value, _: f"{value / size:g}"  # noqa: E731
        ax.figure.colorbar(colours, ax=ax, format=ticks, label=words if unit == "1" else f"{words} [{unit}]")
    length = run["mesh/coordinates"].units
    ax.set(xlabel=f"{'xyz'[first]} [{length}]", ylabel=f"{'xyz'[second]} [{length}]", aspect="equal")
    ax.set_title(words if time is None else f"{words}, time {float(row.time):g}")
    return ax


def axes(ax: Any, height_over_width: float) -> Any:
    """The given axes, or new ones of a picture as flat as what they show."""
    if ax is None:
        import matplotlib.pyplot as plt

        height = min(max(5.5 * height_over_width, 1.0), 6.0) + 1.0
        ax = plt.subplots(figsize=(7.0, height), layout="constrained")[1]
    return ax


def figure(panes: xr.Dataset, name: str) -> xr.DataArray:
    """A variable of the panes, or one of its components as ``slip.t1``."""
    variable, _, component = name.partition(".")
    if variable not in panes.data_vars:
        raise ValueError(f"panes have {', '.join(map(str, panes.data_vars))}, not {variable!r}")
    values = panes[variable]
    if "friction_axis" not in values.dims:
        return values
    if component not in values.friction_axis.values:
        raise ValueError(f"name a component, as {variable}.t1")
    return values.sel(friction_axis=component)


def multiple(values: xr.DataArray, unit: str) -> tuple[float, str]:
    """The multiple of m or Pa that prints the largest value as a number from 1 to 1000, with its size."""
    largest = float(np.abs(values).max()) if unit in ("m", "Pa") else 0.0
    power = 3 * int(np.floor(np.log10(largest) / 3)) if largest > 0 else 0
    prefixes = {-9: "n", -6: "\N{MICRO SIGN}", -3: "m", 3: "k", 6: "M", 9: "G"}
    return (10.0**power, prefixes[power] + unit) if power in prefixes else (1.0, unit)


def zone_style() -> dict[str, Any]:
    """A colour for each zone."""
    from matplotlib.colors import ListedColormap

    return {"cmap": ListedColormap(list(ZONES.values())), "vmin": -0.5, "vmax": len(ZONES) - 0.5}


def add_legend(ax: Any) -> None:
    """The colours of the zones in words, beside the face."""
    from matplotlib.patches import Patch

    patches = [Patch(color=colour, label=word) for word, colour in ZONES.items()]
    ax.legend(handles=patches, loc="upper left", bbox_to_anchor=(1.0, 1.0))
