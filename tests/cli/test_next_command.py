"""Which command a trace names as the next."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from design.cli.commands.logs.trace import _next
from plants.parameters.files import built_in

CAMPAIGN, SAVED = Path("campaign"), Path("plant.toml")


@pytest.mark.parametrize(
    ("worse", "save", "words"),
    [
        (False, None, ("design", CAMPAIGN)),
        (False, SAVED, ("tune", "--plant", SAVED)),
        (True, SAVED, ("fit", CAMPAIGN, "--save", "declared.toml")),
    ],
)
def test_a_plant_that_is_worse_than_the_declared_one_is_not_tuned(worse, save, words):
    campaign = SimpleNamespace(stage="wrist")
    trace = SimpleNamespace(worse=worse, campaign=campaign, revised=built_in("flexion"))
    assert _next(trace, CAMPAIGN, save) == words
