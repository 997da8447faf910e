"""What a trace says in sentences: the verdict, the residual, what could not be decided."""

from collections.abc import Iterable, Sequence

from plants.effects import EFFECTS, form_of
from plants.measured.trace.result import Named, StageTrace, Trace
from reports.shared.figures.fit import law_sentence
from reports.shared.tables import fixed, listed, number
from reports.trace.residual_words import UNITS, channel_name, depends

SLOW = 1.25
"""Noise that is this many times as large as its floor, which is taken from row to row, is slow."""


def summary(trace: Trace) -> list[str]:
    """Three sentences of at most 20 words: the answer, what it rests on, what is open."""
    return [answer(trace), evidence(trace), still_open(trace)]


def answer(trace: Trace) -> str:
    """The verdict with the error of the first channel, the angle where there is one; `verdict_sentence` is
    the same in full."""
    if trace.worse:
        return "The revised plant is worse on the held-out recordings: use the declared plant."
    if not _logged(trace):
        return "The residual has structure that no effect explains."
    channel = _logged(trace)[0]
    before, after, noise = (x[channel] for x in (trace.before, trace.after, trace.noise))
    error, floor = f"held-out {channel_name(channel)} RMSE", f"noise {_amount(noise, channel)}"
    if trace.verdict == "nothing-missing":
        return f"Nothing is missing: {error} {_amount(before, channel)}, {floor}."
    causes = [e.name for e in trace.effects] or [f"the law {trace.revised.law.NAME}"]
    head = f"{listed(causes)} {'explains' if len(causes) == 1 else 'explain'}"
    falls = f"{error} falls from {number(before)} to {_amount(after, channel)}, {floor}"
    if trace.verdict == "explained":
        return f"{head[0].upper()}{head[1:]} the residual: {falls}."
    if trace.block and not trace.effects:
        named = f"{error} {_amount(trace.by_causes[channel], channel)}"
        less = f"{_amount(after, channel)} with a learnt block"
        return f"No effect explains the residual: {named}, {less}, {floor}."
    if not trace.effects:
        falls = f"{error} {_amount(after, channel)}, {floor}"
        return f"None of the {len(EFFECTS)} effects explains the residual: {falls}."
    return f"{head[0].upper()}{head[1:]} a part of the residual: {falls}."


def _chi_squares(s: StageTrace) -> tuple[float, float]:
    """Chi-square of a stage before and after; simulated from the command where effects were last fitted so,
    and the pressure that was measured says nothing of them."""
    declared, chosen = s.search.declared.model, s.search.chosen.model
    if s.model.forms and chosen.chi2 > declared.chi2:
        declared, chosen = declared.freely, chosen.freely
    return declared.chi2, chosen.chi2


def evidence(trace: Trace) -> str:
    """How chi-square moved in each stage, and how many effects were refitted."""
    said = []
    for s in trace.stages:
        declared, chosen = _chi_squares(s)
        moved = f" to {fixed(chosen, 2)}" if s.model.forms else ""
        said.append(f"{channel_name(s.stage.channel)} {fixed(declared, 2)}{moved}")
    rounds = [r for s in trace.stages for r in s.search.rounds]
    tried = len({name for r in rounds for c in r.candidates for name in c.model.effects})
    refitted = f"{tried or 'none'} of {len(EFFECTS)} effects {'was' if tried == 1 else 'were'} refitted"
    return f"Chi-square per row (1: noise alone): {', '.join(said)}; {refitted}."


FEW = 6
"""Names that a sentence of at most 20 words has room for."""


def still_open(trace: Trace) -> str:
    """What these recordings cannot decide, and how much of the plant is assumed."""
    blind = list(trace.cannot_judge)
    named = listed(blind) if len(blind) <= FEW else f"{len(blind)} of {len(EFFECTS)} effects"
    told = (
        f"These recordings cannot decide {named}"
        if blind
        else f"Each of the {len(EFFECTS)} effects would have shown in these recordings"
    )
    count, assumed = len(trace.revised.parameters), len(trace.revised.assumed)
    rest = (
        f"{assumed} of {count} parameters {'is' if assumed == 1 else 'are'} assumed"
        if assumed
        else f"all {count} parameters are fitted or stated"
    )
    return f"{told}; {rest}."


def verdict_sentence(trace: Trace) -> str:
    """The verdict in one sentence, with the errors that it rests on."""
    if trace.worse:
        return _worse(trace)
    if trace.verdict == "nothing-missing":
        return _nothing(trace)
    if trace.verdict == "explained":
        return _explained(trace)
    return _unexplained(trace)


def _worse(trace: Trace) -> str:
    channel = _logged(trace)[0]
    return (
        f"The revised plant is worse on the held-out recordings: the {channel_name(channel)} error rises "
        f"from {number(trace.before[channel])} to {_amount(trace.after[channel], channel)}; use the declared "
        "plant."
    )


def _explained(trace: Trace) -> str:
    channel = _logged(trace)[0]
    falls, left = _falls(trace), trace.remainder[channel]
    if trace.effects:
        said = f"{_happens(trace.effects)}: with {added(trace.effects)} added, {falls}"
    else:
        said = f"{_law_words(trace)}: with it {falls}"
    if left is not None and left.rms > (trace.noise[channel] or 0.0):
        said += f"; the residual beyond noise is {_share(left.share_of_range)} of the range"
    either = [f"{e.name} from {' or '.join(e.alternatives)}" for e in trace.effects if e.alternatives]
    return f"{said}{f'; these recordings do not distinguish {_and(either)}' if either else ''}."


def _law_words(trace: Trace) -> str:
    return f"Four straight segments do not describe this loop; the law {trace.revised.law.NAME} does"


def block_words(trace: Trace) -> list[str]:
    """What a learnt block does, or why there is none, in a sentence; nothing where none was asked for."""
    if not trace.learning:
        return []
    block, before = trace.block, (trace.named_only or {}).get("angle_deg")
    if block is None or before is None:
        if all(s.explained for s in trace.stages if s.stage.channel == "angle_deg"):
            return ["No learnt block: the angle has no residual that is left unexplained."]
        return ["No learnt block: none lowers the angle error on rows left out by enough."]
    unit = trace.revised.kinds["learnt.low"].unit
    low, high = (round(float(end), 1) for end in (block.low, block.high))
    return [
        f"A learnt block, which names no cause, changes the angle error on the held-out recordings from "
        f"{number(before)} to {_amount(trace.after['angle_deg'], 'angle_deg')}. It was learnt from "
        f"{number(low)} to {number(high)} {unit}, and fades to nothing outside."
    ]


def log_words(trace: Trace) -> list[str]:
    """What the log does, how the hysteresis law was chosen, and what was remarked, in sentences."""
    law = [law_sentence(trace.law)] if trace.law is not None else []
    if (alone := trace.law_alone.get("angle_deg")) is not None:
        law.append(
            f"Before is with the hysteresis law {trace.fit.fitted.law.NAME}. With {trace.other_law} and no "
            f"effect the angle error on the held-out recordings is {_amount(alone, 'angle_deg')}."
        )
    return [*law, *(f"Instrument: {r}" for r in trace.instrument), *trace.remarks]


def _share(share: float) -> str:
    return f"{100.0 * share:.2g} %"


def _nothing(trace: Trace) -> str:
    logged = _logged(trace)
    left = _and(f"{_amount(trace.before[c], c)} of the {channel_name(c)}" for c in logged)
    noise = _and(_amount(trace.noise[c], c) for c in logged)
    slow = [channel_name(c) for c in logged if (trace.before[c] or 0.0) > SLOW * (trace.noise[c] or 0.0)]
    said = (
        f"Nothing is missing: on the held-out recordings the RMSE of the declared model is {left}, "
        f"and the noise is {noise}"
    )
    if slow:
        said = said.replace(", and the noise is", ", the sample-to-sample noise is")
        said += f"; the residual of the {_and(slow)} has no more structure than slow noise"
    return f"{said}."


def _unexplained(trace: Trace) -> str:
    stages = trace.unexplained or list(trace.stages)
    channel = _logged(trace)[0] if _logged(trace) else stages[0].stage.channel
    share, left = trace.explained_share.get(channel), trace.remainder.get(channel)
    off = [w for i, s in enumerate(stages) if (w := _still(trace, s.stage.channel, i == 0))]
    on = depends(stages[0].after.depends_on)
    if len(stages) > 1:
        on = on.replace("the residual", f"the residual of the {channel_name(stages[0].stage.channel)}")
    law = trace.law is not None and trace.revised.law.NAME != trace.fit.before.law.NAME
    if (trace.effects or law) and share is not None and left is not None:
        causes = [e.name for e in trace.effects] + (
            [f"the hysteresis law {trace.revised.law.NAME}"] if law else []
        )
        explain = "explains" if len(causes) == 1 else "explain"
        head = (
            f"{_and(causes)} {explain} {100.0 * share:.0f} % of the variance of the {channel_name(channel)} "
            f"error; the unexplained residual, {_share(left.share_of_range)} of the range, has structure"
        )
        return f"{head[0].upper()}{head[1:]}: {_and(off)}; {on}." if off else f"{head}; {on}."
    head = f"The residual has structure that none of the {len(EFFECTS)} effects explains"
    return f"{head}: {_and(off)}; {on}." if off else f"{head}; {on}."


def _still(trace: Trace, channel: str, first: bool) -> str:
    """The error of the plant in a channel that is not explained; empty where it was not judged."""
    after, noise = trace.by_causes[channel], trace.noise[channel]
    if after is None:
        return ""
    times = f" ({number(after / noise, 2)} times the noise)" if noise else ""
    where = "on the held-out recordings " if first else ""
    still = "is still" if trace.effects else "is"
    return f"the {channel_name(channel)} error {where}{still} {_amount(after, channel)}{times}"


def _falls(trace: Trace) -> str:
    """What the effects do to the errors, of the channels that they act on."""
    stages = {e.stage for e in trace.effects}
    channels = [c for c in _logged(trace) if c == "angle_deg" or "regulator" in stages]
    said = [
        f"the {channel_name(c)} error {'on the held-out recordings ' if i == 0 else ''}"
        f"falls from {number(trace.before[c])} to {_amount(trace.after[c], c)}"
        for i, c in enumerate(channels)
    ]
    noise = _and(_amount(trace.noise[c], c) for c in channels)
    return f"{_and(said)}; the noise is {noise}"


def _logged(trace: Trace) -> list[str]:
    """Channels that were logged and can be judged, the angle first."""
    return [c for c in UNITS if trace.before.get(c) is not None and trace.noise.get(c) is not None]


def _amount(value: float | None, channel: str) -> str:
    return f"{number(value)} {UNITS[channel]}"


def _happens(effects: Sequence[Named]) -> str:
    words = [form_of(e.name, e.form).HAPPENS for e in effects]
    return _and([words[0], *(w[0].lower() + w[1:] for w in words[1:])])


def added(effects: Sequence[Named]) -> str:
    """Effects and their forms, as a list in a sentence."""
    return _and(f"{e.name} ({e.form})" for e in effects)


def _and(words: Iterable[str]) -> str:
    return listed(list(words))


def stage_title(stage: StageTrace) -> str:
    """What a page calls a stage."""
    words = {
        "regulator": "Regulator: from the command to the pressure",
        "wrist": "Wrist: from the pressure to the angle",
        "whole": "From the command to the angle, since no pressure was logged",
    }
    return words[stage.name]
