"""A scene file, its Delassus operator, and the error of a solution as `src/guide/error.md` defines it."""
import json
import time

import numpy as np
from scipy.linalg import blas, lapack


class Scene:
    def __init__(self, path):
        data = json.loads(path.read_text())
        self.path, self.name, self.dim = path, data["name"], data["dim"]
        self.M, self.H, self.f, self.w, self.mu = (
            np.array(data[key], float) for key in ("M", "H", "f", "w", "mu")
        )
        self.W, self.q = self.delassus()

    def delassus(self):
        """`W = H M⁻¹ Hᵀ`, `q = w - H M⁻¹ f`."""
        factor, _ = lapack.dpotrf(self.M, lower=1)
        X, _ = lapack.dtrtrs(factor, self.H.T, lower=1)
        g, _ = lapack.dtrtrs(factor, self.f, lower=1)
        return blas.dgemm(1.0, X, X, trans_a=1), self.w - X.T @ g.ravel()

    def seconds_for_delassus(self):
        """What LAPACK and BLAS take for `W`, less what their calls from Python take for one dof and one row."""
        call = seconds_for_delassus(np.eye(1), np.eye(1))
        return max(seconds_for_delassus(self.M, self.H) - call, 0.1 * call)

    def velocity(self, r):
        return np.linalg.solve(self.M, self.H.T @ r - self.f)

    def error(self, v, r):
        """The larger of the contacts' and the momentum's relative residual."""
        u, free = self.H @ v + self.w, -np.linalg.solve(self.M, self.f)
        offset = np.abs(self.w)
        offset[:: self.dim][self.w[:: self.dim] > 0.0] = 0.0  # gaps
        speed = np.abs(self.H) @ np.abs(free) + offset
        residual, alone = np.zeros_like(r), np.zeros_like(r)
        for i, mu in enumerate(self.mu):
            rows = slice(self.dim * i, self.dim * (i + 1))
            trace = np.trace(self.W[rows, rows])
            alpha = self.dim / trace if trace > 0.0 else 0.0
            residual[rows] = r[rows] - project(r[rows] - alpha * lifted(u[rows], mu), mu)
            alone[rows] = project(-alpha * lifted(self.q[rows], mu), mu)
            speed[rows] *= 1e-2 * alpha
        size = max(map(np.linalg.norm, (r, alone, speed)))
        contacts = ratio(np.linalg.norm(residual), size)
        inertia, push = self.M @ v, self.H.T @ r
        size = max(map(np.linalg.norm, (self.f, inertia, push)))
        momentum = ratio(np.linalg.norm(inertia + self.f - push), size)
        return max(contacts, momentum)


def seconds_for_delassus(M, H):
    best = float("inf")
    for _ in range(500):
        start = time.perf_counter()
        factor, _ = lapack.dpotrf(M, lower=1)
        X, _ = lapack.dtrtrs(factor, H.T, lower=1)
        blas.dgemm(1.0, X, X, trans_a=1)
        best = min(best, time.perf_counter() - start)
    return best


def ratio(a, b):
    return 0.0 if a == 0.0 else a / b


def lifted(u, mu):
    """`û`, with the De Saxcé shift."""
    return np.concatenate([[u[0] + mu * np.linalg.norm(u[1:])], u[1:]])


def project(x, mu):
    """Onto `K_mu`, Eq. (1)."""
    length = np.linalg.norm(x[1:])
    if x[0] >= 0.0 and length <= mu * x[0]:
        return x
    if mu * length <= -x[0]:
        return np.zeros_like(x)
    along = (x[0] + mu * length) / (1.0 + mu * mu)
    return np.concatenate([[along], along * mu * x[1:] / length])
