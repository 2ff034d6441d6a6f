"""A solve that PyTorch differentiates, backward. Who imports this module imports PyTorch."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch

from ._kernel import solve as _solve


class _Solve(torch.autograd.Function):  # type: ignore[misc]
    @staticmethod
    def forward(ctx: Any, *tensors: Any) -> tuple[Any, Any]:
        ctx.like = tensors
        ctx.found = _solve(*(np.array(tensor.detach().cpu(), np.float64) for tensor in tensors), tol=1e-9)
        return tensors[2].new_tensor(ctx.found.v), tensors[2].new_tensor(ctx.found.r)

    @staticmethod
    def backward(ctx: Any, v: Any, r: Any) -> tuple[Any, ...]:
        found = ctx.found.vjp(v=v.detach().cpu().double().numpy(), r=r.detach().cpu().double().numpy())
        gradients = (found.M, found.H, found.free_impulse, found.w, found.mu)
        return tuple(like.new_tensor(own).reshape(like.shape) for like, own in zip(ctx.like, gradients, strict=True))


def solve(M: Any, H: Any, free_impulse: Any, w: Any, mu: Any) -> tuple[Any, Any]:
    """Velocity and impulses of :func:`stiction.solve` to 1e-9, for tensors.

    Args:
        M: generalised mass matrix, ``(n, n)``; kg, kg·m, kg·m² by the units of the velocities.
        H: contact Jacobians, ``(c, d, n)`` or ``(c·d, n)``, rows with the normal first; 1 or m.
        free_impulse: ``M v + h F``, ``(n,)``; N·s, N·m·s.
        w: offsets, ``(c, d)``; m/s.
        mu: friction coefficients, ``(c,)``, no unit.

    Returns:
        The velocity at the end of the step, ``(n,)``, m/s and rad/s, and the contact impulses, ``(c, d)``, N·s, normal first.
    """
    found: tuple[Any, Any] = _Solve.apply(M, H, free_impulse, w, mu)
    return found
