"""A damaged kernel cache costs a compilation; nothing that somebody else has put there is run."""

import hashlib
import os
import pickle
import subprocess
import sys
from pathlib import Path

import platformdirs
import pytest

from plants.errors import InputError, InputWarning
from plants.kernel import cache
from plants.kernel.templates import module

SOURCE = module("a test", "def run(x):\n    return 2.0 * x + 1.0\n")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A cache folder of one's own with a kernel in it."""
    (tmp_path / "wrist").mkdir(mode=0o700)
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda name: str(tmp_path / name))
    assert cache.load(SOURCE)(1.0) == 3.0
    (tmp_path / "wrist" / "kernels").chmod(0o700)
    return tmp_path / "wrist" / "kernels"


def entry(folder: Path) -> Path:
    (found,) = folder.glob("*.kernel")
    return found


def truncated(path):
    path.write_bytes(path.read_bytes()[:100])


def emptied(path):
    path.write_bytes(b"")


def flipped_in(byte):
    def flip(path):
        content = bytearray(path.read_bytes())
        content[byte] ^= 4
        path.write_bytes(bytes(content))

    return flip


def other(path):
    path.write_bytes(b"no pickle at all" * 50)


def folder_in_its_place(path):
    path.unlink()
    path.mkdir()
    (path / "x").write_text("")


def broken_link(path):
    path.unlink()
    path.symlink_to(path.parent / "nowhere")


DAMAGE = {
    "truncated": truncated,
    "empty": emptied,
    "flipped at the start": flipped_in(0),
    "flipped": flipped_in(777),
    "flipped at the end": flipped_in(-1),
    "something else": other,
    "folder": folder_in_its_place,
    "broken link": broken_link,
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=list(DAMAGE))
def test_a_damaged_entry_is_dropped_and_made_anew(folder, damage):
    path = entry(folder)
    damage(path)
    assert cache.load(SOURCE)(2.0) == 5.0
    assert path.is_file()
    content = path.read_bytes()
    assert hashlib.sha256(content[32:]).digest() == content[:32]


def test_a_whole_entry_is_taken(folder, monkeypatch):
    written = []
    monkeypatch.setattr(cache, "write_atomically", lambda *a: written.append(a))
    assert cache.load(SOURCE)(2.0) == 5.0
    assert written == []


def test_a_full_disk_is_told_once_and_compiled_in_memory(folder, monkeypatch):
    def full(path, content):
        raise InputError(f"{path}: cannot be written (No space left on device); choose another place")

    entry(folder).unlink()
    cache._say_once.cache_clear()
    monkeypatch.setattr(cache, "write_atomically", full)
    with pytest.warns(InputWarning, match="No space left") as told:
        found = [cache.load(SOURCE)(x) for x in (2.0, 3.0)]
    assert found == [5.0, 7.0]
    assert len(told) == 1


def test_no_place_at_all_is_told_and_compiled_in_memory(monkeypatch):
    cache._say_once.cache_clear()
    monkeypatch.setattr(cache, "cache_folder", lambda: None)
    with pytest.warns(InputWarning, match="compiled anew"):
        assert cache.load(SOURCE)(2.0) == 5.0


class Evil:
    def __reduce__(self):
        return os.system, ("touch $EVIL",)


@pytest.mark.slow
def test_a_pickle_that_others_have_put_there_is_not_run(tmp_path):
    """In a folder that others may write, and in one that numba's own variable names."""
    home, evil = tmp_path / "wrist" / "kernels", tmp_path / "evil"
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path), "EVIL": str(evil)}
    code = (
        "from plants.kernel import cache; from plants.kernel.templates import module;"
        "print(cache.load(module('x', 'def run(x):\\n    return x + 1.0\\n'))(1.0))"
    )

    def run():
        return subprocess.run(
            [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
        ).stdout

    assert run() == "2.0\n"
    crafted = pickle.dumps(Evil())
    environment["NUMBA_CACHE_DIR"] = str(home)
    for name in [p.stem for p in home.glob("*.kernel")]:
        for ending in (".kernel", ".nbi", ".1.nbc"):
            (home / f"{name}{ending}").write_bytes(crafted)
    home.chmod(0o777)
    assert run() == "2.0\n"
    assert not evil.exists()
