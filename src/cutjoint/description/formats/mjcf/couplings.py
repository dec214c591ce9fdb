"""Linear relations among joints as couplings: which joint of each follows the others.

MuJoCo ties joints by equations, in any number and order; a coupling says one coordinate by others, none of which may
follow it in turn.  Where the wish for a follower cannot be met, the relation is rewritten in joints that are free.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from cutjoint.description.model import Coupling, Place
from cutjoint.findings import Findings

_NOTHING = 1e-12
"""Coefficients below this, times the largest of a relation, are rounding."""


@dataclass(frozen=True)
class Relation:
    """sum of `terms` (joint -> coefficient) = `constant`; `wished` are followers in the order of preference."""

    name: str
    terms: Mapping[str, float]
    constant: float
    wished: Sequence[str]
    what: str
    place: Place


@dataclass
class Followers:
    """The couplings so far."""

    findings: Findings
    couplings: dict[str, Coupling] = field(default_factory=dict)
    """Follower -> its coupling."""

    def follow(self, coupling: Coupling, what: str) -> None:
        """Take a coupling as it is, or note that it cannot be."""
        if coupling.joint in self.couplings or coupling.joint in self._above(coupling.drivers):
            found = f"{what} says '{coupling.joint}' by {', '.join(coupling.drivers)}, which another says already"
            self.findings.error(found, "one equality a joint", "remove one of the two", coupling.place)
        else:
            self.couplings[coupling.joint] = coupling

    def relate(self, relation: Relation) -> None:
        """Take a relation as the coupling of one of its joints."""
        terms = {joint: value for joint, value in relation.terms.items() if value != 0.0}
        constant = relation.constant
        follower = self.free(terms, relation.wished)
        if follower is None:
            terms, constant = self.reduced(terms, constant)
            follower = self.free(terms, [*relation.wished, *terms])
        if follower is not None:
            ratios = {joint: -value / terms[follower] for joint, value in terms.items() if joint != follower}
            offset = constant / terms[follower]
            self.couplings[follower] = Coupling.summed(relation.name, follower, ratios, offset, relation.place)
        elif not terms and abs(constant) <= 1e-9:
            self.findings.warn(f"{relation.what} follows from the others", "", "", relation.place)
        else:
            found, expected = f"{relation.what} contradicts the others", "equalities that can all be met"
            self.findings.error(found, expected, "remove one of them", relation.place)

    def reduced(self, terms: Mapping[str, float], constant: float) -> tuple[dict[str, float], float]:
        """The same relation in joints that do not follow others along straight lines."""
        left, largest = dict(terms), max(map(abs, terms.values()), default=0.0)
        while True:
            follower = next(
                (one for one in left if one in self.couplings and self.couplings[one].ratios is not None), ""
            )
            coupling = self.couplings.get(follower)
            if coupling is None or coupling.ratios is None:
                return {one: value for one, value in left.items() if abs(value) > _NOTHING * largest}, constant
            value = left.pop(follower)
            constant -= value * coupling.offset
            for driver, ratio in coupling.ratios.items():
                left[driver] = left.get(driver, 0.0) + value * ratio
                largest = max(largest, abs(value * ratio))

    def free(self, terms: Mapping[str, float], wished: Sequence[str]) -> str | None:
        """The first wished joint of a relation that follows nothing, and that none of the others follows."""
        for joint in wished:
            others = [one for one in terms if one != joint]
            if joint in terms and joint not in self.couplings and joint not in self._above(others):
                return joint
        return None

    def _above(self, joints: Sequence[str]) -> set[str]:
        """Some joints and all that they follow."""
        found, left = set[str](), list(joints)
        while left:
            joint = left.pop()
            if joint not in found:
                found.add(joint)
                left += self.couplings[joint].drivers if joint in self.couplings else ()
        return found
