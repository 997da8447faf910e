"""How often `wrist trace OLD NEW` is right: rigs that did not change, and changes of several sizes.

python -m tests.change --count 20
python -m tests.change --what tube --sizes 0.002,0.005,0.01 --count 4 --name
"""

import argparse
import tempfile
import warnings
from pathlib import Path

from design.studies.check.campaigns import campaign_change, left_of
from plants.measured.campaigns.campaign import Campaign, load_campaign
from plants.measured.trace.change.refit import seen_alike
from plants.measured.trace.result import Trace
from reports.trace.change.words import title
from tests.change.pairs import drawn, worn, write
from tests.trace.traces import trace_folder


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=1, help="number of the rig to begin with")
    parser.add_argument("--plain", action="store_true", help="only rigs without an effect")
    parser.add_argument("--what", choices=("nothing", "slope", "leak", "tube"), default="nothing")
    parser.add_argument("--sizes", default="0")
    parser.add_argument("--name", action="store_true", help="also what changed, which takes longer")
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    sizes = [float(s) for s in asked.sizes.split(",")]
    seen, rigs = dict.fromkeys(sizes, 0), 0
    for number, (case, rig) in enumerate(drawn(asked.seed, asked.count, asked.plain), start=1):
        if number < asked.first:
            continue
        rigs += 1
        with tempfile.TemporaryDirectory() as root:
            old = trace_folder(write(rig, Path(root) / "old"))
            for size in sizes:
                new = load_campaign(
                    write(worn(rig, asked.what, size), Path(root) / f"new-{size:g}", later=True)
                )
                left = left_of(old, seen_alike(old, new)[0])
                worst = max(c.rms / c.allowed for r in left for c in r.channels)
                seen[size] += worst > 1.0
                named = _named(old, new) if asked.name else ""
                print(
                    f"{number:2d} {case.axis} {', '.join(case.effects) or 'nothing'}, {old.verdict}; "
                    f"{asked.what} {size:g}: {worst:.2f} of what is allowed{named}",
                    flush=True,
                )  # fmt: skip
    for size, times in seen.items():
        print(f"{asked.what} {size:g}: changed in {times} of {rigs}")


def _named(old: Trace, new: Campaign) -> str:
    found = campaign_change(old, new)
    certain = sum(p.certain for p in found.parameters)
    return f"; {title(found)}; {certain} of {len(found.parameters)} intervals exclude zero"


if __name__ == "__main__":
    main()
