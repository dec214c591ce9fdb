"""Numbers of hardware that differ from run to run: each run is the run alone with its own hardware."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from kit.hardware import PERIOD

from cutjoint.compile import ClosedLoop, compiled, simulate_many
from cutjoint.control import PD
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.motion import Hold, Reference
from cutjoint.robots import load, published
from cutjoint.simulation import ReducedPlant, RungeKutta4, run
from cutjoint.simulation.hardware import (
    Backlash,
    Clock,
    Differences,
    Drive,
    Encoder,
    Hardware,
    Tachometer,
    TorqueSpeed,
)
from cutjoint.simulation.hardware.numbers import PLACES, hardware_number, with_numbers
from cutjoint.simulation.integrators import steps_within

SAMPLED = ("q", "v", "effort", "measured_q", "measured_v", "asked", "command")


def hardware_for(name: str, place: float, effort: float, mass: float) -> Hardware:
    """Hardware that has the part which the number is of."""
    motor = TorqueSpeed(2.0 * effort, 50.0 * place) if "torque_speed" in name else None
    play = (
        Backlash(0.01 * place, 400.0 * effort / place, 1.0 * effort / place, 0.2 * mass) if "backlash" in name else None
    )
    speed: Differences | Tachometer = Differences(80.0) if "differences" in name else Tachometer()
    return Hardware(Clock(1.0 / PERIOD), Encoder(delay=PERIOD), speed, Drive(torque_speed=motor, backlash=play), seed=3)


def values_for(name: str, place: float, effort: float, mass: float) -> tuple[float, float]:
    """The ends of a range in which the number can be felt."""
    scale = {
        "encoder.resolution": 1e-3 * place, "encoder.offset": 0.01 * place, "encoder.noise": 1e-3 * place,
        "differences.cutoff": 50.0, "tachometer.noise": 0.01 * place, "drive.limits": 0.05 * effort,
        "drive.resolution": 0.05 * effort, "drive.torque_speed.stall": 0.05 * effort,
        "drive.torque_speed.no_load_speed": 5.0 * place, "drive.backlash.width": 0.02 * place,
        "drive.backlash.stiffness": 300.0 * effort / place, "drive.backlash.damping": effort / place,
        "drive.backlash.rotor": 0.2 * mass,
    }[name]  # fmt: skip
    return 0.5 * scale, 2.0 * scale


def alone_and_many(
    model: Any, plant: Any, hardware: Hardware, numbers: Mapping[str, np.ndarray], k: int
) -> tuple[Any, Any]:
    """Run k alone with hardware of its own, and all of them."""
    mass = np.abs(np.diag(model.terms(model.home).mass))
    law = PD(0.2 * mass * 400.0, 0.2 * mass * 40.0)
    reference = Reference(Hold(model.tool(model.home).position), model, 1.0)
    start = model.home.q + 0.01 * (model.length if hasattr(model, "length") else 1.0)
    step = hardware.ticks.length / steps_within(hardware.ticks.length, 1e-3)
    own = {name: values[k] for name, values in numbers.items()}
    single = run(
        ReducedPlant(plant), law, reference, integrator=RungeKutta4(step), hardware=with_numbers(hardware, own),
        run_number=k, duration=12 * PERIOD, start=plant.close(start),
    )  # fmt: skip
    many = simulate_many(
        plant, law, reference, hardware=hardware, hardware_numbers=numbers, every=step, step=step, start=start,
        duration=12 * PERIOD,
    )  # fmt: skip
    return single, many


def agree(single: Any, many: Any, k: int) -> None:
    assert not many.failed
    for name in SAMPLED:
        wanted = getattr(single, name)
        np.testing.assert_allclose(getattr(many, name)[k], wanted, rtol=0, atol=1e-11 * np.abs(wanted).max())


def check(model: Any, plant: Any, names: list[str], seed: int) -> None:
    rng = np.random.default_rng(seed)
    mass = float(np.abs(np.diag(model.terms(model.home).mass)).max())
    place = 0.1 * getattr(model, "length", 1.0)
    effort = 80.0 * mass * place
    hardware = hardware_for(" ".join(names), place, effort, mass)
    numbers = {}
    for name in names:
        low, high = values_for(name, place, effort, mass)
        shape = (9, model.n) if seed % 2 and name != "differences.cutoff" else (9,)
        numbers[name] = rng.uniform(low, high, shape)
    single, many = alone_and_many(model, plant, hardware, numbers, 5)
    agree(single, many, 5)
    some = many.q if names != ["drive.resolution"] else many.command
    assert np.ptp(some, axis=0).max() > 0.0, "the number changes nothing"


def test_a_number_of_its_own_in_every_run() -> None:
    model = published("cpm")
    check(model, compiled(model), ["encoder.noise", "differences.cutoff", "drive.limits"], 1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "name"),
    [*(("fivebar", name) for name in PLACES), ("cpm", "drive.limits"), ("cpm", "drive.backlash.width")],
)
def test_every_number_may_vary(robot: str, name: str) -> None:
    model = load(robot)
    check(model, compiled(model), [name], len(name))


def test_numbers_that_cannot_vary_are_told() -> None:
    model = published("cpm")
    plant, hardware = compiled(model), Hardware(Clock(1000.0))
    way = Reference(Hold(model.tool(model.home).position), model, 0.01)

    def go(hardware: Hardware | None, **numbers: float) -> None:
        own = {name.replace("__", "."): [x, x] for name, x in numbers.items()}
        simulate_many(plant, PD(1.0, 1.0), way, hardware=hardware, hardware_numbers=own)

    with pytest.raises(InputError, match="decides when something happens"):
        go(hardware, encoder__delay=1e-3)
    with pytest.raises(UnknownNameError, match=r"did you mean 'encoder\.noise'"):
        go(hardware, encoder__nois=1e-3)
    with pytest.raises(InputError, match=r"has no \[drive\.backlash\]"):
        go(hardware, drive__backlash__width=1e-3)
    with pytest.raises(InputError, match=r"has no \[differences\]"):
        go(hardware, differences__cutoff=1e-3)
    with pytest.raises(InputError, match="noise of the encoder must be"):
        go(hardware, encoder__noise=-1e-3)
    with pytest.raises(InputError, match="there is none"):
        go(None, encoder__noise=1e-3)
    loop = ClosedLoop(plant, PD(1.0, 1.0), model, hardware=hardware, varying=("encoder.noise",))
    with pytest.raises(InputError, match="must be given for encoder"):
        loop.run(way)


def test_a_number_is_read_and_replaced() -> None:
    hardware = Hardware(Clock(1000.0), Encoder(noise=1e-3), drive=Drive(backlash=Backlash(0.1, 1.0, 2.0, 3.0)))
    for name in ("encoder.noise", "drive.backlash.damping", "drive.limits", "tachometer.noise"):
        for value in (0.5, (0.5, 0.25)):
            other = with_numbers(hardware, {name: value})
            assert hardware_number(other, name) == value
            assert other.clock == hardware.clock
    assert hardware_number(hardware, "drive.limits") is None
