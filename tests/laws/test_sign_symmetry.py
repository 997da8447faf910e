"""A wrist with the same lines in both directions does not know plus from minus."""

from dataclasses import replace

import numpy as np
from hypothesis import given

from plants import Wrist
from tests.laws.law_strategies import REST, commands, paths, symmetric_loops, walk, wrists


@given(symmetric_loops(), paths)
def test_mirrored_pressures_give_mirrored_angles(loop, path):
    there, mirrored = walk(loop, path), walk(loop, [2.0 * REST - p for p in path])
    assert abs(float(there.h) + float(mirrored.h)) < 1e-9
    assert float(there.virgin) == float(mirrored.virgin)


@given(wrists(symmetric_loops()), commands())
def test_mirrored_commands_give_mirrored_angles(wrist, volts):
    hold = REST / wrist.regulator.gain
    there, mirrored = wrist.simulate(volts), wrist.simulate(2.0 * hold - np.array(volts))
    np.testing.assert_allclose(mirrored.angle, -there.angle, rtol=0, atol=1e-9)
    np.testing.assert_allclose(mirrored.pressure - REST, REST - there.pressure, rtol=0, atol=1e-9)


def test_the_flexion_of_the_parameter_set_is_symmetric_and_the_deviation_is_not():
    up, down = np.full(3000, 3.0), np.full(3000, 200.0 / 49.4 - 3.0)
    for wrist, symmetric in ((Wrist.flexion(), True), (Wrist.deviation(), False)):
        plus, minus = wrist.simulate(up).angle, wrist.simulate(down).angle
        assert np.allclose(plus, -minus, rtol=0, atol=1e-9) is symmetric


def test_exchanging_the_lines_exchanges_the_directions():
    wrist = Wrist.deviation()
    p = wrist.hysteresis
    turned = replace(wrist, hysteresis=replace(p, a1=p.a2, w1=p.w2, a2=p.a1, w2=p.w1))
    volts = 2.0 + np.sin(np.arange(6000) * 0.002) * np.linspace(0.0, 1.9, 6000)
    np.testing.assert_allclose(
        turned.simulate(200.0 / 49.4 - volts).angle, -wrist.simulate(volts).angle, rtol=0, atol=1e-9
    )
