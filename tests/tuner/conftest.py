"""The tuner in a JupyterLab of its own on the loopback, looked at with Chromium."""

import json
import os
import secrets
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest

PATIENCE = 120.0
"""Seconds that anything of the lab may take on a machine that is busy with other tests."""

KERNEL_IS_READY = """() => {
    const kernel = window.jupyterapp?.shell?.currentWidget?.sessionContext?.session?.kernel;
    return kernel?.connectionStatus === "connected" && kernel?.status === "idle";
}"""

CHROMIUM = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip


def free_port() -> int:
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return int(s.getsockname()[1])


def write_notebook(path: Path, *cells: str) -> None:
    """A notebook of code cells that have not been run."""
    code = [
        {
            "cell_type": "code",
            "id": f"cell{i}",
            "metadata": {},
            "outputs": [],
            "execution_count": None,
            "source": c,
        }
        for i, c in enumerate(cells)
    ]
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    path.write_text(
        json.dumps({"cells": code, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5})
    )


@contextmanager
def jupyter_lab(folder: Path, home: Path) -> Iterator[str]:
    """JupyterLab in a folder; yields the address of a notebook but for its name.

    All that it would write elsewhere goes to `home`; it is ended, with its kernels, whatever happens.
    """
    port, token = free_port(), secrets.token_hex(16)
    own = {
        n: str(home / n.lower())
        for n in ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR")
    }
    root = Path(__file__).parents[2]
    paths = os.pathsep.join(p for p in (str(root), os.environ.get("PYTHONPATH")) if p)
    command = [
        sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root", "--ServerApp.ip=127.0.0.1",
        f"--ServerApp.port={port}", "--ServerApp.port_retries=0", f"--IdentityProvider.token={token}",
        f"--ServerApp.root_dir={folder}", "--LabApp.extension_manager=readonly",
        "--LabApp.expose_app_in_browser=True",
    ]  # fmt: skip
    address = f"http://127.0.0.1:{port}"
    log = home / "lab.log"
    settings = home / "jupyter_config_dir" / "labconfig" / "page_config.json"
    settings.parent.mkdir(parents=True)
    settings.write_text(
        json.dumps({"disabledExtensions": {"@jupyterlab/apputils-extension:announcements": True}})
    )
    with log.open("wb") as out:
        server = subprocess.Popen(
            command,
            cwd=folder,
            stdout=out,
            stderr=subprocess.STDOUT,
            env={**os.environ, **own, "PYTHONPATH": paths},
        )
        try:
            _await(f"{address}/api/status?token={token}", server, log)
            yield f"{address}/lab/tree/{{}}?token={token}"
        finally:
            _stop(server, f"{address}/api/shutdown?token={token}")


def _await(url: str, server: "subprocess.Popen[bytes]", log: Path) -> None:
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end and server.poll() is None:
        try:
            with urllib.request.urlopen(url, timeout=5):
                return
        except OSError:
            time.sleep(0.2)
    raise RuntimeError(f"JupyterLab did not start:\n{log.read_text()[-2000:]}")


def _stop(server: "subprocess.Popen[bytes]", url: str) -> None:
    """Ask it to shut down, which ends its kernels; end it where it does not."""
    try:
        with urllib.request.urlopen(urllib.request.Request(url, method="POST"), timeout=10):
            server.wait(20)
    except (OSError, subprocess.TimeoutExpired):
        server.terminate()
        try:
            server.wait(20)
        except subprocess.TimeoutExpired:
            server.kill()
            server.wait()


class Shown(NamedTuple):
    """A page that shows the tuner of a notebook, the folder of its kernel, and the errors of the console."""

    page: Any
    folder: Path
    errors: list[str]

    def settle(self) -> None:
        """Wait until it shows all that it was asked for."""
        self.page.locator(".wrist-tuner[aria-busy='false']").wait_for()


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shown]:
    """The tuner of the deviation, shown as the only cell of a notebook."""
    from playwright.sync_api import sync_playwright

    folder, home = tmp_path_factory.mktemp("notebooks"), tmp_path_factory.mktemp("home")
    write_notebook(folder / "tuner.ipynb", "from design.tuner import Tuner\nTuner('deviation')")
    errors: list[str] = []
    with jupyter_lab(folder, home) as address, sync_playwright() as play:
        browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=list(CHROMIUM))
        try:
            page = browser.new_page(viewport={"width": 1600, "height": 1100})
            page.set_default_timeout(1000 * PATIENCE)
            page.on("console", lambda m: errors.append(m.text) if m.type == "error" else None)
            page.on("pageerror", lambda e: errors.append(str(e)))
            page.goto(address.format("tuner.ipynb"))
            page.locator(".jp-Notebook .jp-CodeCell .cm-content").first.wait_for()
            page.wait_for_function(KERNEL_IS_READY)  # or JupyterLab would ask which kernel to run it with
            page.evaluate("window.jupyterapp.commands.execute('application:toggle-left-area')")
            # Not awaited: it ends only when the cell does.
            page.evaluate("void window.jupyterapp.commands.execute('notebook:run-all-cells')")
            page.locator(".wrist-tuner .steps path.response").first.wait_for()
            yield Shown(page, folder, errors)
        finally:
            browser.close()


@pytest.fixture
def put(lab: Shown) -> Callable[[str, str], None]:
    """``put(label, value)`` types a number into the field beside a slider."""

    def typed(label: str, value: str) -> None:
        lab.page.get_by_label(label).click(click_count=3)
        lab.page.keyboard.type(value)
        lab.page.keyboard.press("Enter")

    return typed


@pytest.fixture
def shown(lab: Shown, put: Callable[[str, str], None]) -> Iterator[Shown]:
    """The tuner, brought back to where it starts; the console must have said no error after the test."""
    page = lab.page
    page.get_by_role("button", name="Reset plant").click()
    put("Kp in kPa/deg", "1.2")
    put("Ki in kPa/(deg s)", "2.2")
    lab.settle()
    page.get_by_text("Every limit is held").wait_for()
    yield lab
    assert lab.errors == []
