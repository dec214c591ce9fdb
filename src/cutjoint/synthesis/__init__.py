"""Synthesis: lengths, mounting and masses of a robot chosen for what it shall be able to do."""

from cutjoint.synthesis.file import Order, problem_of, read_order
from cutjoint.synthesis.judging import Design, Problem, closed, judged
from cutjoint.synthesis.quantities import QUANTITIES, QuantityRow, Subject
from cutjoint.synthesis.result import Synthesis
from cutjoint.synthesis.synthesise import synthesise
from cutjoint.synthesis.variables import Variable, chosen
from cutjoint.synthesis.wants import Want

__all__ = [
    "QUANTITIES",
    "Design",
    "Order",
    "Problem",
    "QuantityRow",
    "Subject",
    "Synthesis",
    "Variable",
    "Want",
    "chosen",
    "closed",
    "judged",
    "problem_of",
    "read_order",
    "synthesise",
]
