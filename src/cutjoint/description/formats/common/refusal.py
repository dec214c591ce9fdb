"""What is said where a format has no word for a type of joint or cut joint."""

from __future__ import annotations

from cutjoint.description.model import CutJoint, Joint
from cutjoint.errors import InputError


def unsaid(form: str, of: Joint | CutJoint) -> InputError:
    """The error of the format `form`, which has no word for the type of a joint or a cut joint."""
    what = "joint" if isinstance(of, Joint) else "cut"
    remedy = "write loops.toml (--to loops), which knows every type"
    return InputError(f"{form} cannot say {what} type '{of.type.value}' of {what} '{of.name}'; {remedy}")
