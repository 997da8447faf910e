"""What two campaigns of one rig say in sentences."""

from collections.abc import Sequence

from design.studies.check.campaigns import CONFIDENCE, CampaignChange, ParameterChange, RecordingResidual
from plants.effects import form_of
from plants.measured.trace.result import Named
from plants.measured.trace.search.candidate import WORTH
from reports.shared.tables import listed, number, with_error

NAMED = 4
"""Parameters that the title names, those that differ most against their intervals."""


def title(change: CampaignChange) -> str:
    """The answer in a line: the heading, and what the command says first."""
    old, new = names(change)
    if not change.changed and (differ := differing(change)):
        return (
            f"No change beyond the residual between {old} and {new}, yet parameters differ: "
            f"{'; '.join(parameter(p) for p in differ[:NAMED])}"
        )
    if not change.changed:
        hides = hidden(change)
        return (
            f"{'No change is seen' if hides else 'Nothing changed'} between {old} and {new}: the plant of "
            f"{old} simulates all {len(change.residuals)} recordings of {new} to within its residual{hides}"
        )
    return f"Changed between {old} and {new}: {causes(change)}"


def hidden(change: CampaignChange) -> str:
    """What an old plant that leaves some of its own recordings unexplained does not show, else empty."""
    if change.old.verdict != "unexplained":
        return ""
    sizes = {
        channel: max(c.allowed for r in change.residuals for c in r.channels if c.channel == channel)
        for channel in {c.channel for r in change.residuals for c in r.channels}
    }
    least = listed([f"{number(v)} {n.split('_')[1]}" for n, v in sorted(sizes.items())])
    return f", which hides changes of less than {least}"


def names(change: CampaignChange) -> tuple[str, str]:
    """What both campaigns are called."""
    old, new = change.old.campaign.name, change.campaign.name
    return (old, new) if old != new else ("the old campaign", "the new campaign")


def causes(change: CampaignChange) -> str:
    """Effects that appeared or disappeared and parameters that differ, in words."""
    said = [came(e) for e in change.came] + [f"{n} disappeared" for n in change.went]
    differ = differing(change)
    said += [parameter(p) for p in differ[:NAMED]]
    if len(differ) > NAMED:
        more = len(differ) - NAMED
        said.append(f"{more} more parameter{'s differ' if more > 1 else ' differs'}")
    if not said:
        return "no single parameter differs by more than its interval, and no effect came or went"
    if change.unexplained:
        left = listed([c.split("_")[0] for c in change.unexplained])
        said.append(f"but the residual of the {left} is larger than before")
    return "; ".join(said)


def came(effect: Named) -> str:
    """An effect that appeared, and what it is not distinguished from."""
    return f"{effect.name} appeared" + (
        f" (or {' or '.join(effect.alternatives)})" if effect.alternatives else ""
    )


def differing(change: CampaignChange) -> list[ParameterChange]:
    """Parameters that differ, the clearest first."""
    found = [p for p in change.parameters if p.differs]
    return sorted(found, key=lambda p: -abs(p.difference) / p.half_width)


def parameter(p: ParameterChange) -> str:
    """By how much a parameter differs: in per cent of its old value, or in its unit where that is zero."""
    if p.old == 0.0:
        return f"{p.name} {_signed(p.difference)} {p.unit}"
    return f"{p.name} {_signed(100.0 * p.difference / abs(p.old))} %"


def _signed(value: float) -> str:
    return ("+" if value > 0.0 else "") + number(value, 2)


def _unit(unit: str) -> str:
    return "" if unit == "1" else f" {unit}"


def difference(p: ParameterChange) -> str:
    """The difference of a parameter with half the width of its interval."""
    return with_error(p.difference, p.half_width)


def summary(change: CampaignChange) -> list[str]:
    """Three sentences: the answer, what it rests on, what to do."""
    new = names(change)[1]
    if not change.changed and differing(change):
        return [
            f"{title(change)}.",
            "The residual of the old plant on its own campaign is so large that it hides their influence.",
            f"Trace {new} separately before you trust gains designed on the old plant.",
        ]
    if not change.changed:
        certain = sum(p.certain for p in change.parameters)
        within = "All" if not certain else f"All but {certain}, without effect beyond the noise,"
        return [
            f"{title(change)}.",
            f"{within} of the {len(change.parameters)} parameter differences lie within the intervals below; "
            "smaller changes cannot be detected.",
            f"The plant and its gains remain valid{', as far as that shows' if hidden(change) else ''}.",
        ]
    worst = most_off(change)
    sizes = listed([
        f"{number(c.rms)} {c.channel.split('_')[1]} in the {c.channel.split('_')[0]} (expected: at most "
        f"{number(c.allowed)})"
        for c in worst.channels if c.new
    ])  # fmt: skip
    happens = [form_of(e.name, e.form).HAPPENS for e in change.came]
    differ = listed([f"{p.name} {difference(p)}{_unit(p.unit)}" for p in differing(change)])
    return [
        f"Differences beyond their intervals: {differ}." if differ else f"{title(change)}.",
        f"In {worst.recording.name} the residual of the old plant is {sizes}."
        + "".join(f" {words}." for words in happens),
        f"Trace {new} separately and design again before you trust gains designed on the old plant.",
    ]


def most_off(change: CampaignChange) -> RecordingResidual:
    """The recording in which the old plant is furthest off, by what is allowed."""
    return max(change.residuals, key=lambda r: max(c.rms / c.allowed for c in r.channels))


def remarks(change: CampaignChange) -> list[str]:
    """What a reader has to know besides the summary."""
    found = [
        "A rig counts as changed where the residual of a new recording exceeds, by 30 %, what the old "
        "residual, the noise and the parameter uncertainty explain.",
    ]
    if change.undetermined:
        found.append(
            "No interval, since one of the campaigns does not determine them: "
            f"{listed(list(change.undetermined))}."
        )
    ended = [s.new.stage.channel.split("_")[0] for s in change.stages if s.full]
    if ended:
        found.append(
            f"No further effect was searched for in the {listed(ended)}: its plant has the maximum number of "
            "effects."
        )
    return [*found, *(f"Instrument: {r}" for r in change.instrument)]


def parameter_caption() -> str:
    """Beneath the differences."""
    return (
        "Parameter differences, new minus old, in per cent of the old value, with joint intervals of "
        f"confidence {100 * CONFIDENCE:.0f} %. Orange: those that differ."
    )


def interval_words(p: Sequence[ParameterChange]) -> str:
    """What the intervals mean, above the table."""
    return (
        f"Intervals of the differences hold for all {len(p)} parameters together with a confidence of "
        f"{100 * CONFIDENCE:.0f} % (Bonferroni). Standard errors: sandwich over blocks of time; those of the "
        "wrist include the uncertainty of the regulator's parameters. A parameter differs where its "
        "interval excludes zero and its old value would raise the new campaign's chi-square by more than "
        f"{number(WORTH)} per row: smaller differences may be due to model error."
    )
