"""The contact pressure of the published problem, with and without the ramp of its friction along t₁."""

import contact3d
import matplotlib.pyplot as plt

CELLS = {"body.brick.cells": [24, 8, 8]}
LAWS = {"F₁ falls with slip": {}, "constant F₁": {"friction.coefficient_1": {"constant": 0.3}}}

figure, axes = plt.subplots(2, 1, sharex=True, figsize=(7, 5), layout="constrained")
for number, (axis, (title, law)) in enumerate(zip(axes, LAWS.items(), strict=True)):
    run = contact3d.run("pipelines/newton.toml", f"pressure_{number}.h5", set=CELLS | law)
    (run.panes()["pressure"] / 1e6).plot.pcolormesh(ax=axis, cbar_kwargs={"label": "pressure [MPa]"})
    axis.set(xlabel="x [m]", ylabel="y [m]", title=title, aspect="equal")
figure.savefig("pressure.png", dpi=120)
