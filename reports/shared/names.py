"""What pages call controllers, motions, channels, limits and costs."""

from collections.abc import Mapping, Sequence

from design.comparison.compare import PAPER, TUNED
from design.synthesis.structure import PLAIN_PI, TWO_DOF_PI
from reports.shared.tables import listed

WINDOW = 10.0
"""Duration of a task [s]; a settling time beyond it counts as infinite."""

NAMES = {
    TUNED: "recommended PI", PAPER: "paper's PI (stand-in)", "SIMC": "SIMC", "AMIGO": "AMIGO",
    "Ziegler-Nichols": "Ziegler-Nichols",
}  # fmt: skip

TITLES = {"flexion": "Palmar/dorsal flexion", "deviation": "Radial/ulnar deviation"}

LIMITS = {
    "overshoot_percent": ("Overshoot", "at most", "of the step, on every task"),
    "Ms": ("Ms", "at most", "peak of the sensitivity on every branch of the loop, at both regulator rates"),
    "delay_margin_s": (
        "Delay margin",
        "at least",
        "dead time that can be added before instability",
    ),
    "total_variation_V": ("Total variation of the command", "at most", "up and down added up, in one step"),
    "steady_error_percent": ("Steady error", "at most", f"of the step, error after {WINDOW:g} s"),
    "Mt": ("Mt", "at most", "peak of the complementary sensitivity on the same branches"),
    "settling_time_s": ("Settling time", "at most", "within the run"),
    "WT": (
        "|W T|",
        "at most",
        "peak over frequency, W the weight of unmodelled dynamics that the residual shows",
    ),
}
"""Each limit's name for people, which side is allowed, and its meaning."""

CHANNELS = {"angle_deg": ("Angle", "deg"), "pressure_kPa": ("Pressure", "kPa")}

COST_WORDS = {"iae": "IAE [deg s]", "itae": "ITAE [deg s²]", "settling_time": "settling time [s]"}


def pi_name(gains: Mapping[str, float]) -> str:
    """The name of a PI with these gains (Kp, Ki, b, Tf): plain, or with two degrees of freedom.

    >>> pi_name({"Kp": 2.9, "Ki": 7.4, "b": 1.0, "Tf": 0.0}), pi_name({"Kp": 4.8, "Ki": 11.5, "b": 0.6})
    ('PI', '2-DOF PI')
    """
    plain = gains.get("b", 1.0) == 1.0 and not gains.get("Tf")
    return (PLAIN_PI if plain else TWO_DOF_PI).name


def name_of(controller: str) -> str:
    """What a page calls a controller."""
    return NAMES.get(controller, controller)


def title_of(motion: str) -> str:
    """What a page calls a motion."""
    return TITLES.get(motion, motion)


def limit_name(name: str) -> str:
    """What a page calls a limit."""
    return LIMITS[name][0] if name in LIMITS else name


def limit_in_text(name: str) -> str:
    """The name of a limit within a sentence.

    >>> limit_in_text("overshoot_percent"), limit_in_text("Ms")
    ('overshoot', 'Ms')
    """
    limit = limit_name(name)
    return limit if limit in ("Ms", "Mt", "|W T|") else limit.lower()


def broken_gains(limits: Sequence[str], nearest: bool = True) -> str:
    """What gains are called that break these limits, or, where there are none, an unknown one; nearest:
    whether none were found that break none.

    >>> broken_gains(["overshoot_percent", "Ms"]), broken_gains([], nearest=False)
    ('the nearest gains: they break the limit on overshoot and Ms', 'with gains that break a limit')
    """
    of = f"the limit on {listed([limit_in_text(n) for n in limits])}" if limits else "a limit"
    return f"the nearest gains: they break {of}" if nearest else f"with gains that break {of}"
