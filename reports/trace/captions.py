"""What a trace's page says around its figures and tables."""

import numpy as np

from design.synthesis.retune import Control
from plants.measured.fitting.blocks import BLOCK
from plants.measured.fitting.free_run import rmse
from plants.measured.residual.examine import Examination
from plants.measured.trace.result import StageTrace, Trace
from plants.measured.trace.search.candidate import WORTH
from plants.measured.trace.search.worth import SHARE, TRIFLE
from plants.parameters.remainder import RemainderSize
from reports.shared.dynamics import dynamics_words
from reports.shared.figures.fit import LOOP_SECONDS
from reports.shared.names import CHANNELS
from reports.shared.tables import listed, number
from reports.trace.fit_figures import loop_run, shown_run
from reports.trace.residual_words import depends, describe, description
from reports.trace.words import added

TITLES = {
    "nothing-missing": "The declared model explains the recordings",
    "explained": "The declared model lacks: {}",
    "unexplained": "The recordings are not fully explained",
}
"""The title of a page, by verdict; the effects stand in it."""

REVISED = "the revised wrist"

ERRORS = (
    "RMSE of open-loop simulations on the held-out recordings, with 95 % intervals; dashed: noise of the "
    "sensors, the least that any model can reach."
)
RANKING = (
    "Each effect in its best form: estimated reduction of chi-square beyond a refit of the present "
    "parameters. Dashed: threshold for selection. Tick: 95 % quantile of the largest reduction on noise "
    "alone."
)
DESCRIPTION = (
    "Residual against the variables it depends on: samples of the recordings as dots, their mean, and, where "
    "one was selected, a fitted curve: a description, not a cause."
)
CAUTION = "The revised plant does not explain its recordings, so the rig may behave differently."


def title(trace: Trace) -> str:
    """The heading of a page."""
    return TITLES[trace.verdict].format(listed([e.name for e in trace.effects]))


def errors(trace: Trace) -> str:
    """Each channel's error before and after, and what is drawn."""
    said = []
    for channel, (word, unit) in CHANNELS.items():
        before, after = trace.before.get(channel), trace.after.get(channel)
        if before is not None and after is not None:
            said.append(f"{word} {number(before)} {unit} before, {number(after)} {unit} after")
    return f"{'; '.join(said)}. {ERRORS}" if said else ERRORS


def choice_words() -> list[str]:
    """How effects are chosen, in paragraphs."""
    return [
        "In each round every effect that the model lacks is ranked by the reduction of chi-square, the mean "
        "square of the residual in units of the noise: 1 is noise alone. The first few are then fitted "
        "together with all other parameters.",
        "Where the tests above find structure in the residual, an effect is selected if chi-square on "
        f"held-out blocks of at most {BLOCK:g} s falls by more than {WORTH:g}, by more than "
        f"{100 * SHARE:g} % of its excess over 1, and by more than {100 * TRIFLE:g} % of the reduction by "
        "earlier effects. "
        "Where the residual looks like noise, chi-square on all rows must fall by as much, and the "
        "log-likelihood of the residual, as noise of any colour, must rise by more than a fit to "
        "slow noise would gain. The best such effect is selected; if there is none, the search ends.",
    ]


def ranking(stage: StageTrace) -> str:
    """How to read the ranking of a stage."""
    rounds = stage.search.rounds
    chosen = [r.taken for r in rounds if r.taken is not None]
    taken = chosen[-1].model.effects if chosen else ()
    words = [f"Selected: {listed(list(taken))}." if taken else "Nothing was selected.", RANKING]
    if any(r.candidates for r in rounds):
        words.append("Dark: refitted fully; number: resulting chi-square.")
    if chosen:
        words.append("Hatched: selected.")
    if len(rounds) > 1:
        words.append("After the first round only the strongest are drawn.")
    if any(r.before.model.forms == () for r in rounds[1:]):
        words.append("Of two searches one begins with effects that nearly any rig has, fitted together.")
    return " ".join(words)


def after_words(trace: Trace) -> str:
    """What the second of two models is."""
    law = f"the hysteresis law {trace.other_law}, " if trace.other_law else ""
    if trace.effects:
        block = ", a learnt block" if trace.block else ""
        more = f"{law}{added(trace.effects)}{block}"
        return f"the revised plant, with {more} added and all parameters fitted anew."
    if law and not trace.block:
        return f"the wrist with {law}no effect added."
    if trace.block:
        return "the same wrist, with a learnt block beside it."
    return "the same wrist, since nothing was added."


def series(trace: Trace, channel: str) -> str:
    """What a figure over time shows."""
    run, word = shown_run(trace, channel), CHANNELS[channel][0].lower()
    part = "was held out" if run.role == "validate" else "was fitted to"
    before, after = (rmse([run], channel, b, run.role) for b in (True, False))
    unit = CHANNELS[channel][1]
    revised = f", {number(after)} {unit} revised" if trace.differs else ""
    return (
        f"RMSE {number(before)} {unit} declared{revised}: the {word} of {run.recording.name}, which {part}, "
        "measured and simulated from the command alone. Below: residuals; the grey band contains 95 % of the "
        "noise."
    )


def loop(trace: Trace) -> str:
    """By how much the angle of a loop departs, and what is drawn."""
    models = "the declared and the revised wrist" if trace.differs else "the declared wrist"
    run = loop_run(trace)
    said = ""
    measured = None if run is None else run.recording.angle
    if run is not None and measured is not None:
        first = run.recording.time <= run.recording.time[0] + LOOP_SECONDS
        sides = {"declared": run.angle_before, **({"revised": run.angle} if trace.differs else {})}
        far = [
            f"{name} {number(float(np.abs(a - measured)[first].max()))} deg"
            for name, a in sides.items()
            if a is not None
        ]
        said = f"Largest error of the angle: {', '.join(far)}. "
    return (
        f"{said}The loop: angle over pressure in the first {LOOP_SECONDS:g} s, measured and simulated with "
        f"{models}."
    )


def left(stage: StageTrace, after_name: str) -> str:
    """The residual of a stage before the effects and after, in sentences."""
    before, after, channel = stage.before, stage.after, stage.stage.channel
    if not before.structured:
        return f"No structure beyond noise: {number(before.rmse)} {CHANNELS[channel][1]}."
    said = f"Before: {describe(before, channel)}"
    if after is before:
        return said
    then = "After" if after_name == REVISED else f"With what was tried ({', '.join(stage.model.effects)})"
    if after.structured:
        return f"{said} {then}: {describe(after, channel)}"
    return f"{said} {then}: {number(after.rmse)} {CHANNELS[channel][1]}, no structure beyond noise."


def remainder(stage: StageTrace, after_name: str) -> str:
    """What the residual depends on, before and after, and what the figure of it shows."""
    both = stage.after is not stage.before
    sides = [stage.before, stage.after] if both else [stage.before]
    said = f"; of {after_name}: ".join(_structure(s) for s in sides)
    latter = ", drawn for the latter" if both else ""
    return (
        f"Residual of the declared wrist: {said}. Mean over the most significant variables, autocorrelation "
        f"and spectrum. Grey band: noise alone{latter} (for the autocorrelation, white noise)."
    )


def _structure(found: Examination) -> str:
    """What a residual depends on, in a few words."""
    if not found.structured:
        return "no structure beyond noise"
    said = depends(found.depends_on).removeprefix("the residual ").removeprefix("it ")
    return said.removeprefix("is ")


def after_name(trace: Trace) -> str:
    """What a stage's model after the search is called: it was not adopted where it does not help."""
    return REVISED if trace.effects or trace.block else "what was tried"


def plant_words(trace: Trace) -> str:
    """What the table of parameters shows."""
    if not trace.effects and not trace.block:
        of = (
            f"those of the hysteresis law {trace.other_law}" if trace.other_law else "the declared parameters"
        )
        return f"No effect was added: these are {of}, fitted to the recordings."
    return (
        "All parameters were fitted together, so the declared ones changed too. revised.toml beside this "
        "page is the plant; wrist tune, compare, simulate and show read it with --plant."
    )


def no_alternatives(trace: Trace) -> str:
    """That no effect could be another."""
    if trace.effects:
        return "None: no other effect fits as well."
    return "None, since nothing was added."


def nothing_refitted(stage: StageTrace) -> str:
    """Why nothing was refitted."""
    chi2 = stage.search.declared.model.chi2
    if chi2 <= 1.0 + WORTH:
        return f"The declared model is at the noise level: chi-square {number(chi2)}. No effect is needed."
    return f"Chi-square is {number(chi2)}, and no effect would lower it by more than chance would."


def what_is_left(stage: StageTrace, adopted: bool, left: RemainderSize | None) -> str:
    """What no effect explains of a stage; `adopted`: what was tried became part of the plant; left: size of
    it on held-out recordings."""
    said = describe(stage.after, stage.stage.channel)
    if stage.model.forms and not adopted:
        said = f"Even with what was tried ({', '.join(stage.model.effects)}) {said}"
    return said if left is None or left.weight is None else f"{said} {dynamics_words(left.weight)}"


def learnt(stage: StageTrace) -> str:
    """The description of the residual, or that there is none."""
    if stage.description is not None:
        return description(stage.description, stage.stage.channel)
    return "No smooth curve of a variable describes it on held-out blocks of time."


def control(control: Control) -> str:
    """What the figure of the steps shows."""
    which = "the PI that was tuned" if control.same else "the PIs of the declared and of the revised plant"
    task = control.task
    return (
        f"A step of {task.step:g} deg from rest on {control.judge}, under {which}: angle of the joint, and "
        f"command. Grey band: ±{100 * task.band:g} %."
    )


def versions() -> str:
    """Python and the packages that computed a trace, with their versions."""
    from importlib.metadata import version
    from platform import python_version

    packages = ("numpy", "scipy", "numba", "casadi", "scikit-learn")
    return ", ".join([f"Python {python_version()}", *(f"{p} {version(p)}" for p in packages)])
