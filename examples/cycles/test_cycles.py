#!/usr/bin/env python3
"""Holds the model to loops whose cycles the manual gives (`loops.s`), and to what it must not do. Needs an assembler for Arm and QEMU."""
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

from cycles import QUICK, SLOW, Image, calls, cost
from model import Flash, decode

HERE = Path(__file__).parent


class Loops(unittest.TestCase):
    """Every loop, with quick and slow refills and divisions."""

    def test_as_the_manual_says(self) -> None:
        source = (HERE / "loops.s").read_text()
        expected = dict(re.findall(r"^loop (\w+) +@ = (.*)$", source, re.MULTILINE))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "loops"
            build = ["arm-none-eabi-gcc", "-nostdlib", "-Wl,--section-start=.vectors=0,-Ttext=0x1000,-e,reset", str(HERE / "loops.s"), "-o", str(path)]
            subprocess.run(build, check=True)
            image = Image(path)
            found, _ = calls(path, image, "^loop_")
        self.assertEqual([call.name for call in found], [f"loop_{name}" for name in expected])
        for call, formula in zip(found, expected.values()):
            it = cost(image, call, wait_states=0)
            for cycles, setting in ((it.quick, QUICK), (it.slow, SLOW)):
                wanted = eval(formula, {"P": setting["refill"], "D": setting["divide"]})  # of our own file
                with self.subTest(call.name, **setting):
                    self.assertEqual(cycles, wanted, formula)


class Wait(unittest.TestCase):
    """Flash with wait states, by hand."""

    def test_a_loop_waits_once_for_each_line(self) -> None:
        loop = [decode(address, 2, "nop", "", 12) for address in range(0, 64, 2)]
        self.assertEqual(Flash(5).run(loop * 10), 4 * 5)

    def test_a_loop_larger_than_the_cache_waits_each_time(self) -> None:
        loop = [decode(address, 2, "nop", "", 12) for address in range(0, 65 * 16, 2)]
        self.assertEqual(Flash(5).run(loop * 10), 10 * 65 * 5)


class Unknown(unittest.TestCase):
    """What the tables do not have is no guess."""

    def test_it_is_refused(self) -> None:
        for mnemonic, operands in (("vadd.f64", "d0, d1, d2"), ("vrintz.f32", "s0, s1"), ("frobnicate", "r0")):
            with self.subTest(mnemonic), self.assertRaises(ValueError):
                decode(0, 4, mnemonic, operands, 12)


if __name__ == "__main__":
    unittest.main()
