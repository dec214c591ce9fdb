"""Certified boxes: a proof that a box of tool coordinates is wholly inside and free of singularities, or a
counter-example."""

from cutjoint.workspace.certified.certificate import Certificate, CounterExample
from cutjoint.workspace.certified.certify import certify

__all__ = ["Certificate", "CounterExample", "certify"]
