"""All rungs at all dead times: continuous and sampled ones, with what is looked for against them."""

from dataclasses import replace

import pytest

from design.controllers.pi import PI
from design.robustness.certificates import rungs
from design.robustness.certificates.certificate import Switching
from design.robustness.certificates.reasons import OtherLaw
from design.robustness.loop_model import LoopModel
from design.status import Status
from plants import Wrist

WRIST, TIMES = Wrist.flexion(), (0.0, 0.05)


def test_of_a_controller_with_another_law_every_class_is_open_at_every_dead_time(monkeypatch):
    other = replace(LoopModel.of(WRIST, PI(1.2, 2.2)), other_law="a filter of its own")
    monkeypatch.setattr(rungs.LoopModel, "of", lambda *_: other)
    monkeypatch.setattr(rungs.ladder, "certify", lambda *_: pytest.fail("a rung was tried"))
    found, word = rungs.certify_everything(WRIST, PI(1.2, 2.2), TIMES)
    assert word is None
    assert [(c.dead_time, c.about.switching) for c in found] == [(t, s) for t in TIMES for s in Switching]
    assert {c.status for c in found} == {Status.OPEN}
    assert {c.reason for c in found} == {OtherLaw("a filter of its own")}
    assert {c.decay for c in found} == {None}
    for c in found:  # about the loops between the plant's rates and slopes
        assert c.about.rates == (WRIST.regulator.k_slow, WRIST.regulator.k_fast)
        assert c.about.slopes == (WRIST.hysteresis.s, max(WRIST.hysteresis.a1, WRIST.hysteresis.a2))


@pytest.mark.parametrize("stable", [True, False])
def test_each_room_of_rungs_is_asked_once_and_a_word_only_of_stable_branches(stable, monkeypatch):
    asked, shares = [], []
    monkeypatch.setattr(rungs.ladder, "certify", lambda *a: asked.append(a[3:]) or ["continuous"])
    monkeypatch.setattr(rungs.sampled_loop, "word_of", lambda model: "word")
    monkeypatch.setattr(
        rungs.sampled_loop, "certify_sampled", lambda m, t, w: asked.append((t, w)) or ["sampled"]
    )
    monkeypatch.setattr(rungs, "certify_memory", lambda m, w, c, t, b: asked.append((t, b)) or ["memory"])
    found, word = rungs.certify_everything(WRIST, PI(1.2, 2.2), [0.0, 0.05], "box", stable, shares.append)
    assert found == ["continuous", "sampled", "memory"]
    assert word == ("word" if stable else None)
    assert asked == [(WRIST.rig.task.step, TIMES), (TIMES, word), (TIMES, "box")]
    assert shares == sorted(shares)
    assert all(0.0 < s < 1.0 for s in shares)
