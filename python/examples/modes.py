"""The stiffness matrix in SciPy: the lowest frequencies that the held body would have without contact."""

import contact3d
import scipy.sparse
import scipy.sparse.linalg

DENSITY = 7850.0  # kg/m³

tree = contact3d.run("pipelines/newton.toml", "modes.h5", set={"body.brick.cells": [24, 8, 8]})
stiffness = tree.matrices["assemble/stiffness"].tocsc()
volume = 3.0
lumped = scipy.sparse.eye_array(stiffness.shape[0]) * (DENSITY * volume / tree["mesh"].sizes["n_nodes"])
squares = scipy.sparse.linalg.eigsh(stiffness, k=4, M=lumped.tocsc(), sigma=0.0, return_eigenvectors=False)
print("frequencies [Hz]:", ", ".join(f"{(s**0.5) / 6.283185307:.0f}" for s in sorted(squares)))
