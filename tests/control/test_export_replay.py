"""The C of a controller does in 10,000 steps what Python does, to 1e-9 (an MPC to 1e-6)."""

import csv
import re

import numpy as np
import pytest

from design.export.formats.folder import contents
from tests.control.c_target import (
    CC,
    GAINS,
    MADE,
    STEPS,
    WRIST,
    compiled,
    exported,
    needs_compiler,
    program,
    run,
)

pytestmark = needs_compiler


def table(kind):
    """Columns of a test vector by name."""
    made, folder = exported(kind)
    with (folder / f"{made.name}_vector.csv").open() as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


@pytest.mark.slow
@pytest.mark.parametrize("kind", GAINS)
def test_the_vector_is_replayed_to_1e_9_and_that_of_an_MPC_to_1e_6(kind):
    _, folder = exported(kind)
    said = run(program(kind, "test_vector"), folder=folder)
    steps, held, worst = re.fullmatch(
        r"(\d+) steps, (\d+) held, largest difference (\S+) \w+\n", said.stdout
    ).groups()
    assert said.returncode == 0
    assert int(steps) == STEPS.get(kind, 10_000)
    assert int(held) >= 1
    assert float(worst) <= (1e-6 if kind.startswith("mpc") else 1e-9)


@pytest.mark.parametrize("kind", ["pi", "feedforward"])
def test_the_replay_fails_where_an_expected_output_is_another(kind):
    made, folder = exported(kind)
    lines = (folder / f"{made.name}_vector.csv").read_text().splitlines()
    cells = lines[1500].split(",")
    lines[1500] = ",".join([*cells[:-1], repr(float(cells[-1]) + 1e-8)])
    (folder / "spoiled.csv").write_text("\n".join(lines) + "\n")
    said = run(program(kind, "test_vector"), "spoiled.csv", folder=folder)
    assert said.returncode == 1
    assert float(re.search(r"difference (\S+)", said.stdout)[1]) == pytest.approx(1e-8, rel=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pi", "lqi", "feedforward-pi", "mpc"])
def test_the_vector_shows_the_law_both_ends_of_the_range_and_what_lies_between(kind):
    command = table(kind)["expected_command_V"]
    assert command.min() == 0.0
    assert command.max() == pytest.approx(4.0, abs=1e-12)
    assert np.mean((command > 0.0) & (command < 4.0)) > 0.5
    assert np.unique(command).size > 5000


def test_the_vector_of_the_PI_is_that_of_the_equations_written_out_once_more():
    columns, (Kp, Ki) = table("pi"), GAINS["pi"]
    integral, worst, held = 0.0, 0.0, 100.0 / 49.4
    seen, age, sensor = 0.0, 1e9, exported("pi")[0].sensors.angle
    rows = zip(columns["reference_deg"], columns["angle_deg"], columns["expected_command_V"], strict=True)
    for reference, angle, expected in rows:
        e, age = reference - angle, age + 1.0
        in_range = sensor.low <= angle <= sensor.high
        if in_range and abs(angle - seen) <= sensor.jump + sensor.rate * 0.001 * age:
            seen, age = angle, 0.0
        if age == 0.0 and sensor.low <= reference <= sensor.high:
            wanted = (100.0 + Kp * e + integral) / 49.4
            held = min(max(wanted, 0.0), 4.0)
            if not ((wanted > 4.0 and e > 0.0) or (wanted < 0.0 and e < 0.0)):
                integral += Ki * e * 0.001
        worst = max(worst, abs(held - expected))
    assert worst < 1e-9


def test_the_vector_of_the_observer_leads_the_memory_through_the_whole_loop():
    columns, p = table("observer"), WRIST.hysteresis
    h, P = columns["expected_static_angle_deg"], columns["pressure_kPa"]
    seen = np.isfinite(P) & np.isfinite(columns["angle_deg"])
    for name, most in (("pressure_kPa", 20.0), ("angle_deg", 5.0)):  # beside spikes, which are not believed
        with np.errstate(over="ignore"):
            seen &= np.abs(columns[name] - np.nanmedian(columns[name])) < 300.0
            seen &= ~(np.abs(np.diff(columns[name], prepend=columns[name][0])) > most)
    low, high = p.a1 * (P - p.rest_pressure) - p.w1, p.a2 * (P - p.rest_pressure) + p.w2
    assert (h[seen] >= low[seen] - 1e-9).all()
    assert (h[seen] <= high[seen] + 1e-9).all()
    for line in (low, high):
        assert np.mean(np.abs(h[seen] - line[seen]) < 1e-9) > 0.01


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "most"),
    [
        ("pi", 1e-5),
        ("pi-2dof", 1e-5),
        ("cascade", 1e-5),
        ("lqi", 1e-4),
        ("feedforward-pi", 5e-3),
        ("observer", 5e-4),
        ("mpc", 2e-2),
        ("mpc-real-time", 5e-2),
    ],
)
def test_single_precision_compiles_without_a_double_and_stays_by_what_it_is_told(kind, most, tmp_path):
    made = exported(kind)[0].at("single")
    for name, text in contents(made, WRIST, 2000).items():
        (tmp_path / name).write_text(text)
    sources = [f"{made.name}.c", f"{made.name}_law.c"]
    for source in sources:
        compiled(source, (*MADE, "-Wdouble-promotion"), tmp_path)
        assert "double" not in re.sub(r"/\*.*?\*/", "", (tmp_path / source).read_text(), flags=re.DOTALL)
    objects = [name.replace(".c", ".o") for name in [*sources, "test_vector.c"]]
    compiled("test_vector.c", MADE, tmp_path)
    assert run(CC, *objects, "-lm", "-o", "test_vector", folder=tmp_path).returncode == 0
    said = run(tmp_path / "test_vector", folder=tmp_path)
    assert said.returncode == 0
    assert 0.0 < float(re.search(r"difference (\S+)", said.stdout)[1]) <= most
