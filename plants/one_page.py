"""The whole wrist on one page: where a reader begins, and what the tests compare against.

Plain Python, one sample after the other, written apart from the modules that
compose the same wrist from its parts.  Symbols as in the paper where it has them:
v command [V], P pressure [kPa], h static angle [deg], y angle [deg].
"""

from math import exp


def wrist(p: dict[str, float], commands: list[float], dt: float = 0.001) -> list[tuple[float, float, float]]:
    """(P, h, y) of a wrist that starts at rest, before each command acts, and after the last.

    p: gain [kPa/V], k_fast, k_slow [1/s], e0 [kPa], a1, a2, s [deg/kPa], w1, w2 [deg],
    Tw [s], rest_pressure [kPa]; commands: one per sample time dt [s], held in between.
    """
    P, h, y, virgin = p["rest_pressure"], 0.0, 0.0, True
    out = [(P, h, y)]
    for v in commands:
        # Electro-pneumatic regulator, "variable P control" (section 3): dP/dt = k(e) e.
        e = p["gain"] * v - P
        w = e**2 / (e**2 + p["e0"] ** 2)
        slow, fast = p["k_slow"] * dt, p["k_fast"] * dt
        share = (1 - w) * (1 - exp(-slow)) + w * (1 - exp(-fast))  # of e, gone after dt
        share -= w * (1 - w) * (fast - slow) * ((1 - w) * slow + w * fast - (fast - slow) / 2)
        P_before, P = P, P + share * e

        # Hysteresis of four segments (section 5): transit, held between line 1 and line 2.
        x = P - p["rest_pressure"]
        h_before, h = h, h + (0.0 if virgin else p["s"]) * (P - P_before)
        low, high = p["a1"] * x - p["w1"], p["a2"] * x + p["w2"]
        if h < low:  # moving in the plus direction: dorsal flexion, ulnar deviation
            h, virgin = low, False
        if h > high:  # moving in the minus direction: palmar flexion, radial deviation
            h, virgin = high, False

        # Transient of the wrist, a first-order lag (section 5.2); h moves linearly in between.
        r = dt / p["Tw"]
        decay = exp(-r)
        y = decay * y + ((1 - decay) / r - decay) * h_before + (1 - (1 - decay) / r) * h
        out.append((P, h, y))
    return out
