"""Control laws, a file each.  A law knows gains and perhaps a model of the robot; saturation and the sample rate belong
to the loop that runs it (`cutjoint.simulation`)."""

from cutjoint.control.catalogue import LAWS, law
from cutjoint.control.computed_torque import ComputedTorque
from cutjoint.control.efforts_file import efforts_from_csv
from cutjoint.control.feedforward import Feedforward
from cutjoint.control.function import LawOfFunction, as_law, fitted_law
from cutjoint.control.given import EffortTable, GivenEfforts, efforts_of
from cutjoint.control.law import Gain, GainHelp, Law
from cutjoint.control.none import NoControl
from cutjoint.control.pd import PD
from cutjoint.control.pd_gravity import PDGravity
from cutjoint.control.pid import PID

__all__ = [
    "LAWS",
    "PD",
    "PID",
    "ComputedTorque",
    "EffortTable",
    "Feedforward",
    "Gain",
    "GainHelp",
    "GivenEfforts",
    "Law",
    "LawOfFunction",
    "NoControl",
    "PDGravity",
    "as_law",
    "efforts_from_csv",
    "efforts_of",
    "fitted_law",
    "law",
]
