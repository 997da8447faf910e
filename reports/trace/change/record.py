"""Two campaigns of one rig for machines: what ``wrist trace OLD NEW --json`` writes."""

from typing import Any

from design.studies.check.campaigns import CONFIDENCE, CampaignChange
from plants.measured.instrument.remark import habits
from reports.trace.change.words import title
from reports.trace.record import effect_record


def change_record(change: CampaignChange) -> dict[str, Any]:
    """What changed as dictionaries, lists, numbers and text, for JSON.

    ``parameters``: those that both campaigns determine, ``interval`` that of the difference, all of them
    together at ``confidence``, ``chi_square_rise`` what the old value would cost a row; ``effects``: names
    that came, with their parameters, went and stayed; ``recordings``: rms of what the old plant leaves of the
    new campaign, and up to what it counts as before.
    """
    return {
        "axis": change.campaign.axis,
        "old": change.old.campaign.name,
        "new": change.campaign.name,
        "verdict": change.verdict,
        "words": title(change),
        "confidence": CONFIDENCE,
        "parameters": [
            {
                "name": p.name, "stage": p.stage, "unit": p.unit, "old": p.old, "new": p.new,
                "difference": p.difference, "interval": [p.low, p.high], "chi_square_rise": p.rise,
                "differs": p.differs,
            }
            for p in change.parameters
        ],
        "undetermined": list(change.undetermined),
        "effects": {
            "came": [effect_record(e) for e in change.came], "went": list(change.went),
            "stayed": list(change.kept),
        },
        "unexplained": list(change.unexplained),
        "recordings": [
            {
                "name": r.recording.name,
                "channels": [
                    {
                        "channel": c.channel, "rms": c.rms, "before": c.before, "allowed": c.allowed,
                        "new": c.new,
                    }
                    for c in r.channels
                ],
            }
            for r in change.residuals
        ],
        "instrument": habits(change.instrument),
    }  # fmt: skip
