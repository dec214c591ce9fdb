"""Writing LLVM assembly: instructions on one number, or on a vector of them side by side."""

from __future__ import annotations

import struct


class Writer:
    """Collects instructions and hands out names."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._count = 0

    def emit(self, instruction: str) -> str:
        """Write an instruction that has a value; returns its name."""
        name = f"%v{self._count}"
        self._count += 1
        self.lines.append(f"  {name} = {instruction}")
        return name

    def do(self, instruction: str) -> None:
        """Write an instruction without a value, or a label."""
        self.lines.append(instruction if instruction.endswith(":") else f"  {instruction}")


class Lanes:
    """Writes instructions on doubles (`lanes` 1) or vectors of them, without any fast-math flag.

    Names of types, for instructions that are written out: `type`, `whole` and `boolean` numbers, `suffix` of functions.
    """

    def __init__(self, out: Writer, lanes: int, *, fused: bool = True) -> None:
        self.out, self.lanes, self.fused, self.align = out, lanes, fused, 8 * lanes
        self.type = "double" if lanes == 1 else f"<{lanes} x double>"
        self.whole = "i64" if lanes == 1 else f"<{lanes} x i64>"
        self.boolean = "i1" if lanes == 1 else f"<{lanes} x i1>"
        self.suffix = "f64" if lanes == 1 else f"v{lanes}f64"

    def constant(self, value: float) -> str:
        """A literal, the same in every lane."""
        literal = f"0x{int.from_bytes(struct.pack('>d', value), 'big'):016X}"
        return literal if self.lanes == 1 else "<" + ", ".join([f"double {literal}"] * self.lanes) + ">"

    def integer(self, value: int) -> str:
        """A whole literal, the same in every lane."""
        return str(value) if self.lanes == 1 else "<" + ", ".join([f"i64 {value}"] * self.lanes) + ">"

    def add(self, x: str, y: str) -> str:
        return self.out.emit(f"fadd {self.type} {x}, {y}")

    def sub(self, x: str, y: str) -> str:
        return self.out.emit(f"fsub {self.type} {x}, {y}")

    def mul(self, x: str, y: str) -> str:
        return self.out.emit(f"fmul {self.type} {x}, {y}")

    def fma(self, x: str, y: str, z: str) -> str:
        """x y + z, rounded once where the processor can."""
        if not self.fused:
            return self.add(self.mul(x, y), z)
        t = self.type
        return self.out.emit(f"call {t} @llvm.fma.{self.suffix}({t} {x}, {t} {y}, {t} {z})")

    def absolute(self, x: str) -> str:
        return self.out.emit(f"call {self.type} @llvm.fabs.{self.suffix}({self.type} {x})")

    def choose(self, mask: str, x: str, y: str) -> str:
        """x where the mask is set, else y."""
        return self.out.emit(f"select {self.boolean} {mask}, {self.type} {x}, {self.type} {y}")

    def polynomial(self, coefficients: tuple[float, ...], x: str) -> str:
        """Horner."""
        total = self.constant(coefficients[-1])
        for coefficient in reversed(coefficients[:-1]):
            total = self.fma(total, x, self.constant(coefficient))
        return total

    def spread(self, scalar: str) -> str:
        """A double in every lane."""
        if self.lanes == 1:
            return scalar
        one = self.out.emit(f"insertelement {self.type} poison, double {scalar}, i32 0")
        mask = f"<{self.lanes} x i32> zeroinitializer"
        return self.out.emit(f"shufflevector {self.type} {one}, {self.type} poison, {mask}")

    def room(self, count: int) -> str:
        """Place on the stack for so many numbers."""
        return self.out.emit(f"alloca {self.type}, i64 {max(count, 1)}, align {self.align}")

    def at(self, base: str, index: int | str) -> str:
        """Address of a number."""
        return self.out.emit(f"getelementptr {self.type}, ptr {base}, i64 {index}")

    def load(self, base: str, index: int | str) -> str:
        """A number in memory."""
        return self.out.emit(f"load {self.type}, ptr {self.at(base, index)}, align {self.align}")

    def store(self, base: str, index: int | str, value: str) -> None:
        """Put a number into memory."""
        self.out.do(f"store {self.type} {value}, ptr {self.at(base, index)}, align {self.align}")
