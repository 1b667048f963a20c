"""How the force along the foundation grows with the coefficient of friction, over a folder that `contact3d-pipe sweep` made
of pipelines/sweep_friction.toml."""

import sys

import contact3d
import matplotlib.pyplot as plt

table = contact3d.open_sweep(sys.argv[1])
force = table["tangential_force"].sel(friction_axis="t1").isel({"friction.coefficient_2": 0}) / 1e6
figure, axis = plt.subplots(layout="constrained")
force.plot.line(ax=axis, x="friction.coefficient_1.constant", xscale="log", marker="o")
axis.set(xlabel="F₁", ylabel="force along t₁ [MN]", title=f"{force.size} cases of {sys.argv[1]}")
figure.savefig("sweep.png", dpi=120)
