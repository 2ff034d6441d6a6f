"""Exact Coulomb friction with unilateral contact, for small scenes.

A scene has ``n`` generalised velocities and ``c`` contacts of ``d`` rows each (1 frictionless, 2 planar, 3 spatial, 4 with
a torsional row, 6 with rolling ones). For a mass matrix ``M``, a free impulse ``M v_free``, contact Jacobians ``H_i``, offsets
``w_i`` and friction coefficients ``mu_i`` the solver finds the velocity ``v`` and the contact impulses ``r_i`` with

    M v = M v_free + Hᵀ r,   u_i = H_i v + w_i,   K*_mu ∋ u_i + mu_i |u_Ti| e_N ⟂ r_i ∈ K_mu

in SI units, rows with the normal first. :func:`solve` solves one scene, :func:`solve_batch` many on all cores,
:class:`Kernel` one after the other with warm starts, :mod:`stiction.time_stepping` makes offsets and joint rows,
:meth:`Solution.jvp` and :meth:`Solution.vjp` tell how a solution moves with its data, and :class:`stiction.mujoco.Stepper` steps
MuJoCo's models.
"""

from . import time_stepping
from ._batch import BatchSolution, solve_batch
from ._derivative import Facts, Gradient, RowChange, SolutionChange
from ._kernel import Kernel, solve, solve_delassus
from ._loads import LeastImpulses, rest_reserve
from ._scene_file import load, load_sequence, save
from ._solution import Solution
from ._stiction import SIZES
from ._types import Mode, RowMode, Rows, Status, Work

__all__ = [
    "SIZES",
    "BatchSolution",
    "Facts",
    "Gradient",
    "Kernel",
    "LeastImpulses",
    "Mode",
    "RowChange",
    "RowMode",
    "Rows",
    "Solution",
    "SolutionChange",
    "Status",
    "Work",
    "load",
    "load_sequence",
    "rest_reserve",
    "save",
    "solve",
    "solve_batch",
    "solve_delassus",
    "time_stepping",
]
__version__ = "0.1.0"
