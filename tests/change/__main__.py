"""How often `wrist trace OLD NEW` is right: rigs that did not change, and changes of several sizes.

python -m tests.change --count 20 --seed 0
python -m tests.change --what tube --sizes 0.001,0.003,0.01 --count 4
"""

import argparse
import tempfile
import warnings
from pathlib import Path

from design.studies.check.campaigns import campaign_change
from plants.measured.campaign import load_campaign
from reports.trace.change.words import title
from tests.change.pairs import drawn, worn, write
from tests.trace.traces import trace_folder


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--what", choices=("nothing", "slope", "leak", "tube"), default="nothing")
    parser.add_argument("--sizes", default="0")
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    sizes = [float(s) for s in asked.sizes.split(",")]
    certain = count = 0
    seen = dict.fromkeys(sizes, 0)
    for number, (case, rig) in enumerate(drawn(asked.seed, asked.count), start=1):
        with tempfile.TemporaryDirectory() as root:
            old = trace_folder(write(rig, Path(root) / "old"))
            for size in sizes:
                new = write(worn(rig, asked.what, size), Path(root) / f"new-{size:g}", later=True)
                found = campaign_change(old, load_campaign(new))
                seen[size] += found.changed
                certain += sum(p.certain for p in found.parameters)
                count += len(found.parameters)
                worst = max(c.rms / c.allowed for r in found.residuals for c in r.channels)
                print(
                    f"{number:2d} {case.axis} {', '.join(case.effects) or 'nothing'}, {old.verdict}; "
                    f"{asked.what} {size:g}: {worst:.2f} of what is allowed; {title(found)}",
                    flush=True,
                )  # fmt: skip
    for size, times in seen.items():
        print(f"{asked.what} {size:g}: changed in {times} of {asked.count}")
    print(f"{certain} of {count} joint intervals exclude zero")


if __name__ == "__main__":
    main()
