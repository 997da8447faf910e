"""Tables of robustness: verdict, margins, certificates, limit cycles, samples, box."""

from collections.abc import Iterable
from dataclasses import fields

from design.evaluation.metrics import UNITS, Metrics
from design.robustness.assess import Assessment
from design.robustness.box import Box
from design.robustness.certificates.constant.robust_stability import StableWhileConstant
from design.robustness.predictions.limit_cycles import LimitCycle
from design.robustness.predictions.margins import MarginHeld
from design.robustness.samples.monte_carlo import QUANTILES, Samples
from design.robustness.statement import Statement
from design.robustness.verdict import verdict
from design.status import BY_PROOF, Status
from design.synthesis.requirements import ROUNDING, Limits
from reports.robustness.claims import claim_words
from reports.robustness.reasons import because, cycle_words, no_certificate
from reports.robustness.statements import origin_words
from reports.shared.tables import Cell, Column, Group, Table, number, row, spaced

MET = {True: "met", False: "not met", None: "no limit"}
"""What a prediction or a sample says of its limit; certificates say their status."""
KINDS: dict[tuple[Status, ...], str] = {
    (Status.SAMPLED,): "Samples: seen in simulation",
    (Status.PREDICTED,): "Predictions: by linear theory and describing functions",
    BY_PROOF: "Certificates: proved, and checked outside the solver",
}
METRIC_WORDS = {
    "rise_time_s": "rise time", "settling_time_s": "settling time", "overshoot_percent": "overshoot",
    "steady_state_error_deg": "error at the end", "iae_deg_s": "IAE", "ise_deg2_s": "ISE",
    "itae_deg_s2": "ITAE", "total_variation_V": "total variation of the command",
}  # fmt: skip


def shown(s: Statement) -> str:
    """The value of a statement with its unit.

    >>> from design.robustness.predictions.margins import MarginHeld, OfRows
    >>> claim = MarginHeld("phase_margin_deg", False, None)
    >>> shown(Statement(Status.PREDICTED, claim, None, 61.2, OfRows(), "deg"))
    '61.2°'
    """
    if s.value is None:
        return "–"
    if s.unit == "s" and abs(s.value) < 1.0:
        return f"{number(1000 * s.value)} ms"
    if isinstance(s.claim, MarginHeld) and s.claim.key == "phase_margin_deg":
        return f"{number(s.value)}°"  # of phase, whatever unit the rig's angle has
    return number(s.value) + ("" if s.unit in ("", "1") else f" {s.unit}")


def outcome(s: Statement) -> str:
    """What became of a statement in a word or two, the same in pages and on the command line.

    >>> from design.robustness.predictions.margins import MarginHeld, OfRows
    >>> claim = MarginHeld("phase_margin_deg", False, None)
    >>> outcome(Statement(Status.PREDICTED, claim, None, 61.2, OfRows(), "deg"))
    'no limit'
    """
    if s.status in BY_PROOF:
        return s.status.value
    if isinstance(s.claim, StableWhileConstant) and s.holds:
        return s.status.value  # beside rows that are proved, not against a limit
    return Status.OPEN.value if s.holds is None and s.status is Status.SAMPLED else MET[s.holds]


def verdict_table(assessment: Assessment) -> Table:
    """Every claim under its kind, on its worst branch; what does not hold is marked."""
    columns = (
        Column("Statement", number=False), Column("Result", number=False), Column("Value"),
        Column("Branch", number=False), Column("Because", number=False),
    )  # fmt: skip
    groups = []
    for statuses, words in KINDS.items():
        rows = tuple(_verdict(s) for s in verdict(assessment) if s.status in statuses)
        groups.append(Group(words, rows))
    return Table(columns, tuple(groups))


def _verdict(s: Statement) -> tuple[Cell, ...]:
    no = s.holds is False
    return row(
        claim_words(s.claim), Cell(outcome(s), broken=no), Cell(shown(s), broken=no),
        spaced(s.branch), spaced(because(s)),
    )  # fmt: skip


def margin_table(assessment: Assessment) -> Table:
    """Margins of every branch and rate; beyond a limit marked."""
    limits = assessment.limits.named
    columns = (
        Column("Branch", number=False), Column("Regulator rate", number=False), Column("Gain margin", "1"),
        Column("Phase margin", "°"), Column("Delay margin", "ms"), Column("Ms", "1"), Column("Mt", "1"),
        Column("Disk margin", "1"),
    )  # fmt: skip
    rows = []
    for m in assessment.margins:
        if not m["stable"]:
            rows.append(row(m["branch"], m["rate"], Cell("unstable", broken=True), *("–" for _ in range(5))))
            continue
        late = "delay_margin_s" in limits and m["delay_margin_s"] < limits["delay_margin_s"] / ROUNDING
        high = "Ms" in limits and m["Ms"] > limits["Ms"] * ROUNDING
        rows.append(
            row(
                spaced(m["branch"]), m["rate"], number(m["gain_margin"]), number(m["phase_margin_deg"]),
                Cell(number(1000 * m["delay_margin_s"]), broken=late), Cell(number(m["Ms"]), broken=high),
                number(m["Mt"]), number(m["disk_margin"]),
            )
        )  # fmt: skip
    return Table(columns, (Group("", tuple(rows)),))


def ladder_table(assessment: Assessment) -> Table:
    """A row a certificate: whether it was found, its rate, and how it was checked."""
    columns = (
        Column("Certificate", number=False), Column("Found", number=False), Column("Certified decay", "1/s"),
        Column("Margin of the check", "1"), Column("Solver, or reason", number=False),
    )  # fmt: skip
    groups = []
    for dead_time in dict.fromkeys(c.dead_time for c in assessment.ladder):
        rows = tuple(
            row(
                c.rung, "yes" if c.holds else "none", number(c.decay),
                number(c.margin, 2) if c.holds else "–",
                c.solver if c.holds else spaced(no_certificate(c.reason)),
            )
            for c in assessment.ladder
            if c.dead_time == dead_time
        )  # fmt: skip
        groups.append(Group(f"{1000 * dead_time:.3g} ms of dead time" if dead_time else "No dead time", rows))
    return Table(columns, tuple(groups))


def constant_table(assessment: Assessment) -> Table:
    """How far the box may grow with constant parameters, by branch."""
    columns = (
        Column("Branch and rate", number=False), Column("Result", number=False),
        Column("Box can grow", "times"), Column("Because", number=False),
    )  # fmt: skip
    by_claim: dict[str, list[tuple[Cell, ...]]] = {}
    for s in (*assessment.certificates, *assessment.predictions):
        if isinstance(s.claim, StableWhileConstant):
            cells = row(spaced(s.branch), outcome(s), number(s.value) if s.value else "–", spaced(because(s)))
            by_claim.setdefault(claim_words(s.claim), []).append(cells)
    return Table(columns, tuple(Group(claim, tuple(rows)) for claim, rows in by_claim.items()))


def cycle_table(cycles: Iterable[LimitCycle]) -> Table:
    """Predicted limit cycles, and what the simulator says."""
    columns = (
        Column("Amplitude", "deg"), Column("Amplitude", "kPa"), Column("Frequency", "rad/s"),
        Column("Stable", number=False), Column("Simulated", number=False),
    )  # fmt: skip
    rows = tuple(
        row(
            Cell(
                number(c.amplitude_deg), "" if c.seen_amplitude_deg is None else number(c.seen_amplitude_deg)
            ),
            Cell(
                number(c.amplitude_kPa), "" if c.seen_amplitude_kPa is None else number(c.seen_amplitude_kPa)
            ),
            Cell(
                number(c.frequency_rad_s),
                "" if c.seen_frequency_rad_s is None else number(c.seen_frequency_rad_s),
            ),
            "yes" if c.stable else "no",
            cycle_words(c),
        )
        for c in cycles
    )
    return Table(columns, (Group("", rows),))


def violation_table(samples: Samples) -> Table:
    """How many cases broke each requirement, with the interval of the probability."""
    columns = (
        Column("Requirement broken", number=False), Column("Cases"), Column("Of"), Column("Share", "%"),
        Column("95 % interval", "%"),
    )  # fmt: skip
    rows = tuple(
        row(
            v.words, str(v.count), str(v.trials), number(100 * v.probability) if v.trials else "–",
            f"{number(100 * v.low)} to {number(100 * v.high)}",
        )
        for v in (*samples.violations, samples.beyond)
    )  # fmt: skip
    return Table(columns, (Group("", rows),))


def quantile_table(samples: Samples) -> Table:
    """Quantiles of each metric over the cases."""
    columns = (
        Column("Metric", number=False), *(Column(f"{100 * q:g} %") for q in QUANTILES),
        Column("Unit", number=False),
    )  # fmt: skip
    rows = tuple(
        row(METRIC_WORDS[f.name], *(number(v) for v in samples.quantiles[f.name]), UNITS[f.name])
        for f in fields(Metrics)
    )
    return Table(columns, (Group("", rows),))


def box_table(box: Box) -> Table:
    """Intervals with their reasons; assumed ones are set apart."""
    columns = (
        Column("Parameter", number=False), Column("From"), Column("Nominal"), Column("To"),
        Column("Unit", number=False), Column("Why", number=False),
    )  # fmt: skip
    rows = tuple(
        row(
            Cell(_name(i.name, i.scaled), marked=i.status is Status.ASSUMED), number(i.low, 4),
            number(i.nominal, 4), number(i.high, 4), "factor" if i.scaled else i.unit, origin_words(i.origin),
        )
        for i in box.intervals
    )  # fmt: skip
    return Table(columns, (Group("", rows),))


def _name(name: str, scaled: tuple[str, ...]) -> str:
    return f"{name} ({', '.join(scaled)})" if scaled else name


def limit_words(limits: Limits) -> str:
    """The limits in force, in words."""
    words = {
        "overshoot_percent": "overshoot at most {:g} %", "Ms": "Ms at most {:g}",
        "delay_margin_s": "delay margin at least {:g} s", "total_variation_V": "total variation at most "
        "{:g} V",
        "steady_error_percent": "error at the end at most {:g} %", "Mt": "Mt at most {:g}",
        "settling_time_s": "settled within {:g} s", "WT": "|W T| at most {:g}",
    }  # fmt: skip
    return ", ".join(words[n].format(v) for n, v in limits.named.items())
