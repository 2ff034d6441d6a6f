"""Cycles of a Cortex-M4F for instructions in the order in which they were executed: a model.

The numbers are those of Arm's Cortex-M4 Technical Reference Manual: "Cortex-M4 instructions", "Load/store timings", "FPU instruction set".
An instruction takes its cycles of the tables. Then come the rules between neighbours:

- A load or store behind a load takes one cycle less, unless its address is what was loaded. Nothing follows a store in this way.
- A store with an immediate offset takes one cycle. Several words take one more each, and neighbours change nothing.
- What floating-point arithmetic has computed takes one cycle more if the next instruction needs it, unless as an addend.
- A branch that is taken, and whatever else goes elsewhere, refills the pipeline: P cycles, 1 to 3.
"""
import re
from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass, field

ACCUMULATE = {"vfma", "vfms", "vfnma", "vfnms", "vmla", "vmls", "vnmla", "vnmls"}
ARITHMETIC = {"vadd", "vsub", "vmul", "vnmul", "vcvt", "vcvtr"}
COMPARE = {"cmp", "cmn", "tst", "teq", "vcmp", "vcmpe", "vmsr", "msr"}  # write no register of the core
ONE_CYCLE = COMPARE | ARITHMETIC | {
    "mov", "movs", "movw", "movt", "mvn", "mvns", "adr", "add", "adds", "addw", "adc", "adcs", "sub", "subs", "subw", "sbc", "sbcs", "rsb", "rsbs",
    "neg", "negs", "and", "ands", "orr", "orrs", "orn", "orns", "eor", "eors", "bic", "bics", "lsl", "lsls", "lsr", "lsrs", "asr", "asrs", "ror",
    "rors", "rrx", "rrxs", "mul", "muls", "mla", "mls", "smull", "umull", "smlal", "umlal", "umaal", "smulbb", "smlabb", "clz", "rbit", "rev",
    "rev16", "revsh", "uxtb", "uxth", "sxtb", "sxth", "uxtab", "uxtah", "sxtab", "sxtah", "uxtb16", "ubfx", "sbfx", "bfi", "bfc", "usat", "ssat",
    "sel", "uadd8", "usub8", "uqadd8", "uqsub8", "uadd16", "usub16", "uqadd16", "uqsub16", "pkhbt", "pkhtb", "nop", "mrs", "bkpt", "udf", "vmov", "vmrs", "vabs", "vneg"}
MANY = {"ldm", "ldmia", "ldmdb", "pop", "vldm", "vldmia", "vldmdb", "vpop", "stm", "stmia", "stmdb", "push", "vstm", "vstmia", "vstmdb", "vpush"}
BRANCHES = {"b", "bx", "bl", "blx", "cbz", "cbnz"}
CONDITION = r"(eq|ne|cs|hs|cc|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)$"
NAMES = {"sl": "r10", "fp": "r11", "ip": "r12"}


@dataclass(frozen=True)
class Instruction:
    """One instruction of an image: where it stands, its cycles alone, and what the rules between neighbours ask for."""

    address: int
    size: int
    cycles: int
    kind: str = "other"  # or load, store: single ones
    reads: frozenset[str] = frozenset()  # what must be there when it starts: not an addend
    base: frozenset[str] = frozenset()  # what makes its address
    writes: frozenset[str] = frozenset()
    arithmetic: bool = False  # of the FPU
    literal: int | None = None  # where it loads a constant from, in flash


def registers(text: str) -> frozenset[str]:
    """The registers that a text names; ranges written out, doubles as two singles."""
    found: list[str] = []
    for first, last in re.findall(r"\b([rsd]\d+|sl|fp|ip|sp|lr|pc)\b(?:-([rsd]\d+|sl|fp|ip)\b)?", text):
        first, last = NAMES.get(first, first), NAMES.get(last, last)
        span = [first[0] + str(i) for i in range(int(first[1:]), int(last[1:]) + 1)] if last else [first]
        for name in span:
            number = 2 * int(name[1:]) if name[0] == "d" else 0
            found += [f"s{number}", f"s{number + 1}"] if name[0] == "d" else [name]
    return frozenset(found)


def base_name(mnemonic: str) -> str:
    """A mnemonic without width, type and condition."""
    name = mnemonic.split(".")[0]
    if re.fullmatch("it[te]{0,3}", name):
        return "nop"
    known = ONE_CYCLE | ACCUMULATE | MANY | BRANCHES | {"vdiv", "vsqrt", "sdiv", "udiv", "tbb", "tbh", "dmb", "dsb", "isb"}
    return name if name in known or name.startswith(("ldr", "str", "vldr", "vstr")) else re.sub(CONDITION, "", name)


def decode(address: int, size: int, mnemonic: str, operands: str, divide: int) -> Instruction:
    """An instruction of a disassembly; an integer division takes `divide` cycles, 2 to 12. `ValueError` if the tables do not have it."""
    name = base_name(mnemonic)
    operands = operands.split(";")[0].split("@")[0].strip()
    first, _, rest = operands.partition(",")
    all_of, written, read = registers(operands), registers(first), registers(rest)
    if name in MANY:
        listed = registers(operands[operands.index("{"):])
        loads = "ld" in name or "pop" in name
        return Instruction(address, size, 1 + len(listed), reads=all_of - listed if loads else all_of, writes=listed if loads else frozenset())
    if name.startswith(("ldr", "str", "vldr", "vstr")):
        inside = operands[operands.index("["):]
        base, moved = registers(inside), registers(operands[: operands.index("[")])
        loads = "ld" in name[:3]
        needs, gives = (base, moved) if loads else (all_of, frozenset())
        if len(moved) == 2:
            return Instruction(address, size, 3, reads=needs, base=base, writes=gives)
        if not loads:
            return Instruction(address, size, 1 if len(base) == 1 else 2, "store", needs, base)
        offset = re.match(r"\[pc(?:, #(-?\d+))?\]", inside)
        literal = (address + 4 & ~3) + int(offset.group(1) or 0) if offset else None
        return Instruction(address, size, 2, "load", needs, base, gives, literal=literal)
    if name in BRANCHES:
        return Instruction(address, size, 1, reads=all_of)
    if name in ("tbb", "tbh"):
        return Instruction(address, size, 2, reads=all_of)
    if ".f64" in mnemonic and name != "vmov":
        raise ValueError(f"{mnemonic} {operands}: a Cortex-M4F has no double precision")
    if name in ACCUMULATE:
        return Instruction(address, size, 3, reads=read, writes=written, arithmetic=True)
    if name in ("vdiv", "vsqrt"):
        return Instruction(address, size, 14, reads=read, writes=written, arithmetic=True)
    if name in ("sdiv", "udiv"):
        return Instruction(address, size, divide, reads=read or all_of, writes=written)
    if name == "vmov" and len(operands.split(",")) > 2:  # two words between core and FPU
        return Instruction(address, size, 2, reads=all_of)
    if name in ("smull", "umull", "smlal", "umlal", "umaal"):
        return Instruction(address, size, 1, reads=all_of)
    if name in ("dmb", "dsb", "isb") or name not in ONE_CYCLE:
        raise ValueError(f"{mnemonic} {operands}: not in the tables")
    if name in COMPARE:
        return Instruction(address, size, 1, reads=all_of)
    return Instruction(address, size, 1, reads=read, writes=written, arithmetic=name in ARITHMETIC)


def cycles_after(before: Instruction, now: Instruction, refill: int) -> int:
    """Cycles of an instruction that follows another one."""
    cycles = now.cycles
    if now.address != before.address + before.size:
        cycles += refill
    if before.kind == "load" and now.kind in ("load", "store") and not before.writes & now.base:
        cycles = max(cycles - 1, 1)
    if before.arithmetic and before.writes & now.reads:
        cycles += 1
    return cycles


@dataclass
class Flash:
    """Flash with wait states behind a cache of lines of 16 bytes, the least recently used one leaving: as in an STM32F4 (64 lines of
    code, 8 of constants). Nothing is fetched ahead."""

    wait_states: int
    code_lines: int = 64
    constant_lines: int = 8
    waited: int = 0
    code: OrderedDict[int, None] = field(default_factory=OrderedDict)
    constants: OrderedDict[int, None] = field(default_factory=OrderedDict)

    def touch(self, cache: OrderedDict[int, None], lines: int, line: int) -> None:
        """A line is needed."""
        if line in cache:
            cache.move_to_end(line)
            return
        self.waited += self.wait_states
        cache[line] = None
        if len(cache) > lines:
            cache.popitem(last=False)

    def run(self, executed: Iterable[Instruction]) -> int:
        """Cycles that these instructions wait, from an empty cache."""
        last = -1
        for now in executed:
            for line in (now.address >> 4, (now.address + now.size - 1) >> 4):
                if line != last:
                    self.touch(self.code, self.code_lines, line)
                    last = line
            if now.literal is not None:
                self.touch(self.constants, self.constant_lines, now.literal >> 4)
        return self.waited
