"""Which PD gains of the CPM are best, with ideal continuous control and with the loop as it is built.

    python tools/gains.py        prints a table, and draws docs/gains.svg

Gains are those of Elkady et al. 2008 scaled: kp by s^2 and kd by s, which leaves the damping ratio.  The path is the
paper's circle; errors are root mean squares of the tool from 0.5 s to 1 s.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("svg")

import numpy as np
from matplotlib import pyplot as plt

import cutjoint
from cutjoint.control import PD
from cutjoint.errors import SimulationError
from cutjoint.motion import Reference
from cutjoint.robots import PUBLISHED
from cutjoint.simulation import Adaptive, ReducedPlant, RungeKutta4, run
from cutjoint.simulation.hardware import Clock, Differences, Drive, Encoder, Hardware

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "gains.svg"
KP, KD = 12691.0, 436.0
SCALES = (0.5, 0.7, 1.0, 1.4, 2.0, 2.6, 3.0, 3.2, 3.4, 3.6)
BUILT = Hardware(
    Clock(1000.0),
    Encoder(resolution=1e-5, noise=2e-6, delay=1e-3),
    Differences(cutoff=200.0),
    Drive(resolution=0.05, delay=1e-3),
    seed=1,
)


def error(scale: float, hardware: Hardware | None) -> float:
    """Of the tool at scaled gains [m]; infinite where the run does not reach its end."""
    model = cutjoint.published("cpm")
    reference = Reference(PUBLISHED["cpm"].trajectory(), model, 1.0)
    method = Adaptive(1e-6, 1e-9) if hardware is None else RungeKutta4(1e-3)
    law = PD(KP * scale**2, KD * scale)
    try:
        found = run(ReducedPlant(model), law, reference, hardware=hardware, integrator=method, every=5e-3)
    except SimulationError:
        return np.inf
    return float(np.sqrt((found.error[found.time > 0.5] ** 2).sum(axis=1).mean()))


def main() -> None:
    """The table and the picture."""
    rows = [(scale, error(scale, None), error(scale, BUILT)) for scale in SCALES]
    print("| kp [N/m] | kd [N s/m] | ideal, continuous | as it is built |\n|---|---|---|---|")
    for scale, ideal, built in rows:
        print(f"| {KP * scale**2:.0f} | {KD * scale:.0f} | {1e3 * ideal:.3f} mm | {1e3 * built:.3f} mm |")
    scales, ideal, built = np.array(rows).T
    figure, ax = plt.subplots(figsize=(6.0, 3.6), layout="constrained")
    ax.loglog(KP * scales**2, 1e3 * ideal, "o-", color="0.6", label="continuous, ideal")
    ax.loglog(KP * scales**2, 1e3 * built, "s-", color="#5b2a86", label="1 kHz, 2 ms late, encoder, filter, noise")
    ax.set_xlabel("kp [N/m], kd with it")
    ax.set_ylabel("rms error of the tool [mm]")
    ax.set_ylim(top=30.0)
    ax.grid(which="both", alpha=0.3)
    ax.legend()
    plt.rcParams["svg.hashsalt"] = "cutjoint"
    figure.savefig(PICTURE, metadata={"Date": None})


if __name__ == "__main__":
    main()
