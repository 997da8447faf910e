"""What the other controllers of a design would change under the same requirement, in sentences."""

from collections.abc import Mapping
from math import isfinite
from typing import Any

from design.alternatives.designs import LQI_NAME, ROBUST_MPC, excess_of
from design.studies.design_study import DesignStudy, MotionDesign
from design.studies.designs import CASCADE, FORWARD
from reports.shared.names import limit_in_text
from reports.shared.tables import number


def alternatives(study: DesignStudy) -> list[str]:
    """What other controllers would change under the same requirement, a motion after the other."""
    said = [
        words(m) for m in study.motions for words in (feedforward_words, cascade_words, lqi_words, mpc_words)
    ]
    return [s[0].upper() + s[1:] for s in said if s]


def feedforward_words(m: MotionDesign) -> str:
    """What a feedforward around a PI's loop would change, and in which case it breaks a limit; nothing where
    none was found that holds the cases of its tuning."""
    found = m.designs.get(FORWARD)
    if found is None or not (found["holds"] or "worst_case" in found):
        return ""
    gains, share = found["gains"], _saved(m, FORWARD)
    error = "" if share is None else f"lowers the worst IAE of the tuning by {number(100 * share, 2)} %. It "
    words = (
        f"{m.motion}: an inverse feedforward (filter {number(gains['speed'])} 1/s, model delayed by "
        f"{number(1000 * gains['dead_time'])} ms) around the loop Kp = {number(gains['Kp'])}, Ki = "
        f"{number(gains['Ki'])} {error}needs the model and the measured pressure "
        "on the target, and no certificate covers it."
    )
    if found["holds"]:
        return f"{words} No broken limit was found."
    excess = _percent(found)
    limit = limit_in_text(found["worst_excess_of"])
    return (
        f"{words} It is not recommended: the search found a case that breaks the limit on {limit} "
        f"by {excess} % ({found['worst_case']})."
    )


def lqi_words(m: MotionDesign) -> str:
    """What an LQI would change under the same requirement, and which limit it breaks; nothing where there is
    none."""
    return _pressure_words(m, LQI_NAME, "a robust LQI")


def cascade_words(m: MotionDesign) -> str:
    """As `lqi_words`, of a cascade with the measured pressure inside."""
    return _pressure_words(m, CASCADE, "a cascade, a PI around a proportional loop on the pressure")


def _percent(found: Mapping[str, Any]) -> str:
    """By how many per cent a design breaks a limit."""
    return number(100 * (excess_of(found) or 0.0), 2)


def _saved(m: MotionDesign, name: str) -> float | None:
    """Share by which the worst IAE of a controller's tuning lies below that of the recommended one, or in the
    steps of the table where gains that break a limit of the linear loop were not simulated in their tuning;
    None where neither is known."""
    mine, best = m.designs[name]["cost"], m.designs[m.recommended]["cost"]
    if mine is None or not isfinite(mine):
        shown = {r["controller"]: r["worst_iae_deg_s"] for r in m.prices if r["guarantee"] != "proved"}
        mine, best = shown.get(name), shown.get(m.recommended)
    known = all(c is not None and isfinite(c) for c in (mine, best))
    return 1 - mine / best if known else None


def _pressure_words(m: MotionDesign, name: str, what: str) -> str:
    found = m.designs.get(name)
    if found is None:
        return ""
    values = ", ".join(f"{n} = {number(v)}" for n, v in found["gains"].items())
    share = _saved(m, name)
    error = (
        f"s worst IAE is {number(100 * abs(share), 2)} % {'lower' if share > 0.0 else 'higher'}"
        if share is not None
        else "s worst IAE is not known"
    )
    words = f"{m.motion}: {what} ({values}) needs the measured pressure, and no certificate covers it."
    if found["holds"]:
        return f"{words} It{error}; no broken limit was found."
    limit = f"the limit on {limit_in_text(found['worst_excess_of'])}"
    if (excess_of(found) or 0.0) > 0.0:
        beyond = f"It breaks {limit} by {_percent(found)} % in a case that was found"
    else:
        beyond = f"No gains of it were found that stay below {limit} by the margin of the tuning"
    return f"{words} {beyond}; it{error}."


def mpc_words(m: MotionDesign) -> str:
    """What an MPC would change under the same requirement; nothing where none was tuned."""
    found = m.designs.get(ROBUST_MPC)
    if found is None:
        return ""
    share = _saved(m, ROBUST_MPC)
    swing, move, delay = (number(found["gains"][n]) for n in ("swing", "move", "delay"))
    at_rest = found["margins"]
    words = (
        f"{m.motion}: a {ROBUST_MPC} (weights {swing} on the change of the error, {move} on that of the "
        f"command, {delay} periods of dead time in its model) needs a model and the measured pressure, and "
        "solves a quadratic program every period. No "
        "certificate covers it. Its linear loop at rest has Ms = "
        f"{number(at_rest['Ms'])} at most, and a delay margin of at least "
        f"{number(1000 * at_rest['delay_margin_s'], 2)} ms."
    )
    if share is not None:
        words += f" The worst IAE of its tuning is {number(100 * share, 2)} % lower."
    if found["holds"]:
        return (
            f"{words} No broken limit was found in about {found['search_runs']} runs of a search and in "
            f"{found['samples']} fresh samples."
        )
    excess = _percent(found)
    return f"{words} It breaks the limit on {limit_in_text(found['worst_excess_of'])} by {excess} %."
