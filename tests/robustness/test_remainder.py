"""What a plant leaves disturbs every case of its requirement: bounded, still where the wrist is still, and
read from the plant's file."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.cases import stack
from design.evaluation.runner import play
from design.robustness.box import SHIFT
from design.robustness.certificates.memory.ladder import IN_BOX, certify_memory, plants_of
from design.robustness.loop_model import LoopModel
from design.robustness.requirement import requirement, requirement_record
from design.robustness.samples.adversary import worst_case
from design.robustness.samples.scenario_file import load as load_scenario
from design.robustness.samples.scenario_file import save
from plants import Wrist
from plants.effects.wrist.remainder import MULTIPLES, PEAK_OVER_RMS, WEIGHTS, ColouredRemainder
from plants.parameters.files import built_in, dump, load
from plants.parameters.remainder import BANDS, RemainderSize

LEFT = RemainderSize(0.3, 2.0, 0.8, 6.0, 0.07, 0.01, dict.fromkeys(BANDS, 0.25))
PLANT = replace(built_in("flexion"), remainder={"angle_deg": LEFT})


def test_the_disturbance_is_the_sum_of_sines_along_the_way():
    wrist = Wrist.flexion()
    met = ColouredRemainder(0.5, 4.0, 0.3)
    volts = np.full(6000, 3.2)
    plain, disturbed = wrist.simulate(volts), (wrist + met).simulate(volts)
    steps = np.abs(np.diff(plain.static_angle))
    turned = np.array([np.append(0.0, np.cumsum(2.0 * np.arctan(0.5 * m / 4.0 * steps))) for m in MULTIPLES])
    begins = MULTIPLES[:, None] * 0.3 * 60.0
    share = (WEIGHTS / WEIGHTS.sum())[:, None]
    wanted = 0.5 * (share * (np.sin(begins + turned) - np.sin(begins))).sum(axis=0)
    # Behind the joint's lag, a first-order one of the wrist's time constant.
    from scipy.signal import lsim

    _, seen, _ = lsim(([1.0], [wrist.Tw, 1.0]), wanted, np.arange(wanted.size) * 0.001)
    np.testing.assert_allclose(disturbed.angle - plain.angle, seen, atol=1e-4)
    assert np.abs(wanted).max() <= 2.0 * 0.5
    late = disturbed.angle[-1] - disturbed.angle[-500]
    assert abs(late - (plain.angle[-1] - plain.angle[-500])) < 1e-3  # nothing moves at rest


def test_it_has_the_rms_and_stays_within_the_largest():
    assert ColouredRemainder.of(LEFT).peak == pytest.approx(PEAK_OVER_RMS * 0.3)
    assert ColouredRemainder.of(replace(LEFT, largest=0.4)).peak == 0.4
    assert ColouredRemainder.of(replace(LEFT, rms=0.03)) is None
    t = np.random.default_rng(0).random((200_000, 1)) * 1e4
    waves = (WEIGHTS * np.sin(MULTIPLES * t + np.arange(4.0))).sum(axis=1) / WEIGHTS.sum()
    assert np.abs(waves).max() / waves.std() == pytest.approx(PEAK_OVER_RMS, rel=0.03)


def test_the_sines_share_the_power_of_first_order_noise():
    """Each has what noise of the spectrum 1 / (1 + k^2) has in the band of wave numbers about its own."""
    from scipy.integrate import quad

    between = np.sqrt(MULTIPLES[1:] * MULTIPLES[:-1])
    edges = np.r_[MULTIPLES[0] ** 2 / between[0], between, MULTIPLES[-1] ** 2 / between[-1]]
    power = np.array([quad(lambda k: 1.0 / (1.0 + k * k), *band)[0] for band in pairwise(edges)])
    np.testing.assert_allclose(WEIGHTS**2 / np.sum(WEIGHTS**2), power / power.sum(), rtol=0.15)


def test_the_plants_file_brings_it_into_the_requirement(tmp_path):
    dump(PLANT, tmp_path / "plant.toml")
    again = load(tmp_path / "plant.toml")
    assert again.remainder == PLANT.remainder
    asked, bare = requirement(again), requirement(built_in("flexion"))
    assert asked.box.names == (*bare.box.names, SHIFT)
    assert asked.box.leaving(None) == replace(bare.box, plant=asked.box.plant)
    assert requirement_record(asked)["remainder"] == {"peak": PEAK_OVER_RMS * 0.3, "length": 6.0}
    assert requirement_record(bare)["remainder"] is None
    # The same cases, without it and with each of eight parts of it.
    controller, shift = PI.of(bare.wrist, 2.2, 4.5), len(bare.box.intervals)
    x = np.random.default_rng(3).random((bare.space.size, 40))
    x = x[:, bare.space.reachable(x)]
    calm = bare.run(x, controller)["iae_deg_s"]
    loud = [
        asked.run(np.insert(x, shift, part, axis=0), controller)["iae_deg_s"]
        for part in np.linspace(0.0, 1.0, 8)
    ]
    assert np.mean(np.max(loud, axis=0) > calm) > 0.9
    assert np.max(np.abs(np.array(loud) - calm)) < 2.0 * PEAK_OVER_RMS * 0.3 * asked.duration


def test_no_move_changes_it_by_more_than_its_steepest_share():
    """So a residual is a change of slope, bounded: what certificates take it for."""
    met = ColouredRemainder(0.5, 4.0, 0.0)
    rng = np.random.default_rng(5)
    wave = met.sampled(None, 0.001)
    largest = 0.0
    for shift in rng.random(40):
        phase = replace(met, shift=shift).rest(None, 0.0, 0.0)
        for way in np.geomspace(1e-3, 20.0, 60):
            _, before, after = wave.static(phase, 0.0, way, None)
            largest = max(largest, abs(after - before - way) / way)
    assert 0.8 * met.steepest < largest <= met.steepest


@pytest.mark.slow
def test_the_box_of_a_plant_with_a_residual_has_wider_slopes_and_a_slower_proof():
    asked, bare = requirement(PLANT), requirement(built_in("flexion"))
    share = asked.box.remainder.steepest
    low, high = bare.box.slopes("line1")
    assert asked.box.slopes("line1") == pytest.approx(((1.0 - share) * low, (1.0 + share) * high))
    gains = PI.of(bare.wrist, 1.2, 2.2)
    model = LoopModel.of(bare.wrist, gains)
    assert plants_of(asked.box, gains).slopes["line1"] == asked.box.slopes("line1")

    def rate(box):
        (found,) = (c for c in certify_memory(model, bare.wrist, gains, (0.0,), box) if IN_BOX in c.rung)
        return found.decay or 0.0

    assert 0.0 < rate(asked.box) < rate(bare.box)
    # A residual as steep as the loop itself may turn its slope: nothing is proved of that.
    steep = asked.box.leaving(ColouredRemainder(6.0, 5.0))
    assert steep.slopes("transit")[0] < 0.0
    assert rate(steep) == 0.0


@pytest.mark.slow
def test_a_worst_case_with_a_remainder_is_played_again(tmp_path):
    box = requirement(PLANT).box
    worst = worst_case(box, PI.of(box.wrist, 3.0, 8.0), budget=400, seed=1)
    save(worst, tmp_path / "worst.toml")
    saved = load_scenario(tmp_path / "worst.toml")
    played = play(stack([saved.case]), saved.controller)
    assert float(played.metrics.overshoot_percent[0]) == worst.metrics["overshoot_percent"]
    assert saved.case.wrist.values[SHIFT] == worst.case.wrist.values[SHIFT]


@pytest.mark.parametrize(
    ("line", "said"),
    [("rms = -1.0", "rms = -1.0"), ("loudness = 2.0", "loudness"), ("spectrum = [1.0]", "spectrum")],
)
def test_a_remainder_that_is_none_is_told_in_a_line(tmp_path, line, said):
    from plants.errors import InputError

    dump(PLANT, tmp_path / "plant.toml")
    name = line.split(" ")[0]
    kept = (tmp_path / "plant.toml").read_text().splitlines()
    at = kept.index("[remainder.angle_deg]")
    tail = [row for row in kept[at:] if not row.startswith(f"{name} ")]
    (tmp_path / "bad.toml").write_text("\n".join([*kept[:at], *tail, line]) + "\n")
    with pytest.raises(InputError, match=said) as told:
        load(tmp_path / "bad.toml")
    assert "\n" not in str(told.value)
