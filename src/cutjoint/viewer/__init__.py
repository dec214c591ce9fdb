"""The viewer: robots and simulations in the browser, in one HTML file, as a picture, or inline in a notebook.

Nothing else imports this package; it needs the extra `viewer` (meshcat).
"""

from __future__ import annotations

from cutjoint.chain import ClosedChain
from cutjoint.doors import door
from cutjoint.extras import missing
from cutjoint.mechanism import Posture
from cutjoint.motion import Trajectory
from cutjoint.simulation import Result

try:
    from cutjoint.viewer.film.document import Document
    from cutjoint.viewer.film.playback import playback
    from cutjoint.viewer.film.recording import Recording, from_result, from_trajectory, still
    from cutjoint.viewer.hand.live import LiveView
    from cutjoint.viewer.picture.places import Places
    from cutjoint.viewer.server.bridge import Bridge
except ModuleNotFoundError as error:
    raise missing(error.name, "the viewer") from error

__all__ = ["Bridge", "Document", "LiveView", "Places", "Recording", "play", "show"]


@door
def show(chain: ClosedChain, at: Posture | None = None, places: Places | None = None) -> Document:
    """A posture (default home) as a page: shows itself in a notebook, `save`s as HTML, `picture`s as PNG.

    `places` are shown beside the robot, such as its workspace (`cutjoint.workspace.in_world` tells where it is).

    Raises:
        InputError, ClosureError: it is no chain, or no posture of it.
    """
    return playback(chain, still(chain, chain.home if at is None else chain.posture(at)), places=places)


@door
def play(chain: ClosedChain, motion: Result | Trajectory, title: str = "") -> Document:
    """A simulation, or a trajectory followed exactly, as a page that plays it.

    Raises:
        InputError, ClosureError: it is no chain or no motion, or the result is another robot's.
        UnreachableError: the trajectory leaves the workspace.
    """
    made = from_result(chain, motion) if isinstance(motion, Result) else from_trajectory(chain, motion)
    return playback(chain, made, title)
