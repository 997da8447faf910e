# %% [markdown]
# # 5 Identification from measured data
#
# **A model never describes a rig completely. Which effect does the model lack, how certain is this, and
# does it matter for the controller?**
#
# Two examples: a campaign with an undeclared effect, whose truth is known because it is *synthetic*, made
# by a simulator that shares no code with this project; and real rigs of other groups, whose truth is
# unknown.

# %%
# %matplotlib inline
import os
import tempfile
from pathlib import Path

import plants
from benchmarks.real_rigs.data import rigs
from benchmarks.real_rigs.figures import draw_rig
from benchmarks.real_rigs.outcome import outcome
from benchmarks.section_7_2 import draw_departure, reconstruct
from design import Region, retune
from plants import built_in, fit_campaign, load_campaign, trace_campaign
from reports import (
    Markdown,
    control_sentence,
    draw_control,
    draw_errors,
    draw_fit,
    draw_ranking,
    draw_remainder,
    draw_series,
    error_table,
    errors_before_and_after,
    parameter_table,
    rows,
    shown,
    verdict_sentence,
)

# %% [markdown]
# ## A campaign
#
# A campaign is a folder of recordings and a `campaign.toml` that lists the fit recordings. The others are
# held out: they are used only to report errors of open-loop simulations from the command.

# %%
folder = Path(plants.__file__).parent / "measured" / "examples" / "deviation"
print((folder / "campaign.toml").read_text())
campaign = load_campaign(folder)
rows(
    {
        "recording": r.name,
        "role": role,
        "rows": len(r.time),
        "seconds": float(r.time[-1] - r.time[0]),
        "angle from [deg]": float(r.angle.min()),
        "to [deg]": float(r.angle.max()),
    }
    for role, recordings in (("fit", campaign.fit), ("held out", campaign.validate))
    for r in recordings
)

# %% [markdown]
# ## Fitting the declared model is not enough
#
# First the parameters of notebook 1, fitted: each gets a value and a standard error in place of an
# assumption.

# %%
declared = built_in("deviation")
fit = fit_campaign(campaign, declared)
shown(parameter_table(fit.fitted, declared))

# %%
print(*fit.remarks, sep="\n")
shown(error_table(fit))

# %% [markdown]
# The pressure is explained down to the noise of its sensor, the angle is not: the residual is many times
# the noise. Small standard errors are no evidence of a good model: they are valid only if the model is
# complete.

# %%
assert fit.ratios["pressure_kPa"] < 1.2 < 3.0 < fit.ratios["angle_deg"]
draw_fit(fit)

# %% [markdown]
# *What to see: on a held-out recording the fitted model follows the measured angle, but the error below
# is an oscillation, not noise.*
#
# ## What is missing
#
# `trace_campaign` has 18 effects. At each stage it ranks the effects that act there by how much of the
# residual each could explain beyond a refit, refits the best few, and selects one only if it reduces the
# error on held-out blocks of time.

# %%
trace = trace_campaign(campaign, declared)
Markdown(verdict_sentence(trace))

# %%
stage = next(s for s in trace.stages if s.search.chosen.model.effects)
draw_ranking(stage)

# %% [markdown]
# *What to see: one bar per effect, logarithmic; tick: the reduction on noise alone; dashed line: the
# threshold for selection. One effect is orders of magnitude larger; once it is added, no other exceeds
# the threshold.*

# %%
rows(
    {
        "effect": e.name,
        "form": e.form,
        "parameter": name,
        "value": value,
        "unit": unit,
        "standard error": error,
    }
    for e in trace.effects
    for name, (value, unit, error) in e.parameters.items()
)

# %%
draw_remainder(stage)

# %% [markdown]
# *What to see: before (squares) the mean residual depends on several variables, and its spectrum has a
# line; after (dots) all are within the bounds of noise (grey).* The held-out recordings confirm this:

# %%
assert trace.verdict == "explained"
shown(errors_before_and_after(trace))

# %%
draw_errors(trace)

# %%
draw_series(trace, "angle_deg")

# %% [markdown]
# *What to see: declared and revised both follow the angle; the first error is a sinusoid, the second the
# noise of the sensor (band).* Effects that the recordings cannot decide are listed too, with the reason:

# %%
rows({"cannot be judged": name, "because": why} for name, why in trace.cannot_judge.items())

# %% [markdown]
# ## Does it matter for control?
#
# A PI tuned on the revised plant, beside a PI tuned on the fit without the effect; both are simulated on
# the revised plant. (A map of 24 x 24 gains and three local searches each.)

# %%
control = retune(trace.fit.fitted, trace.revised, region=Region(points=24), starts=3)
Markdown(control_sentence(control))

# %%
draw_control(control)

# %% [markdown]
# *What to see: two identical steps, both with a ripple.* The sinusoid is in the sensor: the loop follows
# the measured angle, and no PI can correct it. So it does not matter for the gains, but for the mount of
# the sensor. A dead time or creep would change the gains; this is decided by retuning, not by the size of
# the error.
#
# ## The paper's own residual
#
# On this motion the paper's simulation and experiment differ "at about 6 sec" (section 7.2), and the
# paper attributes this to the straight lines drawn through a curved loop. No measured curve is available,
# so this is a *reconstruction*: the simulator of the tests with branches that saturate, under the
# stand-in PI, beside the same rig with straight branches. The more curved, the later the largest
# difference.

# %%
rebuilt = reconstruct()
rows(
    {
        "knee [kPa]": d.strength,
        "step [deg]": d.step,
        "largest difference [deg]": d.largest,
        "at [s]": d.at,
    }
    for d in rebuilt.departures
    if d.form == "saturating"
)

# %%
draw_departure(rebuilt)

# %%
Markdown(
    "Nearest to 6 s: "
    + " and ".join(
        f"{t:.1f} s with a knee of {k:.0f} kPa in a step of {s:+.0f} deg"
        for s, (k, t) in rebuilt.nearest.items()
    )
    + f". A campaign of the milder rig, traced: {verdict_sentence(rebuilt.trace)}"
)

# %% [markdown]
# *What to see: both responses agree while the pressure is low, then the curved branch gives less angle
# than the line, and the integral action compensates it: the difference is largest seconds after the
# step.* So the paper's explanation is consistent, the trace finds it, and with it the error on held-out
# recordings falls to the noise.
#
# ## A real rig
#
# The data of other groups are not part of this repository; the cells below read them from the folder in
# the environment variable `WRIST_DATA`, and report if it is not set. The stored outputs were computed
# from these data.
#
# None of these rigs is a wrist with a declared loop. The declared model is fitted to them with the widest
# bounds, and no threshold of the trace was tuned on them. First a small pump with set-points that it
# cannot reach; then an arm of pneumatic muscles, whose joint has stick-slip.

# %% tags=["measured-data"]
data = os.environ.get("WRIST_DATA")
real = {rig.name: rig for rig in rigs(Path(data))} if data else {}
chosen = [real[name] for name in ("pressure-loop-staircases", "pam-joint-0") if real]
with tempfile.TemporaryDirectory() as made:
    outcomes = [outcome(rig, Path(data), Path(made)) for rig in chosen]
if outcomes:
    table = rows(
        {
            "rig": o.rig.title,
            "source": o.rig.origin,
            "licence": o.rig.licence,
            "rows fitted": sum(len(r.time) for r in o.campaign.fit),
            "rows held out": sum(len(r.time) for r in o.campaign.validate),
            "assumed": "; ".join(o.rig.assumed) or "nothing",
        }
        for o in outcomes
    )
else:
    table = Markdown("`WRIST_DATA` is not set: no measured data at hand, the cells below show nothing.")
table

# %% tags=["measured-data", "varies"]
Markdown("\n".join(f"- *{o.rig.title}*: {verdict_sentence(o.trace)}" for o in outcomes))

# %% tags=["measured-data"]
if outcomes:
    pump = outcomes[0]
    display(draw_rig(pump.rig, pump.fit, pump.trace))

# %% [markdown]
# *What to see: fitted to set-points that the pump cannot reach, the declared model has a very small gain
# and hardly moves on the held-out recording. With a drooping supply, the simulation follows the staircase,
# but not the sawtooth of the pump: it passes through its middle. Below, the residual is largest at the
# pressures where the pump cycles.* So the verdict is not "explained": the law describes the mean of this
# pump, not its cycle. How fast the pump lets air out the fitted recording hardly shows: whether
# `fill-exhaust-asymmetry` is adopted beside the droop is decided by the last digits of the processor.

# %% tags=["measured-data", "varies"]
shown(errors_before_and_after(pump.trace)) if outcomes else None

# %% tags=["measured-data"]
if outcomes:
    arm = outcomes[1]
    display(draw_rig(arm.rig, arm.fit, arm.trace))

# %% tags=["measured-data"]
if outcomes:
    assert {o.trace.verdict for o in outcomes} == {"unexplained"}
    assert "supply-droop" in [e.name for e in pump.trace.effects]
    assert not arm.trace.effects
shown(errors_before_and_after(arm.trace)) if outcomes else None

# %% [markdown]
# *What to see: the model moves when the pressure does, while the joint first sticks, then moves further;
# below, errors scatter widely at every command.* The library's `stick-slip` does not describe this joint, no
# effect was named, and the errors before and after are the same.
#
# ## What follows, and what does not
#
# Recordings replace assumptions by values with standard errors, and the residual shows whether these are
# valid. Where the missing effect is in the library, as in the synthetic campaign, it was identified, and
# the error on held-out recordings fell to the noise. Where it is not, as on both real rigs, the verdict
# was "unexplained", with the variables that the residual depends on. Do not tune on a plant with such a
# residual. You cannot conclude that a named effect is the cause: it is the one of 18 that explains these
# recordings, and effects that they do not excite are listed. Nor does success on a synthetic campaign,
# whose simulator is independent but whose authors are not, show how often real rigs will be explained: of
# the two here, none was.
