# %% [markdown]
# # 3 How far to trust it, across the branches
#
# **Two pairs of gains meet every limit of notebook 2: the tuned one on the edge, and a more cautious one.
# Each is stable on each branch. What can be said of the loop that moves between the branches, on plants
# that are not quite as believed?**
#
# Three kinds of statement are made below, and they must not be mixed up. A *certificate* is proved, for a
# whole class of loops, and checked apart from the solver that found it. A *prediction* comes from linear
# theory or the describing function, and is only as good as their premises. A *sample* was simulated, and
# says nothing beyond its statistics.

# %%
# %matplotlib inline
import numpy as np

import design
import plants
from design import (
    PAPER_GAINS,
    RUNGS,
    STEP,
    Conditions,
    LoopModel,
    assess,
    box_of,
    default_problem,
    envelopes,
    evaluate,
    gain_plane,
    growth_of,
    limit_cycles,
    monte_carlo,
    worst_run,
)
from plants import built_in
from reports.notebooks.figures import word_growth
from reports.notebooks.tables import Markdown, limits_held, rows, shown
from reports.robustness import captions
from reports.robustness.branch_figures import describing, sensitivities
from reports.robustness.disagreements import disagreement_sentences
from reports.robustness.figures import draw_envelopes, draw_gain_plane, draw_worst
from reports.robustness.tables import box_table, cycle_table, margin_table
from reports.shared.figures.style import LINES, new_figure, styled
from reports.shared.tables import number

wrist = plants.Wrist.flexion()
gains = {"tuned": (3.13, 10.37), "cautious": (2.3, 6.4)}
problem = default_problem(wrist)
limits_held(problem, evaluate(problem, *zip(*gains.values(), strict=True)), gains)

# %% [markdown]
# Hardly anything of this plant was measured (notebook 1), so every statement has to hold on a *box* of
# plants: assumed parameters off by assumed shares.

# %%
box = box_of(built_in("flexion"))
shown(box_table(box))

# %%
found = {name: assess(box, design.PI(*pair), budget=4000) for name, pair in gains.items()}
tuned, cautious = found["tuned"], found["cautious"]

# %% [markdown]
# (The search for the worst case is given 4000 runs here; the command `wrist robust` takes more by default.)
#
# ## Predictions: every branch has margins to spare
#
# The loop of the tuned pair on each branch and at each rate of the regulator. "Steepest" is what a small
# motion about a moving equilibrium meets, a little above the fast rate.

# %%
shown(margin_table(tuned))

# %%
sensitivities(wrist, tuned.controller, tuned.limits)

# %% [markdown]
# *What to see: each line is one branch at one rate; all stay below the limit on the left, and on the right
# below the curve under which no dead time up to the limit can matter.* Linear theory has no objection, and
# neither has the describing function of the loop: it predicts no oscillation for either pair. That it can
# predict one is seen with far more integral gain:

# %%
wild = design.PI(1.0, 40.0)
assert not tuned.cycles
assert not cautious.cycles
cycles = limit_cycles(wrist, wild)
describing(wrist, wild, cycles)

# %%
assert all(c.confirmed for c in cycles)
shown(cycle_table(cycles))

# %% [markdown]
# *What to see: where the curve of the loop at the right rate meets -1/N of the hysteresis, an oscillation
# can sustain itself.* Of two such cycles one repels and one attracts: swings smaller than the first die
# away, larger ones end at the second. The simulator confirms both (its values in brackets); how far the
# amplitudes are off is what an approximation by one harmonic costs. The return from 15 degrees to 0 ends on
# the cycle that attracts:

# %%
held = wrist.rest("line1", STEP)
_, _, swing = design.run(wrist, wild, 0.0, held, duration=20.0, record=True)
_, _, still = design.run(wrist, tuned.controller, 0.0, held, duration=20.0, record=True)
last = swing.time > 15.0
amplitude = 0.5 * np.ptp(swing.angle[last, 0])
print(f"Kp {wild.Kp:g}, Ki {wild.Ki:g}: still swinging by +-{amplitude:.1f} deg after 15 s")
assert abs(amplitude / cycles[-1].seen_amplitude_deg - 1.0) < 0.1
assert np.ptp(still.angle[last, 0]) < 0.01
with styled():
    figure, (axes,) = new_figure(height=2.9)
    axes.plot(swing.time, swing.angle[:, 0], label=f"Kp {wild.Kp:g}, Ki {wild.Ki:g}", **LINES[1])
    axes.plot(still.time, still.angle[:, 0], label="tuned", **LINES[0])
    axes.set(xlabel="Time [s]", ylabel="Angle [deg]", xlim=(0, 20), title="A limit cycle, and none")
    figure.legend(loc="outside lower center", ncols=2)
figure

# %% [markdown]
# *What to see: the wild loop swings on, the tuned one comes to rest.*
#
# ## Certificates: stable on each branch is not stable between them
#
# Margins are of one branch at a time. Two stable linear systems, switched at the right moments, can grow.
# Is there a Lyapunov function that falls on all branches and at all rates at once? The rungs go from the
# widest class of loops (slope and rate change at will) to a narrower one (the regulator obeys some fixed
# law of its kind, and only the slope changes at will), and end with the loop's own memory, once no more than
# one of its lines is met:

# %%
rungs = zip(tuned.ladder, cautious.ladder, strict=True)
rows(
    {
        "rung": one.rung,
        "dead time [ms]": 1000 * one.dead_time,
        "tuned: decays at [1/s]": number(one.decay) if one.holds else "none found",
        "cautious: decays at [1/s]": number(other.decay) if other.holds else "none found",
    }
    for one, other in rungs
)

# %% [markdown]
# The cautious pair is certified for the narrower class, with 50 ms of dead time on top. For the tuned pair
# nothing is found wherever slopes switch at will. That alone would mean little: no proof found is not a
# disproof. But against arbitrary switching there is a disproof, a *word*: an order of branches and rates,
# repeated, under which the state grows. With the memory of the loop both pairs are certified, fast: what the
# word does, a loop that remembers cannot do.

# %%
word = tuned.word
assert word.grows
assert not any(c.holds for c in tuned.ladder if not c.remembers)
assert any(c.holds for c in cautious.ladder if not c.remembers)
assert all(c.holds for a in (tuned, cautious) for c in a.ladder if c.remembers)
print(*str(word).split(", "), sep=",\n")
word_growth(growth_of(LoopModel.of(wrist, tuned.controller), word))

# %% [markdown]
# *What to see: each letter alone decays, the word grows from pass to pass.* The wrist cannot spell this
# word, since its rate follows from the error of its pressure and its slope from which way it moves. But no
# function can prove a loop safe whose class contains it. The cautious pair has such a word too, a slower
# one; its certificate is of the narrower class.

# %%
print(f"growth of the word: tuned {word.growth:.3f} 1/s, cautious {cautious.word.growth:.3f} 1/s")
assert cautious.word.growth < word.growth

# %% [markdown]
# The whole plane of the gains (a grid of 14 x 14, coarser than the command's, to save time):

# %%
plane = gain_plane(problem, tuple(RUNGS), points=14)
marks = {name: pair for name, pair in gains.items()} | {"paper's stand-in": PAPER_GAINS}
draw_gain_plane(plane, problem.limits, marks)

# %% [markdown]
# *What to see: the star, tuned, stands just outside what is certified, the cautious pair inside. For loops
# whose slope and rate change at will (dark) only very slow gains are certified.* The certified regions and
# those of the limits (lines) do not nest: a certificate knows nothing of overshoot, and a limit nothing of
# switching.
#
# ## Samples: what happens on plants like this one
#
# Plant, memory, sign of the step, up to 50 ms of dead time, load, noise and resolution of the sensor are
# drawn at random. The share of cases that break a limit comes with its exact (Clopper-Pearson) interval at
# 95 %.

# %%
rows(
    {
        "in how many of the cases": of_tuned.words,
        "tuned": f"{of_tuned.count} of {of_tuned.trials}",
        "tuned: 95 % interval [%]": f"{100 * of_tuned.low:.2f} to {100 * of_tuned.high:.2f}",
        "cautious": f"{of_cautious.count} of {of_cautious.trials}",
        "cautious: 95 % interval [%]": f"{100 * of_cautious.low:.2f} to {100 * of_cautious.high:.2f}",
    }
    for of_tuned, of_cautious in zip(tuned.cases.violations, cautious.cases.violations, strict=True)
)

# %%
draw_envelopes(envelopes(tuned.cases), STEP)

# %% [markdown]
# *What to see: nine tenths of the cases lie within the band; its upper edge passes the reference by more
# than the limit on overshoot allows.* Is it the tube, or the rates of the regulator, which the corners of
# the tuning did not vary?

# %% tags=["varies"]
without = monte_carlo(box, tuned.controller, Conditions(dead_time=0.0))
for name, cases in {"with up to 50 ms of dead time": tuned.cases, "without": without}.items():
    overshoot = next(v for v in cases.violations if v.requirement == "overshoot_percent")
    print(f"{name}: {overshoot.count} of {overshoot.trials} cases overshoot by more than 5 %")

# %% [markdown]
# The tube, nearly alone. The delay margin, several times as long as the tube, did not warn of it: it is
# of instability, not of overshoot.
#
# Chance does not look for trouble. A search over the same box, the memory and three references does:

# %% tags=["varies"]
Markdown("\n".join(f"- *{name}*: {captions.worst_words(a)}" for name, a in found.items()))

# %%
draw_worst(tuned.worst, worst_run(tuned.worst))

# %% [markdown]
# *What to see: two steps that put the loop's memory in an awkward place, then the one that is judged
# (shaded).* Overshoot is counted as a share of that last step. Such a scenario can be kept (`wrist robust
# --worst FILE`), played again (`wrist simulate --scenario FILE`) and tuned against (`wrist tune --robust`).
#
# ## Where the kinds disagree
#
# Each kind is right about what it covers. The assessment names its own contradictions:

# %% tags=["varies"]
Markdown("\n".join(f"- *{name}*: {said}" for name, a in found.items() for said in disagreement_sentences(a)))

# %% [markdown]
# ## What follows, and what does not
#
# Margins on every branch are necessary and not enough: both pairs have them, and only the cautious one kept
# its limits in all samples. The price is speed; the table at the top says how much. For the cautious pair
# you may conclude that the modelled loop does not go on oscillating while its command stays within the
# range, with 50 ms of dead time too, for every regulator of the class. You may not conclude that it never
# overshoots by more than 5 %: the search found a way, and "none of the samples" means at most the upper end
# of its interval. For neither pair is anything said about effects that are in no model here, stick-slip
# above all, nor about plants outside the box, whose shares are assumed. A measured campaign replaces
# assumed shares by standard errors (notebook 5), which is the better half of robustness.
