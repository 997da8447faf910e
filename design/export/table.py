"""Targets by controllers by largest difference: python -m design.export.table writes docs/targets.md.

Every target is run over the same samples, with noise, spikes, lost samples, references out of reach: C by the
compiler of this machine, units by FMPy.  Structured text is run by the tests, since no tool here does.
"""

import argparse
import re
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from design.export.catalogue import CATALOGUE, part
from design.export.fmu import unit
from design.export.folder import contents
from design.export.part import Part
from design.export.targets import VERSIONS
from design.export.vectors import vector
from plants.wrist import Wrist

UNIT_STEPS = 2_000
"""Samples that a unit is run over: each is some calls through FMPy."""

PAGE = """# Targets, controllers, and how far each is from Python

Made by `python -m design.export.table`. Largest difference of the output from what Python computes, over
10,000 samples (units of FMI: {steps}) with noise, spikes, lost samples and references out of reach.

{table}

Structured text (`--target st`: all but the MPCs) is translated to Python statement by statement and run over
the vector by `tests/control/test_export_st.py`, to 1e-9: no free tool that runs it was at hand. An MPC solves
a programme and is no function block. The nonlinear MPC by real-time iteration is not exported.
"""


def difference_in_c(made: Part, wrist: Wrist) -> float:
    """Largest difference of the compiled C from Python over the test vector, in the unit of the output.

    Raises RuntimeError, with what the compiler said, where it does not compile.
    """
    with tempfile.TemporaryDirectory() as place:
        for name, text in contents(made, wrist).items():
            (Path(place) / name).write_text(text, encoding="utf-8")
        said = subprocess.run(["make", "check"], cwd=place, capture_output=True, text=True, check=False)
    found = re.search(r"largest difference (\S+)", said.stdout)
    if found is None:
        raise RuntimeError(said.stdout + said.stderr)
    return float(found[1])


def difference_in_unit(made: Part, wrist: Wrist, fmi: Any) -> float:
    """Largest difference of a functional mock-up unit from Python over the begin of the test vector."""
    import fmpy

    found = vector(made, wrist, UNIT_STEPS)
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / f"{made.name}.fmu"
        path.write_bytes(unit(made, contents(made, wrist, UNIT_STEPS), fmi))
        described = fmpy.read_model_description(str(path))
        loaded = fmpy.instantiate_fmu(fmpy.extract(str(path), f"{place}/unit"), described, "CoSimulation")
        at = {v.name: v.valueReference for v in described.modelVariables}
        put, get = (getattr(loaded, f"{w}{'Real' if fmi == '2.0' else 'Float64'}") for w in ("set", "get"))
        put([at["start_pressure_kPa"], at["start_angle_deg"]], [found.pressure, found.angle])
        loaded.enterInitializationMode()
        loaded.exitInitializationMode()
        worst = 0.0
        for k, row in enumerate(found.rows):
            put([at[f.member] for _, f in made.read], [float(row[i]) for i, _ in made.read])
            loaded.doStep(k * made.period, made.period)
            worst = max(worst, abs(get([at[made.output.member]])[0] - float(row[3])))
        loaded.terminate()
        loaded.freeInstance()
    return worst


def rows(wrist: Wrist) -> list[list[str]]:
    """A row for each controller: name, unit, C in double, in single precision, units of FMI 2.0 and 3.0."""
    made = []
    for kind, entry in CATALOGUE.items():
        gains = entry.default if entry.default is not None else tuple(map(float, entry.example.split(",")))
        one = part(kind, "flexion", wrist, gains)
        found = [difference_in_c(one, wrist), difference_in_c(one.at("single"), wrist)]
        found += [difference_in_unit(one, wrist, fmi) for fmi in VERSIONS]
        made.append([kind, one.output.unit, *(f"{x:.1g}" for x in found)])
        print(*made[-1], flush=True)
    return made


def page(wrist: Wrist) -> str:
    """The page of the table."""
    head = ["controller", "unit", "C, double", "C, single", "FMI 2.0", "FMI 3.0"]
    lines = [head, ["---"] * len(head), *rows(wrist)]
    table = "\n".join("| " + " | ".join(line) + " |" for line in lines)
    return PAGE.format(steps=f"{UNIT_STEPS:,}", table=table)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m design.export.table", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/targets.md"), help="the page")
    parser.parse_args().out.write_text(page(Wrist.flexion()), encoding="utf-8")


if __name__ == "__main__":
    main()
