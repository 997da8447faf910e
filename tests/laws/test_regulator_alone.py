"""The regulator without loop and joint gives the pressure of the whole plant, whatever its effects."""

import numpy as np
import pytest

from plants.effects import EFFECTS
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.parameters.files import built_in
from plants.simulation.open_loop import open_loop, pressed
from plants.wrist import Wrist

FORMS = [form for forms in EFFECTS.values() for form in forms if form.STAGE == "regulator"]
LANES = 5


def wrists(axis, forms, lanes):
    """Wrists whose parameters lie between their bounds, those of effects in the lower quarter."""
    rng, known = np.random.default_rng(4), built_in(axis)
    values = {n: v * rng.uniform(0.9, 1.1, lanes) for n, v in known.values.items()}
    for form in forms:
        values |= {
            f"{form.NAME}.{n}": k.low + rng.uniform(0.05, 0.25, lanes) * (k.high - k.low)
            for n, k in form.kinds().items()
        }
    return Wrist.from_values(values, tuple(forms), known.rig)


@pytest.mark.parametrize(
    "forms", [[], *([f] for f in FORMS)], ids=lambda f: "-".join(x.__name__ for x in f) or "none"
)
def test_it_is_the_pressure_of_the_plant(forms):
    plant = wrists("flexion", forms, LANES)
    commands = np.repeat(np.random.default_rng(5).uniform(0.2, 3.8, 12), 250)
    whole = open_loop(plant, commands, every=10).pressure
    np.testing.assert_allclose(pressed(plant, commands, every=10), whole, rtol=1e-12)
    assert np.ptp(whole) > 20.0


def test_of_one_plant_it_is_a_series_and_is_read_where_a_recording_has_rows():
    plant = Wrist.deviation()
    time = np.array([0.0, 0.01, 0.02, 0.04, 0.05])
    log = Recording("a", time, np.array([2.0, 2.5, 3.0, 1.0, 1.0]), pressure=np.zeros(5))
    playback = Playback(log)
    np.testing.assert_allclose(playback.press(plant), playback.play(plant)[0], rtol=1e-12)
