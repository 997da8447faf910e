"""What is known of a claim: one set of words for certificates, predictions, samples and parameters."""

from enum import StrEnum


class Status(StrEnum):
    """What is known of a claim, and how."""

    PROVED = "proved"
    DISPROVED = "disproved"
    OPEN = "open"
    PREDICTED = "predicted"
    SAMPLED = "sampled"
    ASSUMED = "assumed"


BY_PROOF = (Status.PROVED, Status.DISPROVED, Status.OPEN)
"""What may become of a claim that is to be proved; open: neither a proof nor a counterexample was found."""


def of_proof(holds: bool | None) -> Status:
    """The status of a claim that is proved to hold or not to hold, or neither (None).

    >>> [of_proof(h).value for h in (True, False, None)]
    ['proved', 'disproved', 'open']
    """
    return Status.OPEN if holds is None else Status.PROVED if holds else Status.DISPROVED
