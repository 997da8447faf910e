"""What a comparison page says of the designs beside the recommended PI."""

from collections.abc import Mapping
from math import log

from design.alternatives.convex_concave import ConvexConcave
from design.alternatives.designs import Design, RequirementDesign
from design.alternatives.feedforward_design import FeedforwardDesign
from design.alternatives.lqi_design import RobustLQI
from design.comparison.compare import TUNED, Comparison
from design.synthesis.tuning import Tuning
from reports.shared.names import COST_WORDS, limit_in_text, limit_name, name_of
from reports.shared.tables import listed, number

NAMES = {"noise_gain": "the noise gain", "Mt": "Mt", "delay_margin_s": "the delay margin"}
"""What a sentence calls limits that only these designs have, or that are not called as in tables."""


SETTINGS = {"speed": "filter of the reference {} 1/s", "dead_time": "model delayed by {} s"}
"""What a sentence calls settings of a controller that are no gains."""


def designs(comparison: Comparison, motion: str) -> list[str]:
    """What the other designs of a motion are, a paragraph each, or why there is none."""
    found = []
    for (m, name), design in comparison.designs.items():
        if m == motion:
            said = f"none: {design}." if isinstance(design, str) else _design(design)
            title = name_of(name)
            found.append(f"{title[:1].upper()}{title[1:]}: {said}")
    return found


def budgets(comparison: Comparison, tunings: Mapping[str, Tuning]) -> str:
    """How many candidates of each design were simulated on all tuning scenarios, the most of any motion."""
    tried = {TUNED: max((t.region.points**2 for t in tunings.values()), default=0)}
    for (_, name), d in comparison.designs.items():
        if isinstance(d, RobustLQI | FeedforwardDesign):
            tried[name] = max(tried.get(name, 0), d.tried)
    counts = ", ".join(f"{name_of(n)} {count}" for n, count in tried.items() if count)
    alike = dict.fromkeys(n for (_, n), d in comparison.designs.items() if isinstance(d, RequirementDesign))
    names = listed([name_of(n) for n in alike])
    said = f"; {names} were tuned under the requirement of the recommended PI" if alike else ""
    return (
        f"Candidates simulated on all tuning scenarios: {counts} (of the recommended PI, its map alone); the "
        "convex-concave PI is the result of convex programs; textbook rules, "
        f"feedforward alone and MPCs were not tuned on scenarios at all. The budgets differ{said}."
    )


def _design(d: Design) -> str:
    """How a design was found, what it costs, and which limits it breaks on the tuning scenarios."""
    if isinstance(d, RequirementDesign):
        return _under_requirement(d)
    unit = COST_WORDS.get(d.problem.cost, "").partition("[")[2].rstrip("]")
    cost = f"Worst cost over the tuning scenarios {number(float(d.at.cost[0]))} {unit}".rstrip()
    broken = " and ".join(_named(n) for n in d.breaks)
    held = f"nearest to the limits, it breaks {broken}" if broken else "every limit met"
    if isinstance(d, ConvexConcave):
        words = _convex(d)
    else:
        words = _forward(d) if isinstance(d, FeedforwardDesign) else _lqi(d)
    return f"{words} {cost}; {held}."


def _under_requirement(d: RequirementDesign) -> str:
    gains = ", ".join(SETTINGS.get(n, f"{n} = {{}}").format(number(v)) for n, v in d.gains.items())
    broken = listed([f"the limit on {limit_in_text(n)}" for n in d.breaks])
    held = f"it breaks {broken} by {number(100 * d.excess, 2)} %" if d.breaks else "no broken limit was found"
    return (
        f"{gains}. Tuned by wrist design under the whole requirement, as the recommended PI, with {d.cases} "
        f"adverse cases. Worst cost over these {number(d.cost)}; {held}."
    )


def _forward(d: FeedforwardDesign) -> str:
    c = d.controller
    return (
        f"Kp = {number(c.Kp)} kPa/deg, Ki = {number(c.Ki)} kPa/(deg s) on the difference between model and "
        f"wrist. The model is driven to the reference at {number(c.speed)} 1/s or as fast as the command's "
        f"range allows. It is the best of {d.tried} simulated on all tuning scenarios. Its margins are those "
        "of the PI, since the feedforward is outside the loop."
    )


def _named(limit: str) -> str:
    return NAMES.get(limit, limit_name(limit))


def _convex(d: ConvexConcave) -> str:
    s, pi = d.shaped, d.controller
    active = " and ".join(_named(n) for n in s.active) or "no limit"
    words = (
        f"Kp = {number(pi.Kp)} kPa/deg, Ki = {number(pi.Ki)} kPa/(deg s). Under the limits of the linear "
        f"loop the largest Ki is {number(s.Ki)}, with Kp = {number(s.Kp)} ({s.iterations} convex programs, "
        f"{s.solver}; active: {active})."
    )
    if d.share < 1.0:
        words += (
            " Limits that only a simulation shows are not convex; all are met with both gains scaled down to "
            if not d.breaks
            else " Limits that only a simulation shows are not convex; both gains were scaled down to "
        ) + f"{100 * d.share:.0f} % of that."
    return words


def _lqi(d: RobustLQI) -> str:
    c, f = d.controller, d.choice.feedback
    words = (
        f"the command, in kPa, moves at {number(c.Ke)} (r − y) {_signed(c.Kd)} (h − y) {_signed(c.Kq)} "
        f"(gain v − P) kPa/s and jumps by {number(c.jump)} kPa per degree of a step; both poles of the "
        f"observer of h lie at −{number(c.bandwidth)} rad/s; the best of {d.tried} in its family of weights "
        f"and bandwidths. With h and the regulator's gain known, and in continuous time, the feedback is "
        f"certified ({f.solver}, checked independently) to decay at {number(f.decay, 2)} 1/s or faster under "
        "arbitrary switching of branches and rates, while the command is not clipped."
    )
    if d.pole is not None:
        speed = -log(d.pole[0]) / d.problem.scenarios[0].wrist.rig.sample_time
        words += (
            f" With the observer, on a single branch, the slowest mode decays at {number(speed, 2)} 1/s "
            f"({d.pole[1]})."
            if speed > 0.0
            else f" With the observer it is unstable ({d.pole[1]})."
        )
    return f"{words} Noise gain {number(float(d.at.values['noise_gain'][0]), 2)} V/deg."


def _signed(value: float) -> str:
    return f"{'−' if value < 0.0 else '+'} {number(abs(value))}"
