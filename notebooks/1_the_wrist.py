# %% [markdown]
# # 1 The wrist and its loop
#
# **The angle of a pneumatic wrist at a given pressure depends on its history. Which plant does a
# controller have to hold at 15 degrees, and how much of it is known?**
#
# The wrist is that of [doi 10.5772/50538](https://doi.org/10.5772/50538): an electro-pneumatic regulator
# turns a command voltage into the pressure of one of two antagonistic actuators, the pressure into an
# angle by a hysteresis loop of four straight segments, and a first-order lag models the joint. This
# notebook builds the model from its parts, redraws the paper's figures with it, and states for every
# number whether the paper *states* it, whether we *assume* it, or whether it was *fitted* to data.

# %%
# %matplotlib inline
from itertools import pairwise

import control
import numpy as np

import design
import plants
from design import PAPER_GAINS, STEP, Case, Task, paper_series, play, stack
from plants import RATES, STARTS, Memory, branch_slopes, built_in, wrist_x0
from reports import LINES, PAPER_FIGURES, draw_paper, new_figure, parameter_table, rows, shown, styled

flexion, deviation = plants.Wrist.flexion(), plants.Wrist.deviation()

# %% [markdown]
# ## What is known
#
# The equations and figures of the paper are not available. Its text gives a few numbers, the structure,
# and the task; the rest is assumed, each with a reason that `wrist show` prints.

# %%
sets = built_in("flexion")
print(f"{len(sets.assumed)} of {len(sets.parameters)} parameters are assumed, none is fitted yet")
shown(parameter_table(sets))

# %% [markdown]
# So no figure below is a measurement. Those that carry a number redraw the paper's figure of that number
# from the model alone: their shapes follow from the structure that the paper states, their scales mostly
# from assumptions. The parameters that each depends on:

# %%
assumed = {
    number: [n for n in figure.names if n in sets.assumed] + ["the PI's gains"] * figure.stand_in
    for number, figure in PAPER_FIGURES.items()
}
rows(
    {
        "figure": f"Fig. {number}",
        "title in the paper": PAPER_FIGURES[number].title,
        "rests on the assumed": ", ".join(names) or "nothing",
    }
    for number, names in assumed.items()
)

# %% [markdown]
# ## The regulator is accurate, but slow near the end
#
# In the steady state the regulator is linear (Fig. 5), with the gain stated by the paper. The full range
# of the command does not quite reach the highest pressure of the paper's experiments.

# %%
draw_paper(5, paper_series(5, flexion, deviation))

# %% [markdown]
# *What to see: nine held commands, nine pressures on one line.*
#
# Its transient is not a linear lag. The paper first tries one (Fig. 6), finds that the real regulator
# takes about ten seconds for the last few kilopascals, and replaces it by a proportional gain that varies
# with the error (Fig. 8). The law itself is lost. We take $\dot P = k(e)\,e$ with a rate $k$ that falls
# from `k_fast` to `k_slow` as the error comes below `e0`: the simplest law that is fast for large and
# slow for small errors.

# %%
draw_paper(6, paper_series(6, flexion, deviation))

# %%
draw_paper(8, paper_series(8, flexion, deviation))

# %% [markdown]
# *What to see: the same rise in both, but in Fig. 8 the last kilopascals take seconds.* In numbers:

# %%
volts = [3.0] * 20_000
for name, wrist in {"first-order lag": flexion.as_lag_regulator(), "variable P": flexion}.items():
    response = wrist.simulate(volts)
    missing = np.abs(3.0 * wrist.regulator.gain - response.pressure)
    within = [response.time[missing > kPa][-1] for kPa in (10.0, 1.0)]
    print(f"{name:16s} within 10 kPa after {within[0]:.2f} s, within 1 kPa after {within[1]:.2f} s")

# %% [markdown]
# This is the first difficulty for control: the rate measured on a large step is more than ten times the
# rate near the reference.

# %%
regulator = flexion.regulator
print(f"fast rate {regulator.k_fast} 1/s, slow rate {regulator.k_slow} 1/s")
assert regulator.k_fast / regulator.k_slow > 10

# %% [markdown]
# ## The hysteresis loop
#
# From rest (Fig. 10) the wrist does not move at first: there is a dead zone around 100 kPa. A staircase
# of pressures (Fig. 11) gives a loop (Fig. 12): *line 1* while it moves in the plus direction, *line 2*
# while it moves in the minus direction, and a *transit* of small slope from one to the other.

# %%
draw_paper(10, paper_series(10, flexion, deviation))

# %%
draw_paper(11, paper_series(11, flexion, deviation))

# %%
draw_paper(12, paper_series(12, flexion, deviation))

# %% [markdown]
# *What to see: Fig. 10, the shaded dead zone; Fig. 11, the input; Fig. 12, two angles at every pressure,
# one on the way up and one on the way down.* The transit slopes are stated by the paper, the lines are
# assumed such that the range of the command spans the range of motion that it states.
#
# The loop is more than its outer branches. A pressure that reverses halfway gives a minor loop inside:

# %%
turns = [100.0, 170.0, 40.0, 150.0, 60.0, 130.0, 80.0, 120.0, 100.0]
volts = np.interp(np.arange(160_000), np.linspace(0, 160_000, len(turns)), turns) / regulator.gain
path = flexion.simulate(volts, every=50)
with styled():
    figure, (plane, signal) = new_figure(1, 2, height=3.6, width_ratios=(3, 2))
    plane.plot(path.pressure, path.static_angle, **LINES[0])
    plane.axvline(100.0, color="#6b6b6b", linewidth=0.8)
    plane.set(xlabel="Pressure [kPa]", ylabel="Static angle [deg]", title="Major and minor loops")
    signal.plot(path.time, path.pressure, **LINES[0])
    signal.set(xlabel="Time [s]", ylabel="Pressure [kPa]", title="The pressure that drew them")
figure

# %% [markdown]
# *What to see: nested loops of decreasing size; on the vertical line at 100 kPa the angle differs at each
# pass.* How large is the difference, and does it depend on the rate?

# %%
loop = flexion.hysteresis
low, high = loop.ascending(100.0), loop.descending(100.0)
print(f"at 100 kPa the wrist may rest anywhere from {low:+.1f} to {high:+.1f} deg")

once = many = Memory(0.0, 1.0)
for before, after in pairwise(turns):
    once = loop.step(once, before, after)
    for a, b in pairwise(np.linspace(before, after, 1000)):
        many = loop.step(many, a, b)
print(f"the same path in 8 steps and in 8 x 999: {once.h:.6f} and {many.h:.6f} deg")
assert abs(once.h - many.h) < 1e-9

# %% [markdown]
# The loop is rate-independent: only the turning points matter. Its state is one number, the static angle,
# and whether it has ever met a line. This small state makes proofs possible (notebook 3).
#
# The second difficulty for control is the slope. Between the lines it is that of the transit, on them
# that of the lines:

# %%
for name, wrist in {"flexion": flexion, "deviation": deviation}.items():
    p = wrist.hysteresis
    print(
        f"{name}: {p.s} deg/kPa in transit (stated), {p.a1} on line 1 (assumed): a factor of {p.a1 / p.s:.1f}"
    )

# %% [markdown]
# The plant's gain changes by this factor whenever the motion reverses. No single linearisation is
# sufficient for tuning.
#
# ## A lag after the loop
#
# Regulator, loop and a first-order lag in series are the wrist drive system (section 5.2 of the paper).
# Fig. 13 is its response to the staircase.

# %%
draw_paper(13, paper_series(13, flexion, deviation))

# %% [markdown]
# *What to see: at 100 kPa, three times on the way, three different angles.*
#
# ## A step of 15 degrees
#
# The paper closes the loop with a PI whose gains are lost. Its text describes a response of seconds, so
# stand-in gains are *assumed*, with a range. No conclusion of these notebooks depends on a value within
# the range.

# %%
draw_paper(14, paper_series(14, flexion, deviation))

# %%
draw_paper(15, paper_series(15, flexion, deviation))

# %% [markdown]
# *What to see: a short delay while the dead zone is crossed, then a slow approach to the reference; the
# grey band is the range of the assumed gains.* The delay depends on the initial hysteresis state:

# %%
pi = design.PI(*PAPER_GAINS)
lanes = stack(Case(Task(start, 0.0, (STEP,)), flexion) for start in STARTS)
played = play(lanes, pi, record=True)
judged, signals = played.metrics, played.trajectory
print(f"Kp {pi.Kp} kPa/deg, Ki {pi.Ki} kPa/(deg s), a step of {STEP:g} deg")
with styled():
    figure, (axes,) = new_figure(height=3.2)
    for lane, start in enumerate(STARTS):
        settled = f"{start}: settled after {judged.settling_time_s[lane]:.2f} s"
        axes.plot(signals.time, signals.angle[:, lane], label=settled, **LINES[lane])
    axes.axhline(STEP, color="black", linewidth=0.8)
    axes.set(xlabel="Time [s]", ylabel="Angle [deg]", xlim=(0, 10), title="One controller, four memories")
    axes.legend()
figure

# %% [markdown]
# *What to see: the same wrist at the same angle with the same controller, but different responses, since
# one run starts on the line that is needed and another at the far side of the loop (two happen to have
# the same distance).* A tuning on one of them covers only a part of the plant.
#
# ## The same plant in python-control
#
# The model is available in python-control. The sampled wrist is a `control.nlsys`, and each branch of the
# loop has a linearisation, a `control.ss`. They agree with the simulator:

# %%
t = np.arange(3000) / 1000
command = 2.0 + 1.5 * np.sin(3.0 * t)
theirs = control.input_output_response(flexion.to_control(), t, command, wrist_x0(flexion))
ours = flexion.simulate(command[:-1])
differences = np.abs(theirs.outputs - [ours.pressure, ours.angle]).max(axis=1)
print(f"nlsys: largest differences {differences[0]:.0e} kPa and {differences[1]:.0e} deg over {t[-1]:.0f} s")
assert differences.max() < 1e-9

lag = flexion.as_lag_regulator()  # the one regulator that is linear
rest = lag.rest("line1", 5.0)
small = control.forced_response(lag.linearised("line1"), t, np.full(t.size, 0.1))
moved = lag.simulate(np.full(t.size - 1, rest.pressure / lag.regulator.gain + 0.1), rest)
difference = np.abs(small.outputs - (moved.angle - 5.0)).max()
print(
    f"linearised on line 1: largest difference {difference:.0e} deg of a step of {small.outputs[-1]:.2f} deg"
)
assert difference < 1e-9

# %%
branches = {
    (branch, rate): flexion.linearised(branch, rate) for branch in branch_slopes(flexion) for rate in RATES
}
rows(
    {
        "branch": branch,
        "regulator rate": rate,
        "gain [deg/V]": float(g.dcgain()),
        "slowest pole [1/s]": float(-np.log(g.poles().real.max()) / g.dt),
    }
    for (branch, rate), g in branches.items()
)

# %% [markdown]
# ## What follows, and what does not
#
# The plant of a PI that holds 15 degrees is not one transfer function but a family: the wrist moves
# through it as the error decreases and the motion reverses. Its gain changes by the ratio of the slopes,
# and its slowest pole from the slow rate of the regulator to that of the lag. This follows from the
# structure, which the paper states, and does not depend on the numbers. You cannot conclude how the real
# wrist behaves in degrees and seconds: the lines, the rates, the time constant and the paper's gains are
# assumed, no measured curve of this rig is available for comparison, and effects that the paper does not
# mention (dead time of a tube, creep, stiction) are absent here. Notebook 2 therefore tunes with margins
# and on many plants, and notebook 5 shows the steps with measured data.
