"""Scene files: the arguments of :func:`stiction.solve` as JSON."""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays
from ._types import Rows

_KINDS = {(0.0, np.inf): "limit", (-np.inf, np.inf): "equality"}


def load(path: str | PathLike[str]) -> dict[str, Any]:
    """Read a scene file: ``stiction.solve(**stiction.load(path))`` solves it.

    Args:
        path: the file, of one scene.

    Returns:
        ``M``, ``H``, ``free_impulse``, ``w``, ``mu``, and ``rows`` and ``compliance`` where the file has them.

    Raises:
        ValueError: a key is unknown or missing, or an array has another shape than the counts say; its name comes first.
        OSError: the file cannot be read.
    """
    file = _read(path)
    if "problems" in file:
        raise ValueError("problems: this is a sequence, for load_sequence")
    return _arguments(file)


def load_sequence(path: str | PathLike[str]) -> list[dict[str, Any]]:
    """Read the time steps of a sequence, each as of :func:`load`.

    Args:
        path: the file, with the time steps under ``problems``.

    Returns:
        Arguments of :meth:`stiction.Kernel.solve`, step by step.

    Raises:
        ValueError: as of :func:`load`.
        OSError: the file cannot be read.
    """
    file = _read(path)
    if "problems" not in file:
        raise ValueError("problems: this is one scene, for load")
    shared: dict[str, Any] = {key: file[key] for key in ("n_dof", "dim") if key in file}
    return [_arguments({**shared, **step}) for step in file["problems"]]


def save(
    path: str | PathLike[str],
    M: ArrayLike,
    H: ArrayLike,
    free_impulse: ArrayLike,
    w: ArrayLike,
    mu: ArrayLike,
    *,
    rows: Rows | None = None,
    compliance: ArrayLike | None = None,
    h: float | None = None,
) -> None:
    """Write a scene file, for :func:`load` and for the program ``solve``.

    Args:
        path: the file; one that is there is replaced.
        M: mass matrix, ``(n, n)``; kg, kg·m, kg·m².
        H: contact Jacobians, ``(c, d, n)``, rows with the normal first; 1 or m.
        free_impulse: ``M v_free``, ``(n,)``; N·s, N·m·s.
        w: offsets, ``(c, d)``; m/s.
        mu: friction coefficients, one number, ``(c,)`` or ``(c, d - 1)``.
        rows: joint rows.
        compliance: one number, ``(c,)`` or ``(c, 2)``: along the normal and along the tangents, 1/kg; ``None`` is rigid.
        h: time step, s, from which ``solve --json`` computes forces.

    Raises:
        ValueError: an array has the wrong shape, or is not finite; its name comes first.
        OSError: the file cannot be written.
    """
    jacobian = _arrays.jacobians(H)
    c, d, n = jacobian.shape
    friction = np.asarray(mu, float)
    scene: dict[str, Any] = {"n_dof": n, "n_contacts": c, "dim": d}
    if h is not None:
        scene["h"] = float(h)
    scene["M"] = _checked("M", M, (n, n))
    scene["H"] = _checked("H", jacobian.reshape(c * d, n), (c * d, n))
    scene["free_impulse"] = _checked("free_impulse", free_impulse, (n,))
    scene["w"] = _checked("w", np.reshape(w, -1), (c * d,))
    scene["mu"] = _checked("mu", friction, (c, d - 1) if friction.ndim == 2 else (c,))
    if compliance is not None:
        scene["compliance"] = _checked("compliance", _arrays.both_ways(compliance, c, _arrays.DOUBLE, 0), (c, 2))
    if rows is not None:
        scene["joints"] = _joints(rows, n)
    Path(path).write_text(json.dumps(scene))


def _joints(rows: Rows, n: int) -> list[dict[str, Any]]:
    jacobian = np.asarray(rows.jacobian, float)
    k = len(jacobian)
    entries = _checked("rows.jacobian", jacobian, (k, n))
    offset, compliance = (_checked(f"rows.{name}", getattr(rows, name), (k,)) for name in ("offset", "compliance"))
    lower, upper = (np.broadcast_to(np.asarray(bound, float), (k,)) for bound in (rows.lower, rows.upper))
    joints = []
    for i in range(k):
        kind = _KINDS.get((lower[i], upper[i]), "box")
        joint = {"kind": kind, "row": entries[i], "offset": offset[i], "compliance": compliance[i]}
        if kind == "box":
            joint["lower"], joint["upper"] = (
                _checked(f"rows.{name}", one[i], ()) for name, one in (("lower", lower), ("upper", upper))
            )
        joints.append(joint)
    return joints


def _checked(name: str, given: ArrayLike, shape: tuple[int, ...]) -> Any:
    """Lists of numbers in this shape."""
    try:
        found = np.broadcast_to(np.asarray(given, float), shape)
    except ValueError:
        raise ValueError(f"{name}: shape {list(np.shape(given))} is not {list(shape)}") from None
    if not np.isfinite(found).all():
        raise ValueError(f"{name}: it is not finite")
    return found.tolist()


def _read(path: str | PathLike[str]) -> dict[str, Any]:
    """The file, all of whose keys are known."""

    def refuse(word: str) -> None:
        raise ValueError(f"{word}: not a finite number")

    file = json.loads(Path(path).read_text(), parse_constant=refuse)
    if not isinstance(file, dict):
        raise ValueError(f"{path}: not an object")
    known = _schema()["properties"]
    for part in [file, *file.get("problems", [])]:
        _check_keys(part, known, "")
        for joint in part.get("joints", []):
            _check_keys(joint, known["joints"]["items"]["properties"], "joints: ")
    return file


@cache
def _schema() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(files("stiction").joinpath("scene.schema.json").read_text())
    return found


def _check_keys(given: dict[str, Any], known: dict[str, Any], where: str) -> None:
    unknown = next((key for key in given if key not in known), None)
    if unknown is not None:
        raise ValueError(f"{where}{unknown}: a scene file has no such key")


def _arguments(scene: dict[str, Any]) -> dict[str, Any]:
    """Arguments of a solve."""
    missing = next((key for key in _schema()["else"]["required"] if key not in scene), None)
    if missing:
        raise ValueError(f"{missing}: it is missing")
    if "f" not in scene and "free_impulse" not in scene:
        raise ValueError("free_impulse: it is missing, and so is f, its negative")
    if "f" in scene and "free_impulse" in scene:
        raise ValueError("free_impulse and f: one is the negative of the other, give one")
    for key in ("n_dof", "n_contacts", "dim"):
        if not isinstance(scene[key], int):
            raise ValueError(f"{key}: {scene[key]!r} is no number of them")
    n, c, d = scene["n_dof"], scene["n_contacts"], scene["dim"]
    if "h" in scene and not 0.0 < _shaped("h", scene["h"], ()) < np.inf:
        raise ValueError(f"h: {scene['h']} is no time step")
    sign, own = (1.0, "free_impulse") if "free_impulse" in scene else (-1.0, "f")
    mu = scene["mu"]
    if isinstance(mu, list) and any(isinstance(entry, list) for entry in mu):
        mu = [entry if isinstance(entry, list) else [entry] * (d - 1) for entry in mu]
        coefficients = _shaped("mu", mu, (c, d - 1))
    else:
        coefficients = _shaped("mu", mu, (c,))
    arguments = {
        "M": _shaped("M", scene["M"], (n, n)),
        "H": _shaped("H", scene["H"], (c * d, n)).reshape(c, d, n),
        "free_impulse": _shaped(own, scene[own], (n,)) * sign,
        "w": _shaped("w", scene["w"], (c * d,)).reshape(c, d),
        "mu": coefficients,
    }
    if "compliance" in scene:
        arguments["compliance"] = _shaped("compliance", scene["compliance"], (c, 2))
    if scene.get("joints"):
        arguments["rows"] = _rows(scene["joints"], n)
    return arguments


def _shaped(key: str, given: Any, shape: tuple[int, ...]) -> Any:
    """Numbers in this shape."""
    try:
        found = np.array(given, float)
    except (TypeError, ValueError):
        raise ValueError(f"{key}: these are not numbers, as many in each list") from None
    if found.shape != shape and found.size + np.prod(shape) > 0:
        raise ValueError(f"{key}: shape {list(found.shape)} is not {list(shape)}")
    return found.reshape(shape)


def _rows(joints: list[dict[str, Any]], n: int) -> Rows:
    bounds = {kind: bound for bound, kind in _KINDS.items()}
    for joint in joints:
        kind = joint.get("kind")
        if kind != "box" and kind not in bounds:
            raise ValueError(f"joints: kind {kind!r} is not limit, equality or box")
        missing = next((key for key in ("row", "offset", *(("lower", "upper") if kind == "box" else ())) if key not in joint), None)
        if missing:
            raise ValueError(f"joints: {missing}: it is missing")
    pairs = [bounds.get(joint["kind"]) or (joint["lower"], joint["upper"]) for joint in joints]
    k = len(joints)
    return Rows(
        jacobian=_shaped("joints: row", [joint["row"] for joint in joints], (k, n)),
        offset=_shaped("joints: offset", [joint["offset"] for joint in joints], (k,)),
        lower=_shaped("joints: lower", [lower for lower, _ in pairs], (k,)),
        upper=_shaped("joints: upper", [upper for _, upper in pairs], (k,)),
        compliance=_shaped("joints: compliance", [joint.get("compliance", 0.0) for joint in joints], (k,)),
        keys=np.arange(k),
    )
