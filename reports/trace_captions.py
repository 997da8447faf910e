"""What a trace's page says around its figures and tables."""

from design.metrics import SETTLING_BAND
from design.retune import Control
from design.tasks import STEP
from plants.measured.trace.choose import WORTH
from plants.measured.trace.trace import StageTrace, Trace
from reports.comparison_tables import CHANNELS
from reports.tables import number
from reports.trace_fit_figures import shown_run
from reports.trace_words import added, describe, description

TITLES = {
    "nothing-missing": "Nothing is missing",
    "explained": "What the declared wrist lacks",
    "unexplained": "Something is left unexplained",
}
"""The title of a page, by verdict."""

REVISED = "the revised wrist"

ERRORS = (
    "Errors of free runs on the recordings that took no part, their intervals at 95 % as bars, and the "
    "noise of the sensors as a line."
)
RANKING = (
    "Each effect in the best of its forms: by how much it would lower chi-square, beyond what a refit of "
    "the parameters that are there could do. The tick is what the largest of so many comparisons "
    "would reach on noise alone, in 95 % of draws; the dashed line is the least that an effect must bring. "
    "Coloured: refitted fully, with the chi-square that it came to. Green: taken. "
    "Of rounds after the first only the strongest are drawn."
)
DESCRIPTION = (
    "What is left against what it depends on: rows of the recordings, their mean, and, where one earned "
    "its place, the curve learnt from them. It is a description, not a cause."
)
CAUTION = (
    "The revised plant does not explain its recordings, so a rig may well answer otherwise than this says."
)


def after_words(trace: Trace) -> str:
    """What the second of two models is."""
    if trace.effects:
        return f"the revised plant, with {added(trace.effects)} added and all parameters fitted anew."
    return "the same wrist, since nothing was added."


def series(trace: Trace, channel: str) -> str:
    """What a figure over time shows."""
    run, word = shown_run(trace, channel), CHANNELS[channel][0].lower()
    part = "took no part in fitting or choosing" if run.role == "validate" else "took part in the fit"
    return (
        f"The {word} of {run.recording.name}, which {part}: measured, and simulated from the command alone; "
        "beneath, what each model leaves, measured minus simulated. The grey band holds 95 % of the noise."
    )


def loop(trace: Trace) -> str:
    """What the loop shows."""
    models = "the declared and the revised wrist" if trace.effects else "the declared wrist"
    return f"The loop: angle over pressure in the first seconds, measured and simulated with {models}."


def left(stage: StageTrace, after_name: str) -> str:
    """What is left of a stage before the effects and after, in sentences."""
    before, after, channel = stage.before, stage.after, stage.stage.channel
    if not before.structured:
        return f"nothing but noise, {number(before.rmse)} {CHANNELS[channel][1]}."
    said = f"Before: {describe(before, channel)}"
    if after is before:
        return said
    then = "After" if after_name == REVISED else f"With what was tried ({', '.join(stage.model.effects)})"
    if after.structured:
        return f"{said} {then}: {describe(after, channel)}"
    return f"{said} {then}: {number(after.rmse)} {CHANNELS[channel][1]}, nothing but noise."


def remainder(stage: StageTrace, after_name: str) -> str:
    """What the figure of a remainder shows."""
    both = stage.after is not stage.before
    which = "the declared wrist" + (f" and by {after_name}" if both else "")
    return (
        f"What is left by {which}: mean over the variables that tell most, autocorrelation and spectrum. "
        f"Noise alone stays in the grey band{', for the latter' if both else ''}; for the autocorrelation, "
        "white noise."
    )


def after_name(trace: Trace) -> str:
    """What a stage's model after the search is called: it was not adopted where it does not help."""
    return REVISED if trace.effects else "what was tried"


def plant_words(trace: Trace) -> str:
    """What the table of parameters shows."""
    if not trace.effects:
        return "Nothing was added: these are the declared parameters, fitted to the recordings."
    return (
        "Everything was fitted together, so the declared parameters moved too. revised.toml beside this page "
        "holds the plant; wrist tune, compare, simulate and show take it with --plant."
    )


def no_alternatives(trace: Trace) -> str:
    """That no effect could be another."""
    if trace.effects:
        return "None: no other effect does as well in its place."
    return "None, since nothing was added."


def nothing_refitted(stage: StageTrace) -> str:
    """Why nothing was refitted."""
    chi2 = stage.search.declared.model.chi2
    if chi2 <= 1.0 + WORTH:
        return f"The declared model is at the noise: chi-square {number(chi2)}. Nothing was to be added."
    return f"Chi-square is {number(chi2)}, and no effect would lower it by more than chance would."


def what_is_left(stage: StageTrace, adopted: bool) -> str:
    """What no effect explains of a stage; `adopted`: what was tried became part of the plant."""
    said = describe(stage.after, stage.stage.channel)
    if stage.model.forms and not adopted:
        return f"Even with what was tried ({', '.join(stage.model.effects)}) {said}"
    return said


def learnt(stage: StageTrace) -> str:
    """The description of what is left, or that there is none."""
    if stage.learnt is not None:
        return description(stage.learnt)
    return "No smooth curve of a variable describes it on blocks of time that were left out."


def control(control: Control) -> str:
    """What the figure of the steps shows."""
    which = "the PI that was tuned" if control.same else "the PIs of the declared and of the revised plant"
    return (
        f"A step of {STEP:g} deg from rest on {control.judge}, under {which}: angle of the joint with the "
        f"band of ±{100 * SETTLING_BAND:g} %, and command."
    )


def versions() -> str:
    """Python and the packages that computed a trace, with their versions."""
    from importlib.metadata import version
    from platform import python_version

    packages = ("numpy", "scipy", "numba", "casadi", "scikit-learn")
    return ", ".join([f"Python {python_version()}", *(f"{p} {version(p)}" for p in packages)])
