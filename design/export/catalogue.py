"""What can be exported, by the names of the command, and what each one needs to be told."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from design.controllers.cascade import CascadePI
from design.controllers.controller import Controller
from design.controllers.feedforward import Feedforward, FeedforwardPI
from design.controllers.hand_over import HandOver
from design.controllers.lqi import LQI
from design.controllers.measurement.memory_estimator import MemoryObserver
from design.controllers.measurement.plausible import SensorLimits
from design.controllers.pi import PI
from design.controllers.pi_two_dof import TwoDofPI
from design.controllers.registry import REGISTERED
from design.export.mpc.linear import of_linear_mpc
from design.export.mpc.real_time import of_real_time_mpc
from design.export.part import Part
from design.export.parts_of import of_controller, of_hand_over, of_observer
from design.export.rendering import cell
from design.mpc.problem import MPCProblem, nominal, robust, weighted
from plants.actuator.delay import LONGEST
from plants.errors import InputError
from plants.rig import built_in_rig
from plants.wrist import Wrist

Numbers = tuple[float, ...]


@dataclass(frozen=True)
class Entry:
    """A controller of the command: title; the numbers that ``--gains`` gives, by name, and an example;
    those that are used where none are given, if that may be, () for its own; make: the part of C, of its
    name, the wrist and the numbers; what it does at the ends of the range, in words."""

    title: str
    gains: tuple[str, ...]
    example: str
    default: Numbers | None
    make: Callable[[str, str, Wrist, Numbers], Part]
    at_the_ends: str


def _pi(wrist: Wrist, g: Numbers) -> PI:
    Kp, Ki = g
    if Kp == Ki == 0.0:
        raise ValueError("Kp and Ki are both 0, which controls nothing")
    return PI.of(wrist, Kp, Ki)


def _pi_two_dof(wrist: Wrist, g: Numbers) -> PI:
    Kp, Ki, b, Tf = g
    if Kp == Ki == 0.0:
        raise ValueError("Kp and Ki are both 0, which controls nothing")
    return TwoDofPI.of(wrist, Kp, Ki, b, Tf)


HAND_OVER: Mapping[str, Callable[[Wrist, Numbers], PI]] = {"pi": _pi, "pi-2dof": _pi_two_dof}
"""Controllers that take over from a command by hand, and whose command may have a rate limit."""


def _cascade(wrist: Wrist, g: Numbers) -> CascadePI:
    Kp, Ki, b, Kc = g
    if Kp == Ki == 0.0:
        raise ValueError("Kp and Ki are both 0, which controls nothing")
    return CascadePI.of(wrist, Kp, Ki, b, Kc)


def _lqi(wrist: Wrist, g: Numbers) -> Controller:
    return LQI.of(wrist, *g)


def _feedforward(wrist: Wrist, g: Numbers) -> Controller:
    return Feedforward.of(wrist, speed=g[0])  # type: ignore[no-any-return]


def _not_too_late(wrist: Wrist, dead_time: float) -> None:
    longest = (LONGEST - 1) * wrist.rig.sample_time
    if dead_time > longest:
        raise ValueError(f"a dead time of {dead_time:g} s is longer than {longest:g} s")


def _feedforward_pi(wrist: Wrist, g: Numbers) -> Controller:
    _not_too_late(wrist, g[2])
    return FeedforwardPI.of(wrist, Kp=g[0], Ki=g[1], dead_time=g[2])  # type: ignore[no-any-return]


def _controlled(build: Callable[[Wrist, Numbers], Controller]) -> Callable[[str, str, Wrist, Numbers], Part]:
    def make(name: str, title: str, wrist: Wrist, gains: Numbers) -> Part:
        return of_controller(name, title, build(wrist, gains), SensorLimits.of(wrist), wrist.rig.sample_time)

    return make


def _observer(name: str, title: str, wrist: Wrist, gains: Numbers) -> Part:
    observer = MemoryObserver.of(wrist, *gains)
    return of_observer(name, title, observer, SensorLimits.of(wrist), wrist.rig.sample_time)


def _mpc(
    of: Callable[[str, str, MPCProblem], Part], setting: Callable[[Wrist], MPCProblem]
) -> Callable[[str, str, Wrist, Numbers], Part]:
    def make(name: str, title: str, wrist: Wrist, gains: Numbers) -> Part:
        problem = setting(replace(wrist, effects=()))
        if gains:
            _not_too_late(wrist, gains[2] * problem.period)
            problem = weighted(problem, *gains)
        return of(name, title, problem)

    return make


def noted(made: Part, wrist: Wrist, *notes: str) -> Part:
    """The part with notes for people, empty ones left out, and with what its wrist's rig counts from, and in
    which units."""
    words = wrist.rig.zero.words(wrist.rig.units)
    told = f"The law counts {words} of the log, the reference as the angle." if words else ""
    stands = wrist.rig.units.read_as(built_in_rig().units)
    units = f"In names, comments and this text, {cell(stands)}." if stands else ""
    return replace(made, notes=(*made.notes, *filter(None, (*notes, told, units))), zero=wrist.rig.zero)


STANDS_STILL = (
    "The command is clipped to its range. The integrator stands still while it is, unless the error drives "
    "the command back into the range."
)
OUT_OF_REACH = (
    " A reference that no command in the range can hold is replaced by the nearest that one can; "
    "`course_outside` counts the samples in which that happened."
)

WEIGHTS = ("swing [1/deg^2]", "move [1/V^2]", "delay [periods]")
"""What is tuned of an MPC (`design.mpc.problem.weighted`); where it is not given the setting has its own."""

BOUNDED = "Range and rate of the command are bounds of the plan, and of the first move once more."

CATALOGUE: Mapping[str, Entry] = {
    "pi": Entry(
        "PI controller with anti-windup", ("Kp [kPa/deg]", "Ki [kPa/(deg s)]"), "3.1,10.4", None,
        _controlled(_pi), STANDS_STILL,
    ),
    "pi-2dof": Entry(
        "PI controller with a reference weight and a filter of the angle",
        ("Kp [kPa/deg]", "Ki [kPa/(deg s)]", "b [1]", "Tf [s]"), "3.1,10.4,0.7,0.01", None,
        _controlled(_pi_two_dof), STANDS_STILL,
    ),
    "cascade": Entry(
        "PI controller of the angle around a proportional loop on the measured pressure",
        ("Kp [kPa/deg]", "Ki [kPa/(deg s)]", "b [1]", "Kc [1]"), "2.6,8.8,0.8,1", None, _controlled(_cascade),
        STANDS_STILL,
    ),
    "lqi": Entry(
        "State feedback with integral action and an observer",
        ("Ke [kPa/(deg s)]", "Kd [kPa/(deg s)]", "Kq [1/s]", "jump [kPa/deg]", "bandwidth [rad/s]"),
        "600,-640,-70,8,45", None, _controlled(_lqi),
        "The integrated command itself is clipped to its range, so that it never winds up.",
    ),
    "feedforward": Entry(
        "Inverse of hysteresis with memory, regulator and lag, without feedback", ("speed [1/s]",), "25",
        (25.0,), _controlled(_feedforward),
        "The command is clipped to its range, and the model moves by what is left of it." + OUT_OF_REACH,
    ),
    "feedforward-pi": Entry(
        "Inverse of hysteresis with memory, regulator and lag, with a PI on what is left",
        ("Kp [kPa/deg]", "Ki [kPa/(deg s)]", "dead time [s]"), "1.2,2.2,0", None,
        _controlled(_feedforward_pi),
        STANDS_STILL + " The model moves by a command in the range." + OUT_OF_REACH,
    ),
    "observer": Entry(
        "Observer of the loop's memory from angle and pressure", ("bandwidth [rad/s]",), "15", (15.0,),
        _observer, "The observer commands nothing.",
    ),
    "mpc": Entry(
        "Linear model predictive control behind the inverse of the hysteresis", WEIGHTS, "3,5,2", (),
        _mpc(of_linear_mpc, nominal), BOUNDED,
    ),
    "mpc-robust": Entry(
        "Linear model predictive control behind the inverse of the hysteresis, slow enough for dead time",
        WEIGHTS, "100,100,2", (), _mpc(of_linear_mpc, robust), BOUNDED,
    ),
    "mpc-real-time": Entry(
        "Nonlinear model predictive control by real-time iteration", WEIGHTS, "3,5,2", (),
        _mpc(of_real_time_mpc, nominal), BOUNDED,
    ),
    "mpc-real-time-robust": Entry(
        "Nonlinear model predictive control by real-time iteration, slow enough for dead time", WEIGHTS,
        "25,50,2", (), _mpc(of_real_time_mpc, robust), BOUNDED,
    ),
}  # fmt: skip


HANDED = (
    "By hand (`manual` above 0.5) the command is `manual_command_V`, within its range and rate limit, also "
    "where no sensor is believed. The integral follows it, so that the first automatic command is the last "
    "one by hand, at any error and with any gains."
)
LIMITED = (
    "The command never moves faster than the rate limit; the integrator stands still while it would, unless "
    "the error drives it back."
)


def part(
    kind: str,
    axis: str,
    wrist: Wrist,
    gains: Numbers | None = None,
    by_hand: bool = False,
    rate: float | None = None,
) -> Part:
    """The part of C of a controller of the catalogue, or one that is registered, for a wrist; of a PI and one
    with two degrees of freedom also with inputs for commands by hand, and a rate limit of the command [V/s].

    Raises InputError for an unknown controller, gains that it cannot have, and a wrist that it cannot
    control.

    >>> part("pi", "flexion", Wrist.flexion(), (3.1, 10.4)).name
    'flexion_pi'
    """
    own = {
        name: Entry(r.title, (), "", (), _controlled(lambda w, _, make=r.make: make(w)), "")  # type: ignore[misc]
        for name, r in REGISTERED.items()
    }
    known = {**CATALOGUE, **own}
    if kind not in known:
        raise InputError(f"no controller {kind!r} to export; plant, or one of {', '.join(known)}")
    entry = known[kind]
    if by_hand or rate is not None:
        entry = _handed_over(kind, entry, by_hand, rate)
    given = gains or entry.default
    wanted = (
        f"{kind} takes {', '.join(entry.gains)}, such as --gains {entry.example}"
        if entry.gains
        else f"{kind} takes no gains"
    )
    if given is None:
        raise InputError(f"--gains: not given; {wanted}")
    if gains and len(gains) != len(entry.gains):
        raise InputError(f"--gains: {len(gains)} given; {wanted}")
    try:
        made = entry.make(identifier(f"{axis[:40]}_{kind}"), entry.title, wrist, given)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"--gains: {error}; {wanted}") from None
    return noted(made, wrist, entry.at_the_ends)


def _handed_over(kind: str, entry: Entry, by_hand: bool, rate: float | None) -> Entry:
    option = "--hand-over" if by_hand else "--rate-limit"
    if kind not in HAND_OVER:
        raise InputError(f"{option}: {kind} has none; choose {' or '.join(HAND_OVER)}, or leave it out")
    if rate is not None and not 0.0 < rate < math.inf:
        raise InputError(f"--rate-limit: {rate:g} V/s is no rate; give a positive number")
    build, limit = HAND_OVER[kind], math.inf if rate is None else rate

    def make(name: str, title: str, wrist: Wrist, gains: Numbers) -> Part:
        made = HandOver(build(wrist, gains), limit)
        return of_hand_over(name, title, made, SensorLimits.of(wrist), wrist.rig.sample_time, by_hand)

    notes = [entry.at_the_ends, *([LIMITED] if rate is not None else []), *([HANDED] if by_hand else [])]
    return replace(entry, make=make, at_the_ends=" ".join(notes))


def identifier(text: str) -> str:
    """A name that C takes, of a text.

    >>> identifier("my axis_feedforward-pi"), identifier("wrist (left)_pi")
    ('my_axis_feedforward_pi', 'wrist_left_pi')
    """
    name = re.sub(r"[\W_]+", "_", text, flags=re.ASCII).strip("_").lower()
    return name if name and not name[0].isdigit() else f"wrist_{name}"


def record(made: Part, kind: str, files: list[str]) -> dict[str, Any]:
    """What ``--json`` says: files, layout of the structs with units, settings."""

    def layout(fields: Any) -> list[dict[str, Any]]:
        return [
            {"name": f.member, "type": "int" if f.counts else made.real, "count": f.size, "unit": f.unit,
             "meaning": f.meaning} for f in fields
        ]  # fmt: skip

    return {
        "controller": kind, "name": made.name, "period_s": made.period, "files": files,
        "state": layout(made.members), "measured": layout(made.inputs),
        "output": {**layout([made.output])[0], "lowest": made.low, "highest": made.high},
        "settings": dict(made.settings), "sensors": made.sensors.settings, "tolerance": made.tolerance,
    }  # fmt: skip
