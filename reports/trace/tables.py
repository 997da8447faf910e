"""The tables of a trace."""

from collections.abc import Mapping

from design.synthesis.retune import Control, JudgedStep, RetunedSide
from plants.measured.campaigns.begin import measured
from plants.measured.fitting.free_run import FreeRun
from plants.measured.residual.examine import Examination, Finding
from plants.measured.trace.result import Trace
from plants.measured.trace.search.candidate import Candidate
from plants.measured.trace.search.rounds import SearchRound
from plants.parameters.quantities import Assumed, Fitted, Learnt, Provenance
from reports.shared.names import CHANNELS
from reports.shared.plant_tables import provenance
from reports.shared.tables import Cell, Column, Group, Table, fixed, number, row, with_error
from reports.shared.tuning import refused
from reports.trace.control_words import limits_words
from reports.trace.residual_words import VARIABLES

SHOWN = 10
"""Tests of a residual that a page lists; those that found most."""


SEEN = {
    "time": "drift",
    "time_s": "the time since the start",
    "lags": "its past values",
    "bursts": "bursts",
    "events": "single events",
    "offset": "all rows",
}
"""What tests look at that is no variable, for people."""


def error_table(trace: Trace) -> Table:
    """Errors on the held-out recordings, before and after, with their intervals, and the noise."""
    rows = []
    for channel, (words, unit) in CHANNELS.items():
        before, after, noise = (x.get(channel) for x in (trace.before, trace.after, trace.noise))
        if before is None or after is None:
            continue
        intervals = (trace.before_interval.get(channel), trace.after_interval.get(channel))
        ratio = fixed(after / noise, 2) if noise else "–"
        causes = () if trace.named_only is None else (number(trace.named_only.get(channel)),)
        rows.append(row(
            f"{words} [{unit}]", _ranged(before, intervals[0]), *causes, _ranged(after, intervals[1]),
            number(noise), ratio,
        ))  # fmt: skip
    between = () if trace.named_only is None else (Column("Without the learnt block"),)
    columns = (
        Column("Channel", number=False), Column("Before"), *between, Column("After"), Column("Noise"),
        Column("After / noise", "1"),
    )  # fmt: skip
    return Table(columns, (Group("", tuple(rows)),))


def effect_table(trace: Trace) -> Table:
    """The effects that were added, each parameter with its standard error, and what else it could be."""
    columns = (
        Column("Effect added", number=False), Column("Parameter", number=False), Column("Value"),
        Column("Unit", number=False), Column("Not distinguished from", number=False),
    )  # fmt: skip
    rows = []
    for e in trace.effects:
        first = (f"{e.name} ({e.form})", ", ".join(e.alternatives) or "–")
        for name, (value, unit, error) in e.parameters.items():
            rows.append(row(first[0], name, with_error(value, error), unit, first[1]))
            first = ("", "")
    return Table(columns, (Group("", tuple(rows) or (row("none", "–", "–", "–", "–"),)),))


def _ranged(value: float, interval: tuple[float, float] | None) -> Cell:
    return Cell(number(value), "" if interval is None else f"{number(interval[0])} to {number(interval[1])}")


def recording_table(trace: Trace) -> Table:
    """Errors of every recording, by its role."""
    channels = [c for c in CHANNELS if any(_rms(r, c, "") is not None for r in trace.runs)]
    groups = []
    for role, words in (("validate", "Held out"), ("fit", "Fitted and selected on")):
        rows = [
            row(r.recording.name, *(number(_rms(r, c, side)) for c in channels for side in ("_before", "")))
            for r in trace.runs
            if r.role == role
        ]
        groups.append(Group(words, tuple(rows)))
    columns = [Column("Recording", number=False)]
    for channel in channels:
        words, unit = CHANNELS[channel]
        columns += [Column(f"{words}, before", unit), Column(f"{words}, after", unit)]
    return Table(tuple(columns), tuple(groups))


def _rms(run: FreeRun, channel: str, side: str) -> float | None:
    truth = measured(run.recording, channel)
    simulated = getattr(run, ("pressure" if channel == "pressure_kPa" else "angle") + side)
    if truth is None or simulated is None:
        return None
    squares = (simulated - truth) ** 2
    return float(squares[run.recording.judged if run.role == "validate" else slice(None)].mean() ** 0.5)


def parameter_table(trace: Trace) -> Table:
    """Every parameter of the revised plant beside that of the declared one, with its evidence."""
    revised, declared = trace.revised, trace.fit.fitted.parameters
    rows: list[tuple[Cell, ...]] = []
    effects: list[tuple[Cell, ...]] = []
    law: list[tuple[Cell, ...]] = []  # of another hysteresis law than the declared one
    for name, p in revised.parameters.items():
        origin = p.provenance
        value = with_error(p.value, origin.std_error) if isinstance(origin, Fitted) else number(p.value, 4)
        before = [number(declared[name].value, 4) if name in declared else "–"] if revised.effects else []
        cells = row(
            name, *before, value, p.unit, Cell(_where_from(origin), marked=isinstance(origin, Assumed)),
            revised.kinds[name].meaning,
        )  # fmt: skip
        (rows if name in declared else effects if "." in name else law).append(cells)
    values = [Column("Declared wrist"), Column("Revised plant")] if revised.effects else [Column("Value")]
    words = [Column(heading, number=False) for heading in ("Unit", "Where from", "Meaning")]
    columns = (Column("Name", number=False), *values, *words)
    if not effects and not law:
        return Table(columns, (Group("", tuple(rows)),))
    groups = (
        Group("Effects", tuple(effects), tuple(range(len(effects)))),
        Group("Parameters of the hysteresis law that was chosen", tuple(law)),
        Group("Declared parameters, fitted together", tuple(rows)),
    )
    return Table(columns, tuple(g for g in groups if g.rows))


def _where_from(origin: Provenance) -> str:
    if isinstance(origin, Fitted) and not isinstance(origin, Learnt) and origin.std_error is None:
        return "fitted, at a bound or not determined"
    return provenance(origin)


def finding_table(before: Examination, after: Examination) -> Table:
    """The tests that found most, with their bounds, before the effects and after."""
    both = after is not before
    kept = {_key(f): f for f in after.findings}
    order = sorted(before.findings, key=lambda f: (f.test == "whiteness", -strength(f)))
    rows = []
    for f in order[:SHOWN] + [f for f in order[SHOWN:] if f.test == "whiteness"]:
        sides = [f, *([kept.get(_key(f))] if both else [])]
        found = ["–" if s is None else _found(s) for s in sides]
        shares = ["–" if s is None else _share(s) for s in sides]
        rows.append(row(f.test, seen_words(f.variable), number(f.bound), *found, *shares))
    words = (("Before", "After"), ("Share before", "Share after")) if both else (("Found",), ("Share",))
    columns = (
        Column("Test", number=False), Column("Looks at", number=False), Column("Bound"),
        *(Column(w) for w in words[0]), *(Column(w, "%") for w in words[1]),
    )  # fmt: skip
    return Table(columns, (Group("", tuple(rows)),))


def _key(f: Finding) -> tuple[str, str]:
    """What tests of two residuals have in common; the frequency of a line may differ."""
    return f.test, f.variable.split(" at ")[0]


def strength(finding: Finding) -> float:
    """How far a test exceeds its bound."""
    return finding.statistic / finding.bound if finding.bound > 0.0 else 0.0


def _found(f: Finding) -> Cell:
    return Cell(number(f.statistic), "", strength(f) > 1.0)


def _share(f: Finding) -> str:
    return fixed(100.0 * min(max(0.0, f.share), 1.0), 1)


def seen_words(variable: str) -> str:
    """What a test looks at, for people."""
    return SEEN.get(variable, VARIABLES.get(variable, variable))


def decision_table(rounds: tuple[SearchRound, ...]) -> Table:
    """Each round's models that were refitted fully: chi-square on all data, and of the first, the best and
    the one taken what the decision rested on, chi-square on blocks that did not fit them or, where what was
    left looked like noise, the log-likelihood that they gain; others were not judged by that."""
    groups = []
    for count, r in enumerate(rounds, start=1):
        if not r.candidates:
            continue
        models = [r.before, *r.candidates]
        if r.taken is not None and all(r.taken.model.forms != c.model.forms for c in r.candidates):
            models.insert(1, r.taken)  # the best of them, in another form
        noisy = not r.before.examined.structured
        rows = tuple(_decided(c, r, noisy) for c in models)
        taken = None if r.taken is None else " + ".join(r.taken.model.effects)
        by = "likelihood, since the residual looks like noise" if noisy else "held-out blocks"
        words = f"Round {count}, by {by}: {f'{taken} selected' if taken else 'nothing more selected'}"
        strong = tuple(i for i, c in enumerate(models) if r.taken is not None and _same(c, r.taken))
        groups.append(Group(words, rows, strong))
    columns = (
        Column("Model", number=False), Column("Chi-square", "1"), Column("On held-out blocks", "1"),
        Column("Log-likelihood gained", "1"), Column("", number=False),
    )  # fmt: skip
    return Table(columns, tuple(groups))


def _same(one: Candidate, other: Candidate) -> bool:
    return one.model.forms == other.model.forms


def _decided(c: Candidate, r: SearchRound, noisy: bool) -> tuple[Cell, ...]:
    """A model of a round, with the figure that the decision rested on."""
    name = " + ".join(f"{f.NAME} ({f.FORM})" for f in c.model.forms) or "the declared wrist alone"
    first, taken = c is r.before, r.taken is not None and _same(c, r.taken)
    judged = first or taken or c is r.candidates[0]
    held_out = fixed(c.held_out, 2) if judged and not noisy else "–"
    gained = fixed(c.log_likelihood - r.before.log_likelihood, 1) if judged and noisy and not first else "–"
    return row(name, fixed(c.model.chi2, 2), held_out, gained, "before" if first else "selected" * taken)


def judge_table(reasons: Mapping[str, str]) -> Table:
    """Effects that the recordings cannot decide, and why."""
    columns = (Column("Effect", number=False), Column("Why these recordings cannot decide", number=False))
    return Table(columns, (Group("", tuple(row(n, why) for n, why in reasons.items())),))


def control_table(control: Control) -> Table:
    """Both PIs on the judge."""
    sides = (control.declared,) if control.same else (control.declared, control.revised)
    columns = (
        Column("Tuned on", number=False), Column("Kp", "kPa/deg"), Column("Ki", "kPa/(deg s)"),
        Column("IAE", "deg s"), Column("Overshoot", "%"), Column("Settling", "s"),
        Column("Final error", "deg"), Column("Breaks here", number=False),
        Column("Breaks anywhere", number=False),
    )  # fmt: skip
    return Table(columns, (Group("", tuple(_side(s) for s in sides)),))


def _side(side: RetunedSide) -> tuple[Cell, ...]:
    name = side.plant
    if side.tuning is None or side.judged is None:
        return row(name, *["–"] * 6, "–" if side.refusal is None else refused(side.refusal), "–")
    j = side.judged
    return row(
        name, fixed(side.tuning.Kp, 2), fixed(side.tuning.Ki, 2), fixed(j.iae_deg_s, 2),
        Cell(fixed(j.overshoot_percent, 1), "", "overshoot_percent" in j.broken),
        Cell(_settling(j), "", j.oscillates),
        Cell(fixed(j.steady_error_deg, 2), "", "steady_error_percent" in j.broken),
        Cell(limits_words(j.broken), "", bool(j.broken)),
        Cell(limits_words(side.broken), "", bool(side.broken)),
    )  # fmt: skip


def _settling(j: JudgedStep) -> str:
    if j.oscillates:
        return "oscillates"
    beyond = f"> {j.response.time[-1]:.0f}"
    return fixed(j.settling_time_s, 2, beyond)
