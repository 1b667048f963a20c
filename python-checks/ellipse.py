"""Projection on ellipses and its derivatives, for many panes at once, in double precision."""

from dataclasses import dataclass

import numpy as np

MOST_STEPS = 200


@dataclass(frozen=True)
class Projection:
    """Nearest points of ellipses, [m, 2], and derivatives of them."""

    point: np.ndarray
    outside: np.ndarray
    by_trial: np.ndarray
    by_axes: np.ndarray


def project(trial: np.ndarray, axes: np.ndarray) -> Projection:
    """Project `trial`, [m, 2], on ellipses of the given semi-axes; on their limits, segments and points, where these are 0."""
    m = len(trial)
    point = trial.copy()
    by_trial, by_axes = np.tile(np.eye(2), (m, 1, 1)), np.zeros((m, 2, 2))
    flat = ~(axes > 0.0).all(axis=1)
    point[flat] = np.clip(trial[flat], -axes[flat], axes[flat])
    moves = (np.abs(trial) <= axes) & (axes > 0.0)
    by_trial[flat] = by_trial[flat] * moves[flat][:, None]
    safe = np.where(flat[:, None], 1.0, axes)
    outside = ~flat & (np.sum((trial / safe) ** 2, axis=1) > 1.0)
    if outside.any():
        a, z = axes[outside], trial[outside]
        t = multiplier(z, a)[:, None]
        d = a**2 + t
        point[outside] = a**2 * z / d
        # p_k = a_k^2 z_k / d_k, with t from sum a_k^2 z_k^2 / d_k^2 = 1.
        weight = -2.0 * np.sum(a**2 * z**2 / d**3, axis=1)[:, None]
        t_by_z = -(2.0 * a**2 * z / d**2) / weight
        t_by_a = -(2.0 * a * z**2 / d**2 - 4.0 * a**3 * z**2 / d**3) / weight
        p_by_t = -(a**2) * z / d**2
        eye = np.eye(2)
        by_trial[outside] = (
            eye * (a**2 / d)[:, :, None] + p_by_t[:, :, None] * t_by_z[:, None]
        )
        own = 2.0 * a * z * t / d**2
        by_axes[outside] = eye * own[:, :, None] + p_by_t[:, :, None] * t_by_a[:, None]
    return Projection(point, outside | flat, by_trial, by_axes)


def multiplier(z: np.ndarray, a: np.ndarray) -> np.ndarray:
    """The t > 0 with sum (a z / (a^2 + t))^2 = 1, by Newton's method from the left."""
    t = np.maximum(np.max(a * np.abs(z) - a**2, axis=1), 0.0)
    for _ in range(MOST_STEPS):
        d = a**2 + t[:, None]
        terms = (a * z / d) ** 2
        excess = terms.sum(axis=1) - 1.0
        step = excess / (2.0 * np.sum(terms / d, axis=1))
        t = t + np.maximum(step, 0.0)
        if np.all(step <= 1e-15 * t):
            break
    return t
