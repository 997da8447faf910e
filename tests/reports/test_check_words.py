"""What a check of a log says of the plant, whatever the trace left of it."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from plants.parameters.files import built_in
from plants.parameters.remainder import RemainderSize
from reports.check.words import plant

LEFT = RemainderSize(1.0, 2.5, 0.5, 20.0, 0.05, 0.03, {0.0: 0.5, 0.1: 0.5})


@pytest.mark.parametrize(
    ("left", "allowed", "said"),
    [
        (None, 0.1, "the plant is unchanged since the trace"),
        (LEFT, 3.0, "the plant is unchanged since the trace, to within 3 deg"),
        (LEFT, 9.0, "whether the plant has changed by less than 9 deg cannot be told"),
    ],
)
def test_a_residual_that_hides_a_change_is_told(left, allowed, said):
    """Steps of 15 deg."""
    traced = replace(built_in("flexion"), remainder={"angle_deg": left} if left else {})
    channel = SimpleNamespace(channel="angle_deg", allowed=allowed, new=False)
    residual = SimpleNamespace(new=False, channels=(channel,), change=None)
    assert plant(SimpleNamespace(plant=traced, residual=residual)) == said
