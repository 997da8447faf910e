"""Of a delay line a struct keeps what is put in, and a ring for what comes out: all else of a state stays."""

from design.export.fields import Quantity
from design.export.rings import kept, rings
from plants.actuator.delay import DelayLine

LINE = [Quantity(f"line_{leaf}", "deg", "") for leaf in DelayLine._fields]
PRESSURE, ANGLE, SHIFT = (Quantity(name, "", "") for name in ("pressure", "angle", "shift"))


def test_all_is_kept_but_what_is_read_from_the_ring_in_every_sample():
    state = [PRESSURE, *LINE, ANGLE, SHIFT, *LINE]
    found = kept(state, [(1, 30), (6, 0)])
    assert all(state[place] is leaf for place, leaf in found)
    assert [leaf.name for _, leaf in found] == ["pressure", "line_newest", "angle", "shift", "line_newest"]
    assert [leaf for _, leaf in kept(state, [])] == state


def test_a_ring_holds_the_samples_of_the_delay_and_the_one_before():
    state = [PRESSURE, *LINE]
    (ring,) = rings(state, [(1, 30)])
    places = {"near": ring.near, "far": ring.far, "newest": ring.newest}
    assert {leaf: state[place].name for leaf, place in places.items()} == {
        leaf: f"line_{leaf}" for leaf in DelayLine._fields
    }
    assert ring.size == 31
    assert [member.name for member in ring.fields] == ["line_line", "line_oldest"]
    assert ring.fields[1].declaration == "int line_oldest;"  # a place in an array
