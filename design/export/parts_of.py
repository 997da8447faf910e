"""Parts for export, made of controllers, with or without a hand-over, and of the observer of the memory."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from design.controllers.controller import Controller, Measured, settings_of
from design.controllers.hand_over import HandOver
from design.controllers.hand_over import step as step_by_hand
from design.controllers.measurement.memory_estimator import MemoryObserver, init
from design.controllers.measurement.memory_estimator import step as observe
from design.controllers.measurement.plausible import SensorLimits
from design.export.fields import COMMAND, Quantity, described, lines_of
from design.export.part import SEEN_BY_HAND, Number, Part, Seen, SeenByHand
from design.export.rings import samples_of
from plants.kernel import pytrees
from plants.kernel.graphs import baked, c_source, graph, used
from plants.wrist import SAMPLE_TIME


def of_controller(
    name: str, title: str, controller: Controller, sensors: SensorLimits, period: float = SAMPLE_TIME
) -> Part:
    """Any controller that `design.controllers.controller` describes and whose law is made of NumPy ufuncs.

    sensors: what they can show; period: of its step [s].
    Its sensors' names are those of `Seen`; of these it asks for what its law depends on.
    """

    def law(state: Any, seen: Seen, coefficients: Any) -> tuple[Any, Number]:
        measured = Measured(seen.reference - seen.angle, seen.angle, seen.pressure)
        return coefficients.act(state, measured)  # type: ignore[no-any-return]

    return _commanding(name, title, controller, sensors, period, law, Seen)


def of_hand_over(
    name: str,
    title: str,
    controller: HandOver,
    sensors: SensorLimits,
    period: float,
    by_hand: bool,
) -> Part:
    """A PI with a rate limit and, where it may be commanded by hand, without a jump when it takes over.

    sensors, period [s]: as of `of_controller`.
    """
    if not by_hand:
        return of_controller(name, title, controller, sensors, period)

    def law(state: Any, seen: SeenByHand, coefficients: Any) -> tuple[Any, Number]:
        measured = Measured(seen.reference - seen.angle, seen.angle, seen.pressure)
        return step_by_hand(state, measured, seen.manual, seen.manual_command, coefficients)

    found = _commanding(name, title, controller, sensors, period, law, SeenByHand)
    return replace(found, by_hand=True, lost=f"{found.lost}; by hand, the command goes through all the same")


def _commanding(
    name: str,
    title: str,
    controller: Controller,
    sensors: SensorLimits,
    period: float,
    law: Callable[[Any, Any, Any], tuple[Any, Number]],
    given: type[Seen] | type[SeenByHand],
) -> Part:
    low, high = (float(getattr(controller, n)) for n in ("low", "high"))

    def begin(pressure: Number, angle: Number) -> tuple[Any, Number]:
        # As `design.evaluation.steps.holding`, the regulator being as the controller believes; of a pressure
        # that no command holds, the nearest that one does.
        held = np.minimum(np.maximum(pressure, low * controller.gain), high * controller.gain)
        state = controller.holding(held, Measured(0.0, angle, pressure))
        return state, np.minimum(np.maximum(controller.command(state), low), high)

    c, settings = controller.sampled(period), settings_of(controller)
    return _part(name, title, period, begin, law, c, COMMAND, low, high, settings, sensors, given)


def of_observer(
    name: str, title: str, observer: MemoryObserver, sensors: SensorLimits, period: float = SAMPLE_TIME
) -> Part:
    """The observer of the loop's memory, whose output is the static angle [deg]."""
    c = observer.sampled(period)

    def begin(pressure: Number, angle: Number) -> tuple[Any, Number]:
        state = init(angle, pressure, c)
        return state, state.memory.h

    def law(state: Any, seen: Seen, coefficients: Any) -> tuple[Any, Number]:
        after = observe(state, seen.angle, seen.pressure, coefficients)
        return after, after.memory.h

    output = Quantity("static_angle", "deg", "static angle as observed")
    settings = settings_of(observer)
    return _part(name, title, period, begin, law, c, output, None, None, settings, sensors)


def _part(
    name: str,
    title: str,
    period: float,
    begin: Callable[[Number, Number], tuple[Any, Number]],
    law: Callable[[Any, Any, Any], tuple[Any, Number]],
    c: Any,
    output: Quantity,
    low: float | None,
    high: float | None,
    settings: Mapping[str, float],
    sensors: SensorLimits,
    given: type[Seen] | type[SeenByHand] = Seen,
) -> Part:
    c = pytrees.like(c, [float(x) for x in pytrees.leaves(c)])

    def started(at: tuple[Number, Number]) -> tuple[Any, Number]:
        return begin(*at)

    def python_begin(pressure: float, angle: float) -> tuple[Any, float]:
        state, out = begin(pressure, angle)
        return pytrees.like(state, [float(x) for x in pytrees.leaves(state)]), float(out)

    def python_step(state: Any, seen: Seen) -> tuple[Any, float]:
        after, out = law(state, seen, c)
        return pytrees.like(after, [float(x) for x in pytrees.leaves(after)]), float(out)

    memory, _ = python_begin(100.0, 0.0)
    init_law = baked(f"{name}_init_law", graph(started, (0.0, 0.0)))
    step_law = baked(f"{name}_step_law", graph(law, memory, given(*(0.0 for _ in given._fields)), c), c)
    read = used(step_law, 1)
    delays = tuple(zip(lines_of(memory), samples_of(c), strict=True))
    return Part(
        name, title, period, tuple(f for f, wanted in zip(SEEN_BY_HAND, read, strict=False) if wanted),
        described(memory), output, low, high, settings,
        c_source(f"{name}_law", init_law, step_law), python_begin, python_step, sensors, delays,
    )  # fmt: skip
