"""Write measured-like campaigns: python -m tests.rig --out DIR --axis flexion --effects creep,gyro-drift."""

import argparse
import json
from pathlib import Path

from tests.rig.campaign import make_campaign, record
from tests.rig.effects import OPEN, VOCABULARY
from tests.rig.physics import PhysicsRig, make_physics_rig
from tests.rig.rig import Rig
from tests.rig.suite import write_suite


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.rig", description=__doc__)
    parser.add_argument("--out", type=Path, help="folder of one campaign")
    parser.add_argument("--axis", choices=("flexion", "deviation"), default="flexion")
    parser.add_argument("--effects", default="", help=f"comma-separated, of: {', '.join(VOCABULARY)}")
    parser.add_argument("--open", default="", help=f"comma-separated, of: {', '.join(OPEN)}")
    parser.add_argument("--variants", default="", help="such as creep=2,gyro-drift=1; else drawn")
    parser.add_argument("--physics", action="store_true", help="a wrist from first principles instead")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--scale", type=float, default=1.0, help="of the effects' strength")
    parser.add_argument("--short", action="store_true", help="recordings of about 20 s")
    parser.add_argument("--correlation", type=float, default=0.0, help="correlation time of the noise [s]")
    parser.add_argument("--truth", type=Path, help="file for what the rig hides")
    parser.add_argument("--suite", type=Path, help="folder of a whole judging suite")
    parser.add_argument("--suite-seed", type=int, default=1)
    given = parser.parse_args()
    if given.suite is not None:
        print(f"{len(write_suite(given.suite, given.suite_seed))} campaigns in {given.suite}")
        return
    if given.out is None:
        parser.error("--out or --suite is needed")
    if given.physics:
        physics = make_physics_rig(given.axis, given.seed)
        record(physics, given.out, short=given.short)
        tell(physics, given.truth, given.out)
        return
    names = [name for name in f"{given.effects},{given.open}".split(",") if name]
    for name in names:
        if name not in VOCABULARY + OPEN:
            parser.error(f"no effect is called {name}")
    variants = {
        name: int(form) for name, form in (item.split("=") for item in given.variants.split(",") if item)
    }
    rig = make_campaign(
        given.out,
        given.axis,
        names,
        given.seed,
        variants,
        scale=given.scale,
        short=given.short,
        correlation_s=given.correlation,
    )
    tell(rig, given.truth, given.out)


def tell(rig: Rig | PhysicsRig, truth: Path | None, folder: Path) -> None:
    """Say what was written, and keep the truth where it was asked for."""
    if truth is not None:
        truth.write_text(json.dumps(rig.truth, indent=1) + "\n")
    print(f"{folder}: {rig.axis}, {', '.join(rig.effects) or 'nothing hidden'}")


if __name__ == "__main__":
    main()
