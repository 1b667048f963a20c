"""How the force along the foundation grows with the coefficient of friction, over a folder that `contact3d-pipe sweep` made."""

import sys

import contact3d
import matplotlib.pyplot as plt

table = contact3d.open_sweep(sys.argv[1])
force = table["tangential_force"].isel(friction_axis=0) / 1e6
force.isel({"friction.coefficient_2": 0}).plot.line(x="friction.coefficient_1.constant", xscale="log", marker="o")
plt.ylabel("force along t₁ [MN]")
plt.savefig("sweep.png", dpi=120)
