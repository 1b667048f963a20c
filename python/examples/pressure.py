"""The contact pressure of the published problem, with and without the ramp of its friction along t₁."""

import contact3d
import matplotlib.pyplot as plt

CELLS = {"body.brick.cells": [24, 8, 8]}
LAWS = {"F₁ falls with slip": {}, "constant F₁": {"friction.coefficient_1": {"constant": 0.3}}}

figure, axes = plt.subplots(2, 1, sharex=True, figsize=(7, 5), layout="constrained")
for number, (axis, (title, law)) in enumerate(zip(axes, LAWS.items(), strict=True)):
    tree = contact3d.run("pipelines/newton.toml", f"pressure_{number}.h5", set=CELLS | law)
    pressure = (tree["solve/multiplier_normal"] / 1e6).reset_coords("pane_z", drop=True)
    # The panes of a brick are a grid.
    sheet = pressure.set_index(n_panes=["pane_y", "pane_x"]).unstack("n_panes")
    sheet.plot.pcolormesh(ax=axis, cbar_kwargs={"label": "pressure [MPa]"})
    axis.set(xlabel="x [m]", ylabel="y [m]", title=title, aspect="equal")
figure.savefig("pressure.png", dpi=120)
