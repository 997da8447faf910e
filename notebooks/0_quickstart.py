# %% [markdown]
# # 0 Quickstart: from a log to gains
#
# **Which gains does a recorded rig need?** Ten cells: the campaign is fitted, a PI is tuned for the whole
# uncertainty stated in the rig's file, dead time included, and compared with a PI tuned for the step
# only. `wrist design` does the same at full effort, with a second degree of freedom and proofs.

# %%
# %matplotlib inline
from pathlib import Path
from tempfile import mkdtemp

import design
import plants
from reports import CardRow, draw_fit, draw_steps, gain_map, matrix_table, shown

# %% [markdown]
# ## Fit
#
# The campaign is synthetic; its folder has `campaign.toml` and CSV files. RMSE and noise are in deg.

# %%
campaign = plants.load_campaign(Path(plants.__file__).parent / "measured/examples/flexion")
fit = plants.fit_campaign(campaign, plants.built_in("flexion"), starts=2)
print(f"held-out RMSE {fit.validate_rmse['angle_deg']:.3f}, noise {fit.noise['angle_deg']:.3f}")

# %%
draw_fit(fit)

# %% [markdown]
# *What to see: the model follows the measured pressure and angle; the error below is noise.*
#
# ## Tune
#
# The worst-case IAE is minimised under limits on overshoot, Ms, Mt, delay margin and command. `simple`
# meets them on every branch without dead time; `tuned` meets them for the whole requirement: a search
# adds worst cases until it finds no more.

# %%
wrist, asked = plants.Wrist.of(fit.fitted), design.requirement(fit.fitted)
simple = design.tune(design.default_problem(wrist), design.Region(points=12), starts=1)
tuned = design.tune_robustly(asked, design.Region(points=12), starts=1)
for name, found in (("simple", simple), ("tuned", tuned.final)):
    print(f"{name}: Kp = {found.Kp:.3g} kPa/deg, Ki = {found.Ki:.3g} kPa/(deg s)")

# %%
gain_map(simple)

# %%
gain_map(tuned.final)

# %% [markdown]
# *What to see: the requirement reduces the feasible region and excludes the fastest gains.*
#
# ## Judge
#
# Fresh samples and a search for the worst case judge both PIs: perturbed plants, loads, sensor noise, every
# initial state, and dead time.

# %%
candidates = {
    "PI": tuned.final.controller,
    "PI tuned without dead time": simple.controller,
}
decided = design.decide("flexion", asked, candidates, samples=400, runs=600, prove=False)
for name, count in decided.candidates.items():
    broken, total = count["samples_broken"], count["samples"]
    print(f"{name}: {broken} of {total} fresh samples break a limit")
print(f"longest dead time {1000 * decided.dead_time:.0f} ms")

# %% [markdown]
# The decision card shows the PI with the fewest broken limits; ▲ marks a broken limit.

# %%
card = CardRow(
    "flexion", decided.controller, decided.gains, decided.matrix, decided.evidence["proved"], decided.band
)
shown(matrix_table([card]))

# %%
draw_steps([card])

# %% [markdown]
# *What to see: with the longest dead time the step stays below the limit on overshoot, from every initial
# state.*
#
# ## Export
#
# The file is read by `wrist robust --gains FILE` and `wrist export pi --gains FILE`, which writes C.

# %%
written = design.write_gains(Path(mkdtemp()) / "gains.toml", decided.gains, {"plant": fit.fitted.title})
print(written.read_text())

# %% [markdown]
# ## What follows, and what does not
#
# These gains met every limit in all samples and search runs; this is no proof. `wrist design` computes
# certificates, and `wrist trace` tests whether the model lacks an effect.
