"""The loop depends on where the pressure turned, not on how fast it moved."""

from hypothesis import given
from hypothesis import strategies as st

from plants.hysteresis import Memory
from tests.laws.law_strategies import REST, loops, paths, pressures, trace, walk


@given(loops(), paths, pressures, st.integers(2, 50))
def test_cutting_a_monotone_move_into_pieces_changes_nothing(loop, path, after, cuts):
    before = walk(loop, path)
    whole = loop.step(before, path[-1], after)
    _, angles, pieces = trace(loop, [after], path[-1], before, cuts)
    assert abs(float(whole.h) - angles[-1]) < 1e-10
    assert float(pieces.virgin) == float(whole.virgin)


@given(loops(), paths)
def test_holding_the_pressure_holds_the_memory(loop, path):
    memory = walk(loop, path)
    held = loop.step(memory, path[-1], path[-1])
    assert (float(held.h), float(held.virgin)) == (float(memory.h), float(memory.virgin))


@given(loops(), paths, st.integers(2, 50))
def test_a_whole_path_may_be_cut_into_pieces(loop, path, cuts):
    _, angles, _ = trace(loop, path, REST, Memory(0.0, 1.0), cuts)
    assert abs(float(walk(loop, path).h) - angles[-1]) < 1e-10
