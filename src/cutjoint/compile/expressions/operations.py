"""The operations that expressions and programs are made of: a member each."""

from __future__ import annotations

from enum import IntEnum
from typing import Self


class Op(IntEnum):
    """What is computed from the operands a, b, c.

    Attributes:
        arity: number of operands.
        commutes: whether the order of its operands is free.

    The numbers are part of the file format of the cache.
    """

    arity: int
    commutes: bool

    def __new__(cls, number: int, arity: int = 2, commutes: bool = False) -> Self:
        member = int.__new__(cls, number)
        member._value_ = number
        member.arity, member.commutes = arity, commutes
        return member

    # number, arity, commutes
    CONST = 1, 0
    INPUT = 2, 0
    ADD = 3, 2, True
    SUB = 4
    MUL = 5, 2, True
    DIV = 6
    SQRT = 7, 1
    SIN = 8, 1
    COS = 9, 1
    ATAN2 = 10
    ACOS = 11, 1
    ABS = 12, 1
    MIN = 13, 2, True
    MAX = 14, 2, True
    NEG = 15, 1
    FMA = 16, 3
    """a b + c; the fused ones are made by the program, not by the tracer."""
    FMS = 17, 3
    """a b - c"""
    FNMA = 18, 3
    """c - a b"""
    FLOOR = 19, 1
    NEAREST = 20, 1
    """the nearest whole number, of two the even one"""
    LESS = 21
    """1 where a < b, else 0, also where one of them is not a number"""
    AT_MOST = 22
    """1 where a <= b, else 0, also where one of them is not a number"""
    PICK = 23, 3
    """b where a is not 0, else c; what is not picked may be not a number"""
