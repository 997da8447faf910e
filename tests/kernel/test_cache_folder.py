"""Code is loaded only from a cache folder that nobody else can have put anything into."""

import os
import subprocess
import sys

import platformdirs
import pytest

from plants.kernel import cache


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where the user's cache would be; its parent is there."""
    home = tmp_path / "wrist"
    home.mkdir(mode=0o700)
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda name: str(home))
    return home / "kernels"


def test_a_new_folder_is_the_users_alone(folder):
    assert cache.cache_folder() == folder
    assert folder.stat().st_mode & 0o777 == 0o700


def test_folders_above_it_are_made_where_there_are_none(tmp_path, monkeypatch):
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda name: str(tmp_path / "home" / "cache" / name))
    made = cache.cache_folder()
    assert made == tmp_path / "home" / "cache" / "wrist" / "kernels"
    assert made.is_dir()


def test_a_folder_that_others_may_read_is_closed_to_them(folder):
    folder.mkdir()
    folder.chmod(0o755)
    assert cache.cache_folder() == folder
    assert folder.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("which", ["folder", "parent"])
def test_a_folder_that_others_may_write_to_is_left_alone(folder, which):
    folder.mkdir(mode=0o700)
    (folder if which == "folder" else folder.parent).chmod(0o777)
    assert cache.cache_folder() != folder
    assert cache.cache_folder().stat().st_mode & 0o777 == 0o700


def test_a_link_is_left_alone(folder, tmp_path):
    (tmp_path / "elsewhere").mkdir(mode=0o700)
    folder.symlink_to(tmp_path / "elsewhere")
    assert cache.cache_folder() != folder


def test_a_file_in_its_place_is_left_alone(folder):
    folder.write_text("")
    assert cache.cache_folder().is_dir()


def test_somebody_elses_folder_is_left_alone(folder, monkeypatch):
    folder.mkdir(mode=0o700)
    owner = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: owner + 1)
    assert cache.cache_folder() != folder


def test_a_private_folder_that_is_gone_already_stops_no_process():
    cache._private.cache_clear()
    try:
        cache._private().rmdir()
        cache.remove_private()
    finally:
        cache._private.cache_clear()


@pytest.mark.slow
def test_the_private_folder_is_gone_after_the_process(tmp_path):
    (tmp_path / "wrist").mkdir()
    (tmp_path / "wrist").chmod(0o777)
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path)}
    code = (
        "from plants.kernel import cache; f = cache.cache_folder(); assert f.is_dir(); print(f);"
        "from plants.kernel.templates import module; source = module('x', 'def run():\\n    return 3\\n');"
        "assert cache.load(source)() == 3; assert list(f.glob('k*.kernel'))"
    )
    found = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    ).stdout.strip()
    assert found
    assert not os.path.exists(found)
