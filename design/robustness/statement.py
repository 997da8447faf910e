"""One claim about a loop, and what became of it, as values; `reports.robustness.statements` says them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from design.status import Status

EVERY_BRANCH = "every branch"
"""The branch of a statement that is about all of them, in any order."""


class Claim:
    """What is claimed: equal for the same claim about several branches."""


class Reason:
    """Why a claim holds or does not, or how the figure was checked."""


@dataclass(frozen=True)
class Statement:
    """A claim, and what became of it.

    status: by proof (`design.status.BY_PROOF`), predicted or sampled; holds: None where it is not known, and
    of predictions that are told without being judged; value [unit]: the figure that it rests on, None where
    there is none; branch: of the hysteresis, such as ``line1, slow regulator rate``; evidence: further
    figures, for JSON.
    """

    status: Status
    claim: Claim
    holds: bool | None
    value: float | None
    reason: Reason
    unit: str = ""
    branch: str = EVERY_BRANCH
    evidence: Mapping[str, Any] = field(default_factory=dict)
