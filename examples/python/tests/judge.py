"""The error of a solution as a stranger measures it: written from the guide's formulas, apart from the library."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def project(x: Array, mu: float) -> Array:
    """Nearest point of the friction cone ``|x_T| <= mu x_N``."""
    normal, tangent = x[0], x[1:]
    length = float(np.linalg.norm(tangent))
    if mu * length <= -normal:
        return np.zeros_like(x)
    if length <= mu * normal:
        return x
    along = (normal + mu * length) / (1 + mu * mu)
    return np.concatenate([[along], mu * along * tangent / length])


def error(M: Array, H: Array, push: Array, w: Array, mu: Array, v: Array, r: Array) -> float:
    """The larger part of the error: contacts and momentum. ``H`` is ``(c, d, n)``."""
    contacts, dim, _ = H.shape
    free = np.linalg.solve(M, push)
    gaps, references, stops = [], [], []
    for i in range(contacts):
        u, q = H[i] @ v + w[i], H[i] @ free + w[i]
        alpha = dim / np.trace(H[i] @ np.linalg.solve(M, H[i].T))
        shifted, alone = u.copy(), q.copy()
        shifted[0] += mu[i] * np.linalg.norm(u[1:])
        alone[0] += mu[i] * np.linalg.norm(q[1:])
        gaps.append(r[i] - project(r[i] - alpha * shifted, mu[i]))
        references.append(project(-alpha * alone, mu[i]))
        gap = np.abs(w[i]) * np.concatenate([[w[i][0] < 0], np.ones(dim - 1)])
        stops.append(alpha * (np.abs(H[i]) @ np.abs(free) + gap) / 100)
    norms = [float(np.linalg.norm(part)) for part in (r, references, stops)]
    total = float(np.linalg.norm(gaps))
    reference = max(norms)
    contact = total / reference if reference > 0 else 0.0
    reaction = np.einsum("cdn,cd->n", H, r)
    size = max(float(np.linalg.norm(part)) for part in (push, M @ v, reaction))
    momentum = float(np.linalg.norm(M @ v - push - reaction)) / size if size > 0 else 0.0
    return max(contact, momentum)


def read(scene: dict[str, Any]) -> tuple[Array, Array, Array, Array, Array]:
    """``M``, ``H``, free impulse, ``w``, ``mu`` of a scene file, or of a time step of a sequence."""
    c, n = scene["n_contacts"], len(scene["M"])
    H = np.array(scene["H"], dtype=float).reshape(c, -1, n)
    return (
        np.array(scene["M"], dtype=float),
        H,
        -np.array(scene["f"], dtype=float),
        np.array(scene["w"], dtype=float).reshape(c, -1),
        np.array(scene["mu"], dtype=float),
    )
