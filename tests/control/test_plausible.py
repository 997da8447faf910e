"""A reading is believed exactly where its range, noise and the time since the last one allow it."""

from dataclasses import replace
from math import inf, isfinite, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from design.controllers.measurement.plausible import Channel, LastBelieved, SensorLimits, believed
from plants import Wrist
from plants.errors import InputError

finite = st.floats(-1e3, 1e3)
channels = st.builds(
    lambda low, width, jump, rate: Channel(low, low + width, jump, rate),
    finite, st.floats(0.1, 500.0), st.floats(1e-3, 100.0), st.floats(1e-3, 1e4),
)  # fmt: skip
readings = st.one_of(finite, st.sampled_from([nan, inf, -inf, 1e9, -1e9]))
LIMITS = SensorLimits.of(Wrist.flexion())


@given(channels, readings)
def test_the_range_holds_its_ends_and_what_lies_between(channel, value):
    assert float(channel.holds(value)) == float(channel.low <= value <= channel.high)
    for end, beyond in ((channel.low, -inf), (channel.high, inf)):
        assert float(channel.holds(end)) == 1.0
        assert float(channel.holds(np.nextafter(end, beyond))) == 0.0


@given(channels, finite, st.lists(readings, min_size=1, max_size=12))
def test_readings_are_believed_as_the_rule_says(channel, first, values):
    """The rule as it is told: within the range, and no further from the last believed reading than the
    jump and as many rates as samples have passed since."""
    s, last, since = LastBelieved(first, 0.0), first, 0
    for value in values:
        s, good = believed(s, value, channel)
        since += 1
        near = isfinite(value) and abs(value - last) <= channel.jump + channel.rate * since
        expected = near and channel.low <= value <= channel.high
        assert float(good) == float(expected)
        if expected:
            last, since = value, 0
        assert (float(s.value), float(s.age)) == (last, since)


@given(channels, finite, readings)
def test_the_first_reading_is_believed_wherever_it_lies_in_the_range(channel, start, value):
    wide = replace(channel, rate=max(channel.rate, 0.01))
    _, good = believed(LastBelieved(start), value, wide)
    assert float(good) == float(wide.holds(value))


@pytest.mark.parametrize("dt", [0.001, 0.02])
@pytest.mark.parametrize("channel", [LIMITS.angle, LIMITS.pressure], ids=["angle", "pressure"])
def test_a_sensor_put_back_elsewhere_is_believed_within_half_a_second(channel, dt):
    of = channel.sampled(dt)
    for last, value in ((channel.low, channel.high), (channel.high, channel.low)):
        s = LastBelieved(last, 0.0)
        for _ in range(round(0.5 / dt)):
            s, good = believed(s, value, of)
            if good:
                break
        assert good


@given(st.floats(-100.0, 100.0), st.floats(0.1, 300.0), st.floats(0.0, 1e4))
def test_around_a_plant_there_is_as_much_room_again_on_either_side(low, width, fastest):
    channel = Channel.around(low, low + width, fastest)
    middle, half = (channel.low + channel.high) / 2.0, (channel.high - channel.low) / 2.0
    assert (middle, half) == pytest.approx((low + width / 2.0, 1.5 * width), abs=1e-9)
    assert channel.jump == pytest.approx(0.05 * width)
    # Four times the model's fastest motion, and from end to end in half a second at least.
    assert channel.rate == pytest.approx(max(4.0 * fastest, 2.0 * half / 0.5))
    assert channel.sampled(0.01).rate == pytest.approx(0.01 * channel.rate)


@pytest.mark.parametrize(
    "wrist", [Wrist.flexion(), Wrist.deviation(), Wrist.flexion().with_values(k_slow=90.0)]
)
def test_no_motion_of_the_model_is_refused(wrist):
    """The fastest pressure there is, end to end at the regulator's larger rate, and the angle of it."""
    limits, air = SensorLimits.of(wrist), wrist.regulator
    low, high = wrist.rig.pressure_range
    fastest = max(air.k_fast, air.k_slow) * (high - low)
    assert limits.pressure.rate >= fastest
    least, most = wrist.hysteresis.reachable(low, high)
    assert limits.angle.rate >= (most - least) / wrist.Tw
    assert (limits.angle.low, limits.angle.high) == pytest.approx((2 * least - most, 2 * most - least))
    assert (limits.pressure.low, limits.pressure.high) == pytest.approx((2 * low - high, 2 * high - low))


@given(readings, readings)
def test_a_start_is_what_is_seen_or_the_wrist_at_rest(pressure, angle):
    good = bool(LIMITS.pressure.holds(pressure)) and bool(LIMITS.angle.holds(angle))
    rest = (LIMITS.rest_pressure, LIMITS.rest_angle)
    assert LIMITS.start(pressure, angle) == (*((pressure, angle) if good else rest), good)
    assert rest == (100.0, 0.0)


@pytest.mark.parametrize(
    "numbers", [(0.0, 0.0, 1.0, 1.0), (1.0, 0.0, 1.0, 1.0), (nan, 1.0, 1.0, 1.0), (0.0, inf, 1.0, 1.0),
                (0.0, 1.0, 0.0, 1.0), (0.0, 1.0, 1.0, 0.0), (0.0, 1.0, nan, 1.0), (0.0, 1.0, -1.0, 2.0)]
)  # fmt: skip
def test_a_channel_that_is_none_is_refused(numbers):
    with pytest.raises(InputError):
        Channel(*numbers)
