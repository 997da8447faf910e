"""Many wrists at once in plain NumPy, the equations of the paper written out once more: for random
commands, and for searches over switching times.

The one thing taken over is the form of the regulator's step, which `tests/laws/test_regulator.py` holds
against the closed form of its law.
"""

import numpy as np

DT = 0.001


def lanes(values, start, commands):
    """Angles [deg] (samples + 1, lanes) under commands [V] (samples, lanes), and the last static angles.

    `start`: pressure, static angle, whether virgin, angle.  A command that is nan holds the pressure.
    """
    p = values
    n = commands.shape[1]
    P, h, virgin, y = (np.full(n, float(x)) for x in start)
    slow, fast = p["k_slow"] * DT, p["k_fast"] * DT
    decay = np.exp(-DT / p["Tw"])
    out = [y]
    for v in commands:
        e = np.where(np.isnan(v), 0.0, p["gain"] * v - P)
        w = e * e / (e * e + p["e0"] ** 2)
        share = (1 - w) * (1 - np.exp(-slow)) + w * (1 - np.exp(-fast))
        share -= w * (1 - w) * (fast - slow) * (slow + w * (fast - slow) - (fast - slow) / 2)
        before, P = P, P + share * e
        x, held = P - p["rest_pressure"], h
        h = h + np.where(virgin > 0.5, 0.0, p["s"]) * (P - before)
        low, high = p["a1"] * x - p["w1"], p["a2"] * x + p["w2"]
        virgin = np.where((h < low) | (h > high), 0.0, virgin)
        h = np.where(h < low, low, h)
        h = np.where(h > high, high, h)
        # y' = (h - y) / Tw with h on a straight line over the sample.
        rate = (h - held) / DT
        y = h - rate * p["Tw"] + (y - held + rate * p["Tw"]) * decay
        out.append(y)
    return np.array(out), h


def settled_at(angles, reference, start, last=None):
    """First sample [s] from which on all angles are inside 2 % of the step, by looking back from the end;
    `last`: the static angle that the joint still tends to, which must be inside as well."""
    band = 0.02 * abs(reference - start)
    outside = np.abs(angles - reference) >= band
    samples = len(angles)
    first = np.where(outside.any(axis=0), samples - np.argmax(outside[::-1], axis=0), 0)
    done = first < samples
    if last is not None:
        done &= np.abs(last - reference) < band
    return np.where(done, first * DT, np.inf)


def iae(angles, reference):
    """Integral of the absolute error [deg s], by the rectangle that begins at each sample."""
    return np.abs(reference - angles).sum(axis=0) * DT


def of_state(state):
    """What `lanes` needs of a wrist's state."""
    return state.pressure, state.memory.h, state.memory.virgin, state.angle


def random_switching(rng, samples, n, low=0.0, high=4.0):
    """Commands (samples, n): full throttle either way or something in between, held for random times, and
    from a random sample on (half of the lanes) the pressure is held."""
    out = np.empty((samples, n))
    for lane in range(n):
        k = 0
        while k < samples:
            for_so_long = int(rng.integers(1, 120))
            out[k : k + for_so_long, lane] = rng.choice([low, high, high, rng.uniform(low, high)])
            k += for_so_long
        if rng.random() < 0.5:
            out[int(rng.integers(1, samples)) :, lane] = np.nan
    return out
