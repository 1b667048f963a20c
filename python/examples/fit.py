"""Which friction law gives a measured loop? SciPy fits a ramp to the forces of a load history, over one mesh and one factor."""

import contact3d
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import least_squares

SCENE, CELLS = "pipelines/history.toml", {"body.brick.cells": [6, 2, 2]}
TRUTH, START = [0.40, 0.25], [0.35, 0.20]


def loop(law):
    """Displacement [µm] and friction force [MN] in each increment; what does not depend on the law stays in the file."""
    initial, residual = map(float, law)
    ramp = {"ramp": {"initial": initial, "residual": residual, "onset": 2e-6, "rate": 1e4}}
    history = contact3d.run(SCENE, "fit.h5", set=CELLS | {"friction.coefficient": ramp}).history
    displacement = 1e6 * history["contact_displacement"].sel(friction_axis="t1").values
    return displacement, history["multiplier_force"].sel(contact_axis="t1").values / 1e6


displacement, exact = loop(TRUTH)
measured = exact + 0.05 * np.random.default_rng(1).standard_normal(exact.size)
fit = least_squares(lambda law: loop(law)[1] - measured, START, diff_step=1e-3, ftol=1e-3)
variance = 2 * fit.cost / (fit.fun.size - fit.x.size)
spread = np.sqrt(np.diag(variance * np.linalg.inv(fit.jac.T @ fit.jac)))
for name, value, error, truth in zip(("initial", "residual"), fit.x, spread, TRUTH, strict=True):
    print(f"{name} {value:.3f} ± {error:.3f}, made with {truth}")

figure, axis = plt.subplots(layout="constrained")
axis.plot(displacement, measured, "k.", label="measured")
axis.plot(*loop(fit.x), label="fitted")
axis.set(xlabel="mean displacement of the contact face [µm]", ylabel="friction force [MN]")
axis.legend()
figure.savefig("fit.png", dpi=120)
