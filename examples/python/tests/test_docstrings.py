"""Every argument, field and result of the package is described, an array with its shape."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import re
import textwrap
from collections.abc import Iterator
from typing import Any

import pytest

import stiction
import stiction.mujoco
import stiction.time_stepping

MODULES: tuple[Any, ...] = (stiction, stiction.mujoco, stiction.time_stepping)
CLASSES: list[Any] = [found for module in MODULES for name in module.__all__ if inspect.isclass(found := getattr(module, name))]


def functions() -> Iterator[tuple[str, Any]]:
    """All that can be called, by name; of dataclasses, named tuples and enumerations the fields tell instead."""
    for module in MODULES:
        for name in module.__all__:
            if inspect.isfunction(found := getattr(module, name)):
                yield f"{module.__name__}.{name}", found
    for kind in CLASSES:
        for name, found in inspect.getmembers(kind, lambda own: inspect.isfunction(own) or inspect.ismethod(own)):
            if not name.startswith("_") and found.__module__.startswith("stiction"):
                yield f"{kind.__name__}.{name}", found
        if not fields(kind) and "__init__" in vars(kind):
            yield f"{kind.__name__}.__init__", vars(kind)["__init__"]


def fields(kind: Any) -> list[str]:
    if dataclasses.is_dataclass(kind):
        return [field.name for field in dataclasses.fields(kind)]
    return [*getattr(kind, "_fields", ()), *getattr(kind, "__members__", ())]


def described(doc: str) -> dict[str, str]:
    """What ``Args:`` says of each argument."""
    section = textwrap.dedent(doc.partition("Args:\n")[2].partition("\n\n")[0])
    return dict(re.findall(r"^(\w+): (.*(?:\n +.*)*)", section, re.MULTILINE))


def missing(function: Any) -> list[str]:
    """Arguments of which nothing is said, or of an array no shape."""
    said = described(inspect.cleandoc(function.__doc__ or ""))
    arguments = {
        name: str(own.annotation) for name, own in inspect.signature(function).parameters.items() if name not in ("self", "cls")
    }
    short = [name for name in arguments if len(said.get(name, "")) < 8]
    return short + [name for name, kind in arguments.items() if "ArrayLike" in kind and "``(" not in said.get(name, "")]


@pytest.mark.parametrize(("name", "function"), [*functions()])
def test_each_argument_is_described(name: str, function: Any) -> None:
    assert missing(function) == []


@pytest.mark.parametrize("name", ["jax", "torch"])
def test_each_argument_of_a_differentiable_solve_is_described(name: str) -> None:
    pytest.importorskip(name)
    solve = importlib.import_module(f"stiction.{name}").solve
    assert set(described(inspect.cleandoc(solve.__doc__))) == {"M", "H", "free_impulse", "w", "mu", "tol", "rows", "compliance"}


@pytest.mark.parametrize("kind", CLASSES)
def test_each_field_is_described(kind: Any) -> None:
    lines = [line.strip() for line in inspect.getsource(kind).splitlines()]
    for name in fields(kind):
        place = next(i for i, line in enumerate(lines) if re.match(rf"{name}(: | = )", line))
        said = lines[place - 1]
        assert said.startswith("#: ") and len(said) > 4, f"{kind.__name__}.{name}"


def test_what_is_not_described_is_found() -> None:
    def function(M: Any, tol: float, rows: int) -> None:
        pass

    function.__doc__ = "Do nothing.\n\n    Args:\n        M: a mass matrix.\n        tol: ."
    assert missing(function) == ["tol", "rows"]
    function.__annotations__["M"] = "ArrayLike"
    assert missing(function) == ["tol", "rows", "M"]
