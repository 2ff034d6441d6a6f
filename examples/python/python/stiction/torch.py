"""A solve that PyTorch differentiates, backward. Who imports this module imports PyTorch."""

from __future__ import annotations

from operator import attrgetter
from typing import Any

import torch

from ._kernel import solve as _solve
from ._layers import CONSTANT, arguments, named
from ._types import Rows


class _Solve(torch.autograd.Function):  # type: ignore[misc]
    @staticmethod
    def forward(ctx: Any, names: tuple[str, ...], tol: float, *tensors: Any) -> tuple[Any, Any]:
        ctx.names, ctx.like = names, tensors
        ctx.found = _solve(**arguments(names, (tensor.detach().cpu() for tensor in tensors), Rows), tol=tol)
        return tensors[2].new_tensor(ctx.found.v), tensors[2].new_tensor(ctx.found.r)

    @staticmethod
    def backward(ctx: Any, v: Any, r: Any) -> tuple[Any, ...]:
        found = ctx.found.vjp(v=v.detach().cpu().double().numpy(), r=r.detach().cpu().double().numpy())
        gradients = (None if name == "compliance" else attrgetter(name)(found) for name in ctx.names)
        pairs = zip(ctx.like, gradients, strict=True)
        return None, None, *(own if own is None else like.new_tensor(own).reshape(like.shape) for like, own in pairs)


def solve(
    M: Any,
    H: Any,
    free_impulse: Any,
    w: Any = None,
    mu: Any = None,
    *,
    tol: float = 1e-9,
    rows: Rows | None = None,
    compliance: Any = None,
) -> tuple[Any, Any]:
    """Velocity and impulses of :func:`stiction.solve`, for tensors.

    Args:
        M: generalised mass matrix, ``(n, n)``; kg, kg·m, kg·m² by the units of the velocities.
        H: contact Jacobians, ``(c, d, n)`` or ``(c·d, n)``, rows with the normal first; 1 or m. ``None`` for a scene of joint rows
            alone.
        free_impulse: ``M v + h F``, ``(n,)``; N·s, N·m·s.
        w: offsets, ``(c, d)``; m/s. ``None`` is 0.
        mu: friction coefficients, ``(c,)`` or one number, no unit.
        tol: error up to which the scene counts as solved, relative to the impulses; no unit. A derivative is as exact.
        rows: joint rows, with arrays of PyTorch; it is differentiated by all but keys, which are not read.
        compliance: of contacts, ``(c,)`` or one number, 1/kg; or along the normal and along the tangents, ``(c, 2)``; ``None`` is
            rigid. It is a constant: a derivative by it is refused.

    Returns:
        The velocity at the end of the step, ``(n,)``, m/s and rad/s, and the contact impulses, ``(c, d)``, N·s, normal first.
    """
    if getattr(compliance, "requires_grad", False):
        raise ValueError(CONSTANT)

    def spread(given: Any, shape: tuple[int, ...]) -> Any:
        return torch.as_tensor(given, dtype=free_impulse.dtype, device=free_impulse.device).expand(shape)

    tensors = named((M, H, free_impulse, w, mu), compliance, rows, torch.zeros, spread)
    found: tuple[Any, Any] = _Solve.apply(tuple(tensors), tol, *tensors.values())
    return found
