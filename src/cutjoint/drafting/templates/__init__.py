"""The templates of `cutjoint new`, a row each."""

from __future__ import annotations

from collections.abc import Mapping

from cutjoint.drafting.template import Size as Size
from cutjoint.drafting.template import Template as Template
from cutjoint.drafting.templates import blank, delta, fivebar, fourbar, leg, stewart

TEMPLATES: Mapping[str, Template] = {
    "fourbar": fourbar.TEMPLATE,
    "fivebar": fivebar.TEMPLATE,
    "delta": delta.TEMPLATE,
    "stewart": stewart.TEMPLATE,
    "leg": leg.TEMPLATE,
    "blank": blank.TEMPLATE,
}
DEFAULT = "fourbar"
