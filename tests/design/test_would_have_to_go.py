"""Where no gains meet every limit, what keeps them from it is told, an effect of the plant too."""

from dataclasses import replace

import pytest

from design.robustness.requirement import requirement
from design.studies.designs import _would_have_to_go
from plants.effects import Creep
from plants.parameters.files import built_in


@pytest.mark.slow
def test_a_creep_that_outlasts_the_limit_of_settling_is_named():
    """Half of the angle creeps within ten seconds."""
    values = {"creep.gain": 0.5, "creep.time_constant": 10.0}
    plant = built_in("flexion").revised((Creep,), values, {}, "test", "flexion")
    tried = []
    found = _would_have_to_go(requirement(plant), 0, 15, None, lambda stage, share: tried.append(stage))
    assert found == "the plant's creep"
    assert tried[0] == "without the dead time"  # parts of the requirement come first


@pytest.mark.slow
def test_parts_of_the_requirement_are_named_first():
    """Gains of the plant as declared hold all but a dead time of half a second."""
    required = requirement(built_in("flexion"))
    late = replace(required, conditions=replace(required.conditions, dead_time=0.5))
    assert _would_have_to_go(late, 0, 15, None, lambda stage, share: None) == "the dead time"
