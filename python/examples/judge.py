"""Siconos judges the forces in a file of FCLIB, and finds its own: judge.py problem.hdf5, with Debian's python3-siconos."""

import sys

import h5py
import numpy as np
import scipy.sparse
import siconos.numerics as sn

with h5py.File(sys.argv[1]) as file:
    w = file["fclib_local/W"]
    shape = (int(np.squeeze(w["m"])), int(np.squeeze(w["n"])))
    matrix = scipy.sparse.csc_matrix((w["x"][:], w["i"][:], w["p"][:]), shape).toarray()
    q, mu = file["fclib_local/vectors/q"][:], file["fclib_local/vectors/mu"][:]
    ours = file["solution/r"][:]

problem = sn.FrictionContactProblem(3, matrix, q, mu)
options = sn.SolverOptions(sn.SICONOS_FRICTION_3D_NSN_AC)
options.dparam[sn.SICONOS_DPARAM_TOL] = 1e-12
error = sn.fc3d_compute_error(problem, ours.copy(), np.zeros_like(q), 1e-12, options, np.linalg.norm(q))[1]
print(f"{len(mu)} contacts, error of the stored forces by fc3d_compute_error: {error:.1e}")

force, velocity = np.zeros_like(q), np.zeros_like(q)
failed = sn.fc3d_driver(problem, force, velocity, options)
distance = np.linalg.norm(force - ours) / np.linalg.norm(ours)
print(f"from zero, Siconos {'does not converge' if failed else 'converges'}, and its forces differ by {distance:.1e}")
