# %% [markdown]
# # 0 Quickstart: from a log to gains
#
# **Ten cells: a recorded campaign is fitted, a PI is tuned, judged with up to 50 ms of dead time, and its
# gains are written for the other commands.** `wrist design` does the same at full effort and asks for proofs.

# %%
# %matplotlib inline
from pathlib import Path
from tempfile import mkdtemp

import design
import plants
from reports.notebooks.tables import shown
from reports.shared.card import CardRow, draw_steps, matrix_table
from reports.shared.fit import draw_fit
from reports.shared.gain_map import gain_map

# %% [markdown]
# ## Fit
#
# The campaign is synthetic; its folder holds `campaign.toml` and CSV files. RMSE and noise are in deg.

# %%
campaign = plants.load_campaign(Path(plants.__file__).parent / "measured/examples/flexion")
fit = plants.fit_campaign(campaign, plants.built_in("flexion"), starts=2)
print(f"held-out RMSE {fit.validate_rmse['angle_deg']:.3f}, noise {fit.noise['angle_deg']:.3f}")

# %%
draw_fit(fit)

# %% [markdown]
# ## Tune
#
# The least worst IAE under limits on overshoot, Ms, Mt, delay margin and command, on every branch.

# %%
wrist = plants.Wrist.of(fit.fitted)
tuned = design.tune(design.default_problem(wrist), design.Region(points=12), starts=1)
print(f"Kp = {tuned.Kp:.3g} kPa/deg, Ki = {tuned.Ki:.3g} kPa/(deg s), active limit: {tuned.active}")

# %%
gain_map(tuned)

# %% [markdown]
# ## Judge
#
# The requirement of the rig adds what tuning did not see: up to 50 ms of dead time, loads, sensor noise,
# perturbed plants. Half the gains are the cautious candidate.

# %%
candidates = {
    "tuned PI": design.PI.of(wrist, tuned.Kp, tuned.Ki),
    "cautious PI": design.PI.of(wrist, 0.5 * tuned.Kp, 0.5 * tuned.Ki),
}
found = design.decide(
    "flexion", design.requirement(fit.fitted), candidates, samples=400, runs=600, prove=False
)
for name, count in found.candidates.items():
    broken, total = count["samples_broken"], count["samples"]
    print(f"{name}: {broken} of {total} fresh samples break a limit")

# %% [markdown]
# Of these two the decision card takes the one that breaks limits least; ▲ marks what is still broken.

# %%
card = CardRow("flexion", found.controller, found.gains, found.matrix, found.evidence["proved"], found.band)
shown(matrix_table([card]))

# %%
draw_steps([card])

# %% [markdown]
# ## Export
#
# The file is taken by `wrist robust --gains FILE` and `wrist export pi --gains FILE`, which writes C.

# %%
written = design.write_gains(Path(mkdtemp()) / "gains.toml", found.gains, {"plant": fit.fitted.title})
print(written.read_text())
