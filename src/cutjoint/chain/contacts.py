"""Cuts as Pinocchio's `RigidConstraintModel`s, of those that it has any for: fixed, spherical and revolute ones.

A revolute cut is two coincident points on its axis: six rows of rank five.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pinocchio as pin

from cutjoint.chain.bound import BoundCut
from cutjoint.description.cuts import Kind
from cutjoint.description.model import RobotDescription
from cutjoint.errors import InputError

_CONTACTS: dict[tuple[Kind, ...], tuple[pin.ContactType, tuple[float, ...]]] = {
    (Kind.POINT, Kind.LOCK): (pin.ContactType.CONTACT_6D, (0.0,)),
    (Kind.POINT,): (pin.ContactType.CONTACT_3D, (0.0,)),
    (Kind.POINT, Kind.HINGE): (pin.ContactType.CONTACT_3D, (-0.5, 0.5)),
}
"""The kinds of a cut's equations -> the contact with the same rows, and where along z it acts, in lengths."""


def is_contact(cut: BoundCut) -> bool:
    """Whether Pinocchio has constraint models that hold what a cut holds."""
    return cut.type.kinds in _CONTACTS


def contact_models(model: pin.Model, cuts: Iterable[BoundCut], length: float) -> pin.StdVec_RigidConstraintModel:
    """The constraint models of cuts that are contacts, one after another; a revolute cut has two of its name.

    Args:
        model: the tree that the cuts are bound to.
        length: how far apart the two points of a revolute cut are [m].
    """
    models = pin.StdVec_RigidConstraintModel()
    for cut in cuts:
        kind, shifts = _CONTACTS[cut.type.kinds]
        for shift in shifts:
            offset = pin.SE3(np.eye(3), np.array([0.0, 0.0, shift * length]))
            place_a, place_b = cut.placement_a * offset, cut.placement_b * offset
            constraint = pin.RigidConstraintModel(
                kind, model, cut.joint_a, place_a, cut.joint_b, place_b, pin.ReferenceFrame.LOCAL
            )
            constraint.name = cut.name
            models.append(constraint)
    return models


def constraint_datas(models: Iterable[pin.RigidConstraintModel]) -> pin.StdVec_RigidConstraintData:
    """Fresh workspaces of constraint models, in their order.

    Raises:
        InputError: something else is among them.
    """
    if not isinstance(models, Iterable):
        raise InputError(f"expected RigidConstraintModels, as constraint_models() gives them; found {models!r}")
    datas = pin.StdVec_RigidConstraintData()
    for one in models:
        if not isinstance(one, pin.RigidConstraintModel):
            raise InputError(f"expected RigidConstraintModels, as constraint_models() gives them; found {one!r}")
        datas.append(one.createData())
    return datas


def constraint_models(
    model: pin.Model, description: RobotDescription, length: float
) -> pin.StdVec_RigidConstraintModel:
    """Fresh constraint models of all that closes the loops of a robot, for `model`.

    Raises:
        InputError: a cut or coupling is none in Pinocchio.
    """
    cuts = [BoundCut.of(model, cut) for cut in description.closing]
    others = [f"cut '{cut.name}' ({cut.type})" for cut in cuts if not is_contact(cut)]
    others += [f"coupling '{coupling.name}'" for coupling in description.couplings]
    if others:
        raise InputError(
            f"{description.name} has loops that no RigidConstraintModel of Pinocchio closes: {', '.join(others)}; "
            "fixed, spherical and revolute cuts have one. Take constraint_jacobian(), tangent() and "
            "full_forward_dynamics(), which hold everything"
        )
    return contact_models(model, cuts, length)
