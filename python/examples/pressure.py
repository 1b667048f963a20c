"""The contact pressure of the published problem, with and without the ramps of its friction."""

import contact3d
import matplotlib.pyplot as plt

CELLS = {"body.brick.cells": [24, 8, 8]}

figure, axes = plt.subplots(2, 1, sharex=True, layout="constrained")
for axis, law in zip(axes, ({}, {"friction.coefficient_1": {"constant": 0.3}}), strict=True):
    tree = contact3d.run("pipelines/newton.toml", f"pressure_{len(law)}.h5", set=CELLS | law)
    pressure = tree["solve/multiplier_normal"] / 1e6
    points = axis.scatter(pressure.pane_x, pressure.pane_y, c=pressure, s=600, marker="s")
    axis.set(xlabel="x [m]", ylabel="y [m]", title="constant F₁" if law else "F₁ falls with slip")
    figure.colorbar(points, label="pressure [MPa]")
figure.savefig("pressure.png", dpi=120)
