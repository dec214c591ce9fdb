"""The model that Table 3 of Elkady et al. 2008 was most likely computed with; it is not the paper's equation (39).

Equation (39) does not give the figures of Table 3, but for the two errors of computed torque, which cancels its model.
A slightly different model gives three more and the gains: the rods count half in the mass matrix (B instead of 2 B) but
fully in the Coriolis term (2 B), and the sliders m3 are missing in the weight E.  The finding is after the fact, so it
is evidence and no proof (docs/errata.md).  The model breaks the skew symmetry of dM/dt - 2 G, so it does not conserve
energy.  Use it to compare with Table 3, for nothing else.
"""

from __future__ import annotations

from typing import NoReturn

import numpy.typing as npt

from cutjoint.errors import InputError
from cutjoint.mechanism import Posture
from cutjoint.papers.cpm.model import CpmModel
from cutjoint.papers.cpm.parameters import CpmCoefficients, CpmParameters


class InferredCpmModel(CpmModel):
    """The CPM as in the inferred code; the same interface, arguments and errors as `CpmModel`."""

    name = "cpm (inferred code)"

    @staticmethod
    def coefficients(parameters: CpmParameters) -> CpmCoefficients:
        """Inertia 2 A + B Gamma' Gamma, Coriolis 2 B Gamma' dGamma/dt, weight without m3."""
        p = parameters
        return CpmCoefficients(2.0 * p.A, p.B, 2.0 * p.B, p.C, (p.m1 + 2.0 * p.m2 + p.m4) * p.g)

    def limb_energies(self, at: Posture, v: npt.ArrayLike) -> NoReturn:
        """None: it is no mechanism.

        Raises:
            InputError: always.
        """
        raise InputError(f"{self.name} is no mechanism and keeps no energy; ask CpmModel for (12) to (17) of the paper")
