"""Members of the exported structs are declared as C declares them."""

import pytest

from design.export.fields import Quantity


@pytest.mark.parametrize(
    ("size", "counts", "declared"),
    [
        (1, False, "double late_deg;"),
        (2, False, "double late_deg[2];"),
        (3, False, "double late_deg[3];"),
        (1, True, "int late_deg;"),
        (2, True, "int late_deg[2];"),
    ],
)
def test_a_member_of_several_numbers_is_an_array(size, counts, declared):
    assert Quantity("late", "deg", "", size, counts=counts).declaration == declared
