"""One meaning a term: what pages show as a tooltip, and the marks and status words that all outputs share."""

import re
from collections.abc import Mapping

BROKEN, MET, NOT_JUDGED = "▲", "✓", "–"
"""Marks of a limit that is broken, of one that is met, and of one that is not judged there."""

GLOSSARY: Mapping[str, str] = {
    "proved": "shown for every case of a stated class, and checked outside the solver that found it",
    "disproved": "a counterexample is known for the stated class",
    "open": "neither proved nor disproved",
    "predicted": "by linear theory or describing functions, one branch at a time",
    "sampled": "observed in simulated runs; nothing is proved of other runs",
    "assumed": "neither stated by the paper nor measured; the reason is given",
    "overshoot": "largest angle beyond the reference, in per cent of the step",
    "settling time": "time after which the angle stays within ±2 % of the step",
    "delay margin": "dead time that can be added before the linear loop becomes unstable",
    "sensitivity peak": "Ms, the largest |S| over frequency",
    "Ms": "peak of the sensitivity |S| over frequency; 1/Ms is the distance of the Nyquist curve from −1",
    "Mt": "peak of the complementary sensitivity |T| over frequency",
    "|W T|": "complementary sensitivity times the weight of unmodelled dynamics; below 1 at every frequency "
    "these cannot make the loop unstable",
    "total variation": "sum of all movements of the command u, up and down",
    "IAE": "integral of the absolute error over time",
    "virgin curve": "initial curve: path of the hysteresis at the first motion from rest, before it meets "
    "an outer branch",
    "initial hysteresis state": "where in the hysteresis loop a run starts: on the virgin curve, on line 1 "
    "or 2, or inside",
    "held-out": "recordings that were used neither to fit nor to select",
    "open-loop simulation": "simulated from the recorded command alone; no measurement corrects it",
    "residual": "measured minus simulated",
    "RMSE": "root of the mean squared error",
    "adversarial worst case": "the worst scenario that a search over all stated uncertainties found",
    "exponentially stable": "the error is bounded by a constant times exp(−rate × time)",
    "destabilising switching sequence": "a sequence of branches and rates under which the state of the "
    "switched loop grows",
    "box": "interval of every uncertain parameter, all combinations allowed",
    "line 1": "outer branch of the hysteresis on which the angle rises",
    "line 2": "outer branch of the hysteresis on which the angle falls",
    "dead time": "time between the command and the first movement of the pressure",
    "describing function": "gain of the hysteresis for a sinusoid of one amplitude",
    "mixed mu": "1/mu is the smallest growth of the box that makes a linear loop unstable",
}
"""Definitions by term, in few words."""

_WHOLE = "script|style|svg|h1|h2|title|abbr|code|summary"
_PARTS = re.compile(rf"<({_WHOLE})\b.*?</\1>|<[^>]*>|[^<]+", re.DOTALL)
"""Elements that stay as they are, whatever is within; other tags; and text."""


def with_tooltips(page: str) -> str:
    """A page in which the first use of each term in its text carries the term's definition.

    >>> with_tooltips("<p>The overshoot is 2 %.</p>")[:53]
    '<p>The <abbr title="largest angle beyond the referenc'
    >>> figure = "<svg><style>x</style><text>overshoot</text></svg>"
    >>> with_tooltips(figure) == figure
    True
    """
    head, body, rest = page.partition("<main>")
    if not body:
        head, rest = "", page
    waiting = dict(sorted(GLOSSARY.items(), key=lambda item: -len(item[0])))
    parts = [m.group(0) for m in _PARTS.finditer(rest)]
    for place, part in enumerate(parts):
        if part.startswith("<") or not part.strip():
            continue
        for term, meaning in list(waiting.items()):
            flags = 0 if term in ("Ms", "Mt", "IAE", "RMSE") else re.IGNORECASE
            found = re.search(rf"(?<![\w>-]){re.escape(term)}(?![\w-])(?! loop)", part, flags)
            if found and "<abbr" not in part:
                before, after = part[: found.start()], part[found.end() :]
                part = f'{before}<abbr title="{meaning}">{found.group(0)}</abbr>{after}'
                del waiting[term]
        parts[place] = part
    return head + body + "".join(parts)
