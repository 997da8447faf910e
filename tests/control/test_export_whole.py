"""An export is there whole or not at all: two of them do not mix, and `make check` sees it where they do."""

import shutil

import pytest

from design.export.catalogue import part
from design.export.formats import folder as exporting
from design.export.formats.folder import MANIFEST, write
from tests.control.c_target import WRIST, needs_compiler, run

OLD, NEW = (3.1, 10.4), (1.2, 2.2)


@pytest.fixture(autouse=True)
def short(monkeypatch):
    """A test vector of some samples: what is asked here is of the files."""
    whole = exporting.vector
    monkeypatch.setattr(exporting, "vector", lambda part, wrist, steps: whole(part, wrist, 200))


def made(gains):
    return part("pi", "flexion", WRIST, gains)


def stop_after(count, monkeypatch):
    """Writing stops as if the process were killed, after so many files."""
    done = []

    def write_some(path, content):
        if len(done) == count:
            raise KeyboardInterrupt
        done.append(path)
        path.write_text(content)

    monkeypatch.setattr(exporting, "write_atomically", write_some)


@pytest.mark.parametrize("count", range(8))
def test_an_interrupted_export_leaves_the_one_before(tmp_path, monkeypatch, count):
    out = tmp_path / "c"
    write(made(OLD), WRIST, out)
    before = {p.name: p.read_text() for p in out.iterdir()}
    stop_after(count, monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        write(made(NEW), WRIST, out)
    assert {p.name: p.read_text() for p in out.iterdir()} == before
    assert [p.name for p in tmp_path.iterdir()] == ["c"]


@pytest.mark.slow
@needs_compiler
@pytest.mark.skipif(shutil.which("make") is None, reason="no make on this machine")
@pytest.mark.parametrize("count", [1, 3, 7])
def test_in_a_folder_with_other_things_make_check_sees_it(tmp_path, monkeypatch, count):
    write(made(OLD), WRIST, tmp_path)
    (tmp_path / "main.c").write_text("mine")
    assert run("make", "check", folder=tmp_path).returncode == 0
    stop_after(count, monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        write(made(NEW), WRIST, tmp_path)
    assert run("make", "check", folder=tmp_path).returncode != 0
    monkeypatch.undo()
    write(made(NEW), WRIST, tmp_path)
    assert run("make", "check", folder=tmp_path).returncode == 0
    assert (tmp_path / "main.c").read_text() == "mine"


@needs_compiler
@pytest.mark.skipif(shutil.which("make") is None, reason="no make on this machine")
@pytest.mark.parametrize("name", ["flexion_pi.h", "flexion_pi_law.c", "flexion_pi_vector.csv", MANIFEST])
def test_a_file_of_another_export_is_seen(tmp_path, name):
    write(made(OLD), WRIST, tmp_path / "old")
    write(made(NEW), WRIST, tmp_path / "new")
    shutil.copy(tmp_path / "old" / name, tmp_path / "new" / name)
    said = run("make", "check", folder=tmp_path / "new")
    assert said.returncode != 0
    assert "two exports" in said.stdout + said.stderr


def test_a_folder_that_holds_only_an_export_is_replaced(tmp_path):
    out = tmp_path / "c"
    write(part("pi", "other", WRIST, OLD), WRIST, out)
    write(made(NEW), WRIST, out)
    assert not list(out.glob("other*"))
    assert len(list(out.iterdir())) == 8
