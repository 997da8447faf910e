"""What a contest says in sentences."""

from design.contest.plants import RIGS
from design.contest.scores import BOTH, Contest, Score
from design.contest.statistics import FEWEST
from reports.comparison.contest.table import is_main
from reports.shared.names import name_of


def sentences(found: Contest) -> list[str]:
    """One sentence for each motion on the perturbed plants, one on the rigs: which controllers have
    a smaller error than the reference controller, no significant difference, or a larger one."""
    said = []
    for motion, field, family in found.tables:
        told = found.of(motion, field, family)[0].plants >= FEWEST
        if told and is_main((motion, field, family)):
            said.append(
                f"{motion}, {field}, steps: {against(found.of(motion, field, family), found.reference)}."
            )
    return said + rig_sentences(found)


def against(scores: list[Score], reference: str, metric: str = "iae_deg_s") -> str:
    """How the controllers of a table compare with the reference controller, by the intervals of the
    differences, the least first, a large group by its size; the number of plants at the end."""
    groups: dict[int, list[str]] = {-1: [], 0: [], 1: []}
    for s in sorted(scores, key=lambda s: s.mean[metric]):
        if s.controller != reference:
            groups[s.against[metric].sign].append(name_of(s.controller))
    words = {-1: "less IAE than the recommended PI", 0: "no significant difference", 1: "more IAE"}
    most = max(groups.values(), key=len)
    if len(most) > 3:  # the few by name, the others by their number
        groups = dict(sorted(groups.items(), key=lambda g: g[1] is most))
    parts = [
        f"{words[sign]}: {f'the other {len(most)}' if names is most and len(most) > 3 else ', '.join(names)}"
        for sign, names in groups.items()
        if names
    ]
    return f"{'; '.join(parts)} ({scores[0].plants} plants)"


def rig_sentences(found: Contest) -> list[str]:
    """For each motion, which controllers lose their lead over the reference controller in IAE on which rigs,
    of rigs with enough plants."""
    said = []
    for motion in dict.fromkeys(m for m, _, _ in found.tables if m != BOTH):
        ahead = {s.controller for s in found.of(motion, "perturbed plants", "steps")
                 if s.against["iae_deg_s"].sign < 0}  # fmt: skip
        lost: dict[tuple[str, ...], list[str]] = {}
        for name in RIGS:
            scores = [s for s in found.of(motion, name, "steps") if s.plants >= FEWEST]
            losers = tuple(s.controller for s in scores
                           if s.controller in ahead and s.against["iae_deg_s"].sign >= 0)  # fmt: skip
            if losers:
                lost.setdefault(losers, []).append(name)
        for losers, names in lost.items():
            who = ", ".join(name_of(n) for n in losers)
            said.append(
                f"{motion}, {' and '.join(names)}: no longer less IAE than the recommended PI: {who}."
            )
    return said
