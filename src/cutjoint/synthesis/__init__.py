"""Synthesis: lengths, mounting and masses of a robot chosen for what it shall be able to do."""

from cutjoint.synthesis.file import SynthesisOrder, problem_of, read_order
from cutjoint.synthesis.judging import Design, DesignProblem, closed, judged
from cutjoint.synthesis.quantities import QUANTITIES, QuantityRow, Subject
from cutjoint.synthesis.result import Synthesis
from cutjoint.synthesis.synthesise import synthesise
from cutjoint.synthesis.variables import Variable, chosen
from cutjoint.synthesis.wants import Want

__all__ = [
    "QUANTITIES",
    "Design",
    "DesignProblem",
    "QuantityRow",
    "Subject",
    "Synthesis",
    "SynthesisOrder",
    "Variable",
    "Want",
    "chosen",
    "closed",
    "judged",
    "problem_of",
    "read_order",
    "synthesise",
]
