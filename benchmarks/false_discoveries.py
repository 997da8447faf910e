"""``python -m benchmarks.false_discoveries``: traces of rigs on which nothing is missing.

Each campaign is made by the independent rig of the tests with other parameters
and another noise (half to twice the usual, white or with a memory of up to
0.2 s, on either motion).  A discovery is any verdict but ``nothing-missing``,
or any effect.  Writes `benchmarks/false_discoveries.json`, which is committed.
"""

import argparse
import json
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import beta

from plants.files import json_text, write_atomically
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.trace.trace import trace_campaign
from plants.parameters.files import built_in
from tests.rig.campaign import make_campaign
from tests.rig.rig import Noise

RESULT = Path(__file__).parent / "false_discoveries.json"
CAMPAIGNS = 200
MEMORIES = (0.0, 0.0, 0.05, 0.2)
"""Correlation times of the noise [s] that are drawn; half of the rigs have white noise."""


def null_campaign(folder: Path, seed: int) -> Path:
    """A campaign of about 60 s of a rig that is as declared, in a folder of its own."""
    rng = np.random.default_rng([seed, 77])
    loud = float(np.exp(rng.uniform(np.log(0.5), np.log(2.0))))
    noise = Noise(0.065 * loud, 0.27 * float(np.exp(rng.uniform(-0.5, 0.5))), float(rng.choice(MEMORIES)))
    place = folder / f"null{seed}"
    axis = ("flexion", "deviation")[int(rng.integers(2))]
    make_campaign(place, axis, [], seed=seed, noise=noise, short=True)
    return place


def trial(seed: int) -> dict[str, Any]:
    """The trace of one null campaign, in short."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        campaign = load_campaign(null_campaign(Path(folder), seed))
        found = trace_campaign(campaign, built_in(campaign.axis), seed=seed)
    return {
        "seed": seed,
        "verdict": found.verdict,
        "effects": [e.name for e in found.effects],
        "depends_on": [list(s.after.depends_on) for s in found.unexplained],
    }


def upper_limit(discoveries: int, campaigns: int, confidence: float = 0.95) -> float:
    """One-sided Clopper-Pearson limit of a rate; Biometrika 26 (1934) 404, doi 10.1093/biomet/26.4.404.

    >>> round(upper_limit(0, 200), 4)
    0.0149
    """
    return float(beta.ppf(confidence, discoveries + 1, campaigns - discoveries))


def main() -> None:
    """Run, print and keep the figure."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--campaigns", type=int, default=CAMPAIGNS)
    options.add_argument("--first", type=int, default=1001, help="first seed")
    chosen = options.parse_args()
    false: list[dict[str, Any]] = []
    for seed in range(chosen.first, chosen.first + chosen.campaigns):
        found = trial(seed)
        if found["verdict"] != "nothing-missing" or found["effects"]:
            false.append(found)
            print(json.dumps(found), flush=True)
    result = {
        "campaigns": chosen.campaigns,
        "first_seed": chosen.first,
        "false_discoveries": len(false),
        "rate_upper_limit_95": upper_limit(len(false), chosen.campaigns),
        "which": false,
    }
    print(json.dumps({k: v for k, v in result.items() if k != "which"}))
    if chosen.campaigns >= CAMPAIGNS:
        write_atomically(RESULT, json_text(result))


if __name__ == "__main__":
    main()
