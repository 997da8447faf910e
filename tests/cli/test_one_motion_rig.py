"""A rig of another kind, with one motion, in mm, at 20 ms and 0 to 10 V, passes through every command.

That the numbers are right is claimed elsewhere, of the same code on the paper's wrist; here that no number of
that wrist is left in the way, and that what is shown carries the rig's name and units.
"""

import re
from dataclasses import replace

import numpy as np
import pytest

from design.comparison.compare import on_tasks
from design.comparison.on_tasks import played_on_tasks
from design.controllers.pi import PI
from design.limit import ratios
from plants import Wrist, built_in
from plants.errors import InputError
from plants.parameters.files import dump, load
from plants.parameters.quantities import Assumed
from plants.rig import Rig, StepTask, Uncertainty, Units

BENDER = Rig(
    "bender", "Bending actuator", ("bend",), Units("V", "kPa", "mm"), (0.0, 10.0), (0.0, 200.0), 0.02,
    0.04, StepTask(10.0, 0.02, 10.0, 5.0, (100.0, 150.0)),
    {"overshoot_percent": 5.0, "Ms": 2.0, "delay_margin_s": 0.08, "total_variation_V": 40.0,
     "steady_error_percent": 2.0},
    Uncertainty(0.2, 0.1, 0.2, 0.2, (0.0, 0.06)),
)  # fmt: skip
VALUES = {
    "gain": 20.0, "k_fast": 6.0, "k_slow": 0.8, "e0": 8.0, "a1": 0.25, "w1": 4.0, "a2": 0.25, "w2": 4.0,
    "s": 0.06, "rest_pressure": 100.0, "Tw": 0.2,
}  # fmt: skip


@pytest.fixture(scope="module")
def bender(tmp_path_factory):
    """The file of its parameter set."""
    base = built_in("flexion")
    known = {
        n: replace(
            base.parameters[n], value=v, unit=BENDER.units.of(base.kinds[n].unit, base.rig.units),
            low=0.2 * v, high=5.0 * v, provenance=Assumed("of the order of such actuators"),
        )
        for n, v in VALUES.items()
    }  # fmt: skip
    found = replace(base, axis="bend", title="Bending actuator", parameters=known, rig=BENDER)
    path = tmp_path_factory.mktemp("bender") / "bender.toml"
    dump(found, path)
    assert load(path) == found
    return path


@pytest.fixture(scope="module")
def campaign(bender, tmp_path_factory):
    """Recordings of it, with noise, every 40 ms."""
    wrist, draw = Wrist.of(load(bender)), np.random.default_rng(4)
    folder = tmp_path_factory.mktemp("campaign")
    courses = {"stairs": (5.0, 8.0, 3.0, 6.0, 9.0, 1.0, 5.0), "steps": (5.0, 9.0, 2.0, 7.0, 4.0, 5.5, 1.5)}
    for name, levels in courses.items():
        volts = np.repeat(levels, 300)
        r = wrist.simulate(volts, every=2)
        rows = np.column_stack([
            r.time[:-1], volts[::2], r.pressure[:-1] + draw.normal(0.0, 0.2, len(r.time) - 1),
            r.angle[:-1] + draw.normal(0.0, 0.03, len(r.time) - 1),
        ])  # fmt: skip
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", comments="", fmt="%.6g",
                   header="time_s,command_V,pressure_kPa,position_mm")  # fmt: skip
    (folder / "campaign.toml").write_text(
        'axis = "bend"\nsample_time_s = 0.04\nfit = ["stairs.csv"]\nvalidate = ["steps.csv"]\n'
        '[columns]\nangle_deg = "position_mm"\n'
    )
    return folder


def test_a_step_is_told_in_its_units(wrist, bender):
    said = wrist("simulate", "--plant", bender, "--gains", "2,5", "--step", "10").out
    assert "step of 10 mm with Kp 2 kPa/mm, Ki 5 kPa/(mm s)" in said
    assert "deg" not in said


def test_gains_are_tuned_on_its_own_task(wrist, bender, tmp_path):
    outcome = wrist(
        "tune", "--plain", "--plant", bender, "--points", "8", "--starts", "1", "--json", tmp_path / "t.json"
    )
    assert "nominal step of +10 mm" in outcome.out
    assert re.search(r"\bdeg\b", outcome.out) is None


def test_it_is_fitted_and_traced(wrist, bender, campaign, tmp_path):
    fitted = tmp_path / "fitted.toml"
    assert wrist("fit", campaign, "--plant", bender, "--starts", "2", "--save", fitted).code == 0
    found = load(fitted)
    assert found.rig == BENDER
    assert found.values["a1"] == pytest.approx(0.25, rel=0.03)
    traced = wrist("trace", campaign, "--plant", bender, "--json", "-").json
    assert traced["verdict"] == "nothing-missing"


@pytest.mark.suite
def test_a_certificate_and_a_sample_are_made(wrist, bender):
    words = ("--gains", "2,4", "--samples", "50", "--budget", "500")
    assert wrist("robust", "--plant", bender, *words).code in (0, 1)


def test_c_is_made(wrist, bender, tmp_path):
    gains = ("--gains", "2,4")
    assert wrist("export", "pi", "--plant", bender, *gains, "--out", tmp_path / "c").code == 0
    assert "0.02" in (tmp_path / "c" / "README.md").read_text()


def test_no_controller_beats_the_bounds_of_its_tasks(bender):
    plant = Wrist.of(load(bender))
    done = played_on_tasks(plant, [PI.of(plant, 4.6, 11.0)])
    assert set(done.metrics) == set(on_tasks(plant, [PI.of(plant, 4.6, 11.0)]))
    for task, (judged,) in done.metrics.items():
        of = ratios(judged, done.bounds[task])
        assert float(of.settling) >= 1.0
        assert float(of.iae) >= 1.0


@pytest.mark.suite
def test_it_is_compared_alone_and_the_page_speaks_of_it(wrist, bender, tmp_path):
    out = tmp_path / "out"
    args = (
        "--points",
        "8",
        "--samples",
        "0",
        "--mpc-plants",
        "0",
        "--out",
        out,
        "--json",
        tmp_path / "c.json",
    )
    assert wrist("compare", "--plain", "--plant", bender, *args).code == 0
    page = re.sub(r"(?s)<(script|style|svg)\b.*?</\1>", "", (out / "comparison.html").read_text())
    words = re.sub(r"<[^>]*>", " ", page)
    assert "10 mm" in words
    assert "bend" in words
    for foreign in (r"\bdeg\b", "flexion", "deviation", r"\b15 degree"):
        assert re.search(foreign, words) is None, foreign


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("range = [0.0, 10.0]", "range = [10.0, 0.0]", "the lower comes first"),
        ("loop_s = 0.02", "loop_s = -1", "loop_s = -1 must be positive"),
        ("step = 10.0", "stride = 10.0", "unknown key 'stride'"),
        ('angle = "mm"', "angle = 3", "angle is missing or no str"),
        ("width = 0.2", "width = 1.5", "must be a share from 0 to below 1"),
    ],
)
def test_a_bad_rig_is_refused_in_one_line(bender, tmp_path, old, new, words):
    text = bender.read_text()
    assert old in text
    bad = tmp_path / "bad.toml"
    bad.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=words) as caught:
        load(bad)
    assert "\n" not in str(caught.value)
