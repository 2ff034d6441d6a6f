from typing import Any, final

from numpy.typing import NDArray

from ._arrays import Scene

__all__ = ["SIZES", "Gather", "Kernel", "LookAhead", "batch_shape", "solve", "solve_batch"]

SIZES: list[tuple[int, int, int, int, int]]

_Settings = tuple[Any, Any, bool]

@final
class Kernel:
    def __new__(cls, counts: list[int], surfaces: bool, single: bool) -> Kernel: ...
    @property
    def size(self) -> tuple[int, int, int, int, int]: ...
    def solve(self, scene: Scene, settings: _Settings) -> tuple[Any, ...]: ...
    def resume(self, settings: _Settings) -> tuple[Any, ...]: ...
    def reset(self) -> None: ...
    def start(self, keys: NDArray[Any], impulses: NDArray[Any]) -> None: ...

@final
class Gather:
    def __new__(cls, nv: int, joint_margins: list[float], tendon_margins: list[float]) -> Gather: ...
    @property
    def modes(self) -> list[int]: ...
    def reset(self) -> None: ...
    def step(
        self,
        metric: NDArray[Any],
        state: tuple[NDArray[Any], ...],
        constraints: tuple[NDArray[Any], ...],
        contacts: tuple[NDArray[Any], ...],
        written: tuple[NDArray[Any], ...],
        look_ahead: LookAhead,
        numbers: tuple[float, float, float],
        settings: tuple[float, int],
    ) -> tuple[int, float, int, bool, int]: ...

@final
class LookAhead:
    def __new__(
        cls, margins: list[list[float]], geoms: list[tuple[int, int, float]], pairs: list[tuple[int, int]], least: float
    ) -> LookAhead: ...
    def keep(self, velocity: NDArray[Any]) -> None: ...
    def is_pushed(self, velocity: NDArray[Any]) -> bool: ...
    def set(
        self,
        motion: tuple[NDArray[Any], ...],
        margins: list[NDArray[Any]],
        step: float,
        gravity: NDArray[Any],
        fixed: float | None,
    ) -> None: ...

def solve(scene: Scene, settings: _Settings, single: bool) -> tuple[Any, ...]: ...
def batch_shape(scenes: Scene, single: bool) -> tuple[int, int, int, int, int]: ...
def solve_batch(scenes: Scene, settings: _Settings, threads: int, out: tuple[NDArray[Any], ...], single: bool) -> None: ...
