from os import PathLike
from typing import Any, final

from numpy.typing import NDArray

from ._arrays import Scene

__all__ = [
    "SIZES",
    "Kernel",
    "Stepper",
    "batch_shape",
    "bear",
    "check_version",
    "derivative",
    "fingerprint",
    "rollout",
    "solve",
    "solve_batch",
]

SIZES: list[tuple[int, int, int, int, int]]

_Settings = tuple[Any, Any, bool]
_Counts = tuple[int, int, float, int, int, int, int, tuple[int, float, int]]

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
class Stepper:
    def __new__(cls, library: PathLike[str], model: int) -> Stepper: ...
    @property
    def modes(self) -> list[int]: ...
    def reset(self) -> None: ...
    def state(self) -> list[int]: ...
    def set_state(self, data: int | None, state: list[int]) -> None: ...
    def step(self, data: int, steps: int, settings: tuple[float, int]) -> _Counts: ...
    def keep_impulses(self) -> None: ...
    def step1(self, data: int) -> None: ...
    def step2(self, data: int, settings: tuple[float, int]) -> _Counts: ...

def check_version(library: PathLike[str]) -> None: ...
def rollout(
    library: PathLike[str],
    model: int,
    kind: int,
    from_: tuple[NDArray[Any], NDArray[Any]],
    to: tuple[NDArray[Any], ...],
    settings: tuple[float, int],
    threads: int,
) -> None: ...
def solve(scene: Scene, settings: _Settings, single: bool) -> tuple[Any, ...]: ...
def batch_shape(scenes: Scene, single: bool) -> tuple[int, int, int, int, int]: ...
def solve_batch(scenes: Scene, settings: _Settings, threads: int, out: tuple[NDArray[Any], ...], single: bool) -> int: ...
def bear(
    scene: Scene,
    given: _Settings,
    impulses: tuple[NDArray[Any], NDArray[Any]],
    asked: tuple[str, float, float, NDArray[Any]],
) -> NDArray[Any]: ...
def fingerprint(scenes: Scene, is_batch: bool, single: bool) -> int: ...
def derivative(
    scenes: Scene,
    given: _Settings,
    is_batch: bool,
    impulses: tuple[NDArray[Any], NDArray[Any]],
    asked: tuple[NDArray[Any], bool],
    threads: int,
) -> tuple[NDArray[Any], NDArray[Any]]: ...
