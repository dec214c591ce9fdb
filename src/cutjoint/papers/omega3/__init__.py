"""The Omega-3 (a DELTA robot), reduced model.

C. F. Adetu, C. A. Moore, R. G. Roberts: Dynamic Modeling and Control of the Omega-3 Parallel Manipulator.
Florida A&M University and Florida State University.
"""

from cutjoint.papers.omega3.model import Omega3Model
from cutjoint.papers.omega3.parameters import Omega3Parameters

Parameters = Omega3Parameters

__all__ = ["Omega3Model", "Omega3Parameters", "Parameters"]
