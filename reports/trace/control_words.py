"""What retuning on the revised plant changes, in sentences."""

from collections.abc import Sequence
from math import isfinite

from design.synthesis.answer import UNITS as GAIN_UNITS
from design.synthesis.retune import Control, RetunedSide
from reports.shared.names import limit_name
from reports.shared.tables import listed, number
from reports.shared.tuning import refused


def limits_words(names: Sequence[str]) -> str:
    """Limits that were broken, in words."""
    return listed([limit_name(n).lower() if n != "Ms" else n for n in names]) or "none"


NO_LOOP = "no: the campaign has no angle, so there is no loop to tune"


def control_sentence(control: Control | None) -> str:
    """What retuning changes, in one or two sentences; control: None of a campaign without an angle."""
    if control is None:
        return f"Retuning: {NO_LOOP}."
    old, new = control.declared, control.revised
    if control.same:
        if not old.tuning:
            return f"Nothing was revised, and no PI was found for the declared wrist; {_refused(old)}."
        return f"Nothing was revised, so the PI tuned on the declared wrist remains: {gains(old)}."
    if old.judged is None or new.judged is None:
        whose = "revised" if new.judged is None else "declared"
        side = new if new.judged is None else old
        return f"The {whose} plant cannot be tuned for this step; {_refused(side)}."
    said = (
        f"On {control.judge}, the PI tuned on the declared wrist ({gains(old)}) {_did(old)}; "
        f"tuned on the revised one ({gains(new)}) it {_did(new)}."
    )
    if new.refusal:
        said += f" No gains meet every limit on the revised plant; these are the nearest ({_refused(new)})."
    if control.left_out:
        said += (
            f" Both were tuned without {listed(list(control.left_out))}: an effect of the sensor or an event "
            "of the recordings."
        )
    return said


def _refused(side: RetunedSide) -> str:
    return "" if side.refusal is None else refused(side.refusal)


def gains(side: RetunedSide) -> str:
    """Gains with their units."""
    assert side.tuning is not None
    return f"Kp {number(side.tuning.Kp)} {GAIN_UNITS['Kp']}, Ki {number(side.tuning.Ki)} {GAIN_UNITS['Ki']}"


def _did(side: RetunedSide) -> str:
    j = side.judged
    assert j is not None
    settles = "does not settle" if not isfinite(j.settling_time_s) else ""
    settles = "oscillates" if j.oscillates else settles or f"settles in {number(j.settling_time_s)} s"
    there = [n for n in side.broken if n not in j.broken]
    broken = [f"breaks the limit on {limits_words(j.broken)}"] if j.broken else []
    if there:
        broken.append(
            f"breaks the limit on {limits_words(there)} from another initial state or on a corner of the "
            "plant"
        )
    return f"{settles} with an IAE of {number(j.iae_deg_s)} deg s and {listed(broken) or 'meets every limit'}"
