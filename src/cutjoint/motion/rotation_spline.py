"""The cubic spline of rotations: through given orientations, with continuous angular velocity and acceleration.

Between two of them the rotation is R_i exp([phi(s)]), s the time since the first, and phi a cubic polynomial from 0 to
the rotation vector of the step.  About one fixed axis it is the cubic spline of the angle.  The angular velocities w_i
at the given orientations fix all cubics; that the acceleration is continuous there is an equation of w_(i-1), w_i and
w_(i+1), linear but for a term that is small where the steps are, so Newton's method ends after a few rounds.  At both
ends it rests, or it goes round.

With other ends it is the curve of scipy.spatial.transform.RotationSpline (N. Mayorov: Smooth attitude interpolation,
2019, which its documentation names).
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import WaypointError
from cutjoint.mechanism.rotations import matrix_of
from cutjoint.motion.rotation_vectors import RightJacobian, dot, product, quaternion_of_vector, triple

LARGEST_STEP = 179.0
"""[deg]; half a turn does not tell which way it goes."""
FELT = 64
"""So many steps away nothing is felt of an end, whose influence at least halves with each."""
ROUNDS = 30
ENOUGH = 1e-8
"""[rad]; what is left after a round of Newton's method is of the order of the square of its change."""
PIECE = 4000
"""Long ways are solved in pieces of so many steps, and what is felt beside them: their numbers stay in the cache."""


class RotationSpline:
    """A rotation as a function of time through unit quaternions (n, 4), x y z w, at ascending `times` (n,) [s].

    Args:
        closed: the last one is the first again, and the curve goes round; else it rests at both ends.

    Raises:
        WaypointError: two that follow one another are (nearly) half a turn apart, or no smooth curve was found.
    """

    def __init__(self, times: Array, quaternions: Array, closed: bool) -> None:
        steps, spans = steps_between(quaternions), np.diff(times)
        rates = np.empty((3, len(times)))
        for start in range(0, len(spans), PIECE):
            own = np.arange(start, min(start + PIECE, len(spans)) + 1)
            wide = np.arange(own[0] - FELT, own[-1] + FELT)
            wide = wide % len(spans) if closed else wide[(wide >= 0) & (wide < len(spans))]
            before = FELT if closed else min(start, FELT)
            found = rates_at(steps[:, wide], spans[wide], np.zeros((3, 2)))
            rates[:, own] = found[:, before : before + len(own)]
        if closed:
            rates[:, -1] = rates[:, 0]
        first, last = rates[:, :-1], np.array(RightJacobian(triple(steps)).solve(triple(rates[:, 1:])))
        second = (3.0 * steps / spans - 2.0 * first - last) / spans
        third = (first + last - 2.0 * steps / spans) / spans**2
        # A row a step: phi = s (first + s (second + s third)), and the orientation that it starts from.
        self._steps = np.concatenate([first, second, third, quaternions[:-1].T]).T.copy()

    def at(self, step: int, s: float) -> tuple[Array, Array, Array]:
        """Rotation (3, 3), angular velocity and acceleration (3,) along the axes of the world, `s` [s] into a step."""
        ax, ay, az, bx, by, bz, cx, cy, cz, x, y, z, w = self._steps[step].tolist()
        phi = s * (ax + s * (bx + s * cx)), s * (ay + s * (by + s * cy)), s * (az + s * (bz + s * cz))
        rate = ax + s * (2 * bx + 3 * s * cx), ay + s * (2 * by + 3 * s * cy), az + s * (2 * bz + 3 * s * cz)
        second = 2 * bx + 6 * s * cx, 2 * by + 6 * s * cy, 2 * bz + 6 * s * cz
        rotation = matrix_of(product((x, y, z, w), quaternion_of_vector(phi)))
        jacobian = RightJacobian(phi)
        (ux, uy, uz), (vx, vy, vz) = jacobian.times(second), jacobian.change(rate, rate)
        velocity, acceleration = np.array([jacobian.times(rate), (ux + vx, uy + vy, uz + vz)]) @ rotation.T
        return rotation, velocity, acceleration


def steps_between(quaternions: Array) -> Array:
    """Rotation vectors [rad] from each of the unit quaternions (n, 4) to the next, along the axes of the body,
    shape (3, n - 1).  q and -q are the same rotation.

    Raises:
        WaypointError: a step of half a turn, or nearly.
    """
    x, y, z, w = quaternions.T
    vx, vy, vz, real = product((-x[:-1], -y[:-1], -z[:-1], w[:-1]), (x[1:], y[1:], z[1:], w[1:]))
    sine = np.sqrt(dot((vx, vy, vz), (vx, vy, vz)))
    angle = 2.0 * np.arctan2(sine, np.abs(real))
    far = np.flatnonzero(angle > np.deg2rad(LARGEST_STEP))
    if len(far):
        raise WaypointError(
            f"the orientation turns by {np.rad2deg(angle[far[0]]):.4g} degrees in one step, which does not tell which "
            "way round; expected less than half a turn, so give one between",
            waypoint=int(far[0]) + 1,
        )
    factor = np.divide(angle, sine, out=np.full_like(angle, 2.0), where=sine > 0.0)
    return np.asarray(np.copysign(factor, real) * np.array([vx, vy, vz]))


def rates_at(steps: Array, spans: Array, ends: Array) -> Array:
    """The angular velocities (3, n) [rad/s], along the axes of the body, with which the acceleration is continuous.

    Args:
        steps: rotation vectors from one orientation to the next, shape (3, n - 1), [rad].
        spans: what they take, shape (n - 1,), [s].
        ends: the first and the last angular velocity, shape (3, 2).

    Raises:
        WaypointError: Newton's method finds none.
    """
    rates = np.zeros((3, len(spans) + 1))
    rates[:, [0, -1]] = ends
    if len(spans) == 1:
        return rates
    equations = _Equations(steps, spans)
    shortest = np.minimum(spans[:-1], spans[1:])
    for _ in range(ROUNDS):
        change = equations.newton(rates)
        if change is None or not np.isfinite(change).all():
            break
        rates[:, 1:-1] += change
        if (np.abs(change) * shortest).max() < ENOUGH:
            return rates
    raise WaypointError(
        "no smooth way was found through the orientations, and this step is the largest; give more between",
        waypoint=int(np.argmax(np.abs(steps).max(axis=0))) + 1,
    )


class _Equations:
    """That the acceleration is continuous at every orientation but the ends: with r the step before it, of h seconds,
    and r', h' the one after,

        2 J(r) w_(i-1) / h + 4 (1 / h + 1 / h') w_i + 2 J(r')^-1 w_(i+1) / h' + J_dot(r, u) u = 6 (r / h^2 + r' / h'^2)

    where u = J(r)^-1 w_i is the rate of the rotation vector at the end of the step before.
    """

    def __init__(self, steps: Array, spans: Array) -> None:
        self._before = before = RightJacobian(triple(steps[:, :-1]))
        after = RightJacobian(triple(steps[:, 1:]))
        pace, next_pace = 1.0 / spans[:-1], 1.0 / spans[1:]
        units = [triple(one) for one in np.repeat(np.eye(3)[:, :, None], len(pace), axis=2)]
        self._back = np.array([before.solve(unit) for unit in units])  # column, row, orientation
        self._lower = 2.0 * pace * np.array([before.times(unit) for unit in units])
        self._upper = 2.0 * next_pace * np.array([after.solve(unit) for unit in units])
        self._diagonal = 4.0 * (pace + next_pace)
        self._right = 6.0 * (steps[:, :-1] * pace**2 + steps[:, 1:] * next_pace**2)

    def newton(self, rates: Array) -> Array | None:
        """The change of the inner rates (3, n - 2) after which what is linear of the equations holds; None if there
        is none."""
        from scipy.linalg import lapack

        slope = triple(np.einsum("jik,jk->ik", self._back, rates[:, 1:-1]))
        missing = self._right - self._diagonal * rates[:, 1:-1] - np.array(self._before.change(slope, slope))
        missing -= np.einsum("jik,jk->ik", self._lower, rates[:, :-2])
        missing -= np.einsum("jik,jk->ik", self._upper, rates[:, 2:])
        # LAPACK's band: row r and column c of the matrix stand in row 10 + r - c of column c.
        band = np.zeros((16, missing.size), order="F")
        for j in range(3):
            column = triple(self._back[j])
            own = np.add(self._before.change(column, slope), self._before.change(slope, column))
            own[j] += self._diagonal
            for i in range(3):
                band[10 + i - j, j::3] = own[i]
                band[13 + i - j, j:-3:3] = self._lower[j, i, 1:]
                band[7 + i - j, 3 + j :: 3] = self._upper[j, i, :-1]
        factors, pivots, failed = lapack.dgbtrf(band, 5, 5, overwrite_ab=True)
        if failed:
            return None
        found: Array = lapack.dgbtrs(factors, 5, 5, missing.T.ravel(), pivots)[0]
        return found.reshape(-1, 3).T
