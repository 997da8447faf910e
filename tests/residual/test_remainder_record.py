"""What a model leaves, as it is handed to the checks."""

import numpy as np

from plants.measured.residual.series.remainder import Remainder


def test_a_channel_of_unknown_resolution_has_none():
    time = np.arange(5.0)
    assert Remainder("log", "wrist", time, 0.0 * time, 0.1, {}).resolution == 0.0
