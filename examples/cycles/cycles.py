#!/usr/bin/env python3
"""Cycles of a Cortex-M4F, modelled (`model.py`) for each call of a function, from what QEMU executes.

Usage: cycles.py IMAGE [--function REGEX] [--mhz N] [--wait-states N]. Prints a row a call: instructions executed, cycles without wait states
(from quick branches and divisions to slow ones), microseconds. A program that prints a line for each call (`examples/chip_race`) names
the rows so.
"""
import argparse
import re
import subprocess
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from threading import Thread

from model import Flash, Instruction, cycles_after, decode

QUICK, SLOW = {"refill": 1, "divide": 2}, {"refill": 3, "divide": 12}
MACHINE = ["qemu-system-arm", "-M", "mps2-an386", "-cpu", "cortex-m4", "-icount", "shift=10", "-nographic",
           "-semihosting-config", "enable=on,target=native"]
LEFT_OUT = """Left out: what an IT block skips counts as executed, and IT takes a cycle; integer work beside a division or root of the FPU;
contention of literals with fetches; fetches of unaligned 32-bit instructions; data outside one zero-wait RAM; interrupts; DMA."""


@dataclass(frozen=True)
class Call:
    """What one call of a function executed, with where it returned to."""

    name: str
    addresses: list[int]


@dataclass(frozen=True)
class Cost:
    """Instructions of a call, cycles without wait states from and to, cycles with them."""

    instructions: int
    quick: int
    slow: int
    waiting: int


class Image:
    """An ELF file: its symbols and its instructions, which are decoded as they are met."""

    def __init__(self, path: Path) -> None:
        symbols = output(["arm-none-eabi-nm", "-C", str(path)]).splitlines()
        self.functions = {int(a, 16) & ~1: name for a, kind, name in (line.split(None, 2) for line in symbols if line[0] != " ") if kind in "tTW"}
        line = re.compile(r"^ *([0-9a-f]+):\t([0-9a-f ]+?) *\t([a-z0-9.]+)\t?(.*)$")
        matches = filter(None, map(line.match, output(["arm-none-eabi-objdump", "-d", str(path)]).splitlines()))
        self.text = {int(m[1], 16): (len(m[2].replace(" ", "")) // 2, m[3], m[4]) for m in matches}

    def decode(self, address: int, divide: int) -> Instruction:
        """The instruction at an address."""
        return decode(address, *self.text[address], divide)


def output(command: list[str]) -> str:
    """What a program prints."""
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def calls(path: Path, image: Image, function: str) -> tuple[list[Call], list[str]]:
    """Each call of the functions whose name matches, in order, and the lines that the program printed."""
    entries = {address: name for address, name in image.functions.items() if re.search(function, name)}
    if not entries:
        raise SystemExit(f"{path}: no function matches {function}")
    with tempfile.TemporaryDirectory() as folder:
        pipe = Path(folder) / "trace"
        subprocess.run(["mkfifo", str(pipe)], check=True)
        command = [*MACHINE, "-singlestep", "-d", "exec,nochain", "-D", str(pipe), "-kernel", str(path)]
        board = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        printed: list[str] = []
        assert board.stdout is not None
        reader = Thread(target=printed.extend, args=(board.stdout,))
        reader.start()
        found: list[Call] = []
        current: list[int] = []
        before, back = 0, -1
        with pipe.open() as trace:
            for line in trace:
                start = line.find("/")
                if start < 0:
                    continue
                pc = int(line[start + 1:start + 9], 16)
                if back < 0 and pc in entries:
                    back, current = before + image.text[before][0], []
                    found.append(Call(entries[pc], current))
                if back >= 0:
                    current.append(pc)
                    if pc == back:
                        back = -1
                before = pc
        reader.join()
        board.stdout.close()
        if board.wait() != 0:
            raise SystemExit(f"{path}: ended with {board.returncode}")
    return found, printed


def cost(image: Image, call: Call, wait_states: int) -> Cost:
    """The model's cycles of a call, return included."""

    pairs = Counter(zip(call.addresses, call.addresses[1:-1]))

    def without_waiting(refill: int, divide: int) -> int:
        known = {address: image.decode(address, divide) for address in set(call.addresses[:-1])}
        inside = sum(times * cycles_after(known[a], known[b], refill) for (a, b), times in pairs.items())
        return known[call.addresses[0]].cycles + inside + refill  # the last one is of the return

    quick, slow = without_waiting(**QUICK), without_waiting(**SLOW)
    decoded = {address: image.decode(address, SLOW["divide"]) for address in set(call.addresses[:-1])}
    waited = Flash(wait_states).run(decoded[address] for address in call.addresses[:-1])
    return Cost(len(call.addresses) - 1, quick, slow, slow + waited)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("image", type=Path)
    parser.add_argument("--function", default="::measured$|^measured$")
    parser.add_argument("--mhz", type=float, default=168)
    parser.add_argument("--wait-states", type=int, default=5)
    options = parser.parse_args()
    image = Image(options.image)
    found, printed = calls(options.image, image, options.function)
    labels = [" ".join(line.split()[:2]) for line in printed if not line.startswith("bytes")]
    if len(labels) != len(found):
        labels = [call.name for call in found]
    print(f"| call | instructions | cycles, model | µs at {options.mhz:g} MHz, model | µs with {options.wait_states} wait states, model |")
    print("|---|---:|---:|---:|---:|")
    for label, call in zip(labels, found):
        it = cost(image, call, options.wait_states)
        print(f"| {label} | {it.instructions:,} | {it.quick:,} to {it.slow:,} | {it.quick / options.mhz:.0f} to {it.slow / options.mhz:.0f} "
              f"| {it.waiting / options.mhz:.0f} |")
    print(f"\n{LEFT_OUT}")


if __name__ == "__main__":
    main()
