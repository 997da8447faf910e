"""``python notebooks/build.py``: run each notebook from top to bottom and store it with its outputs.

The text is ``N_name.py`` (jupytext's percent format), which people edit and compare; the notebook made of
it is ``N_name.ipynb``, which is read in a viewer.  What differs from run to run or from machine to machine
(times, versions, ids drawn at random) is left out, and a notebook is written only where it has changed.
"""

import argparse
import asyncio
import base64
import io
import os
import sys
from pathlib import Path

import jupytext
import nbformat
from jupyter_client.kernelspec import KernelSpec
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError
from nbformat import NotebookNode
from PIL import Image

from plants.files import write_atomically

HERE = Path(__file__).resolve().parent
KERNEL = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}
LANGUAGE = {
    "name": "python",
    "file_extension": ".py",
    "mimetype": "text/x-python",
    "pygments_lexer": "ipython3",
}
WIDGET = "application/vnd.jupyter.widget-view+json"
NEEDS_DATA = "measured-data"
"""Tag of cells that show something only where WRIST_DATA names the measured data of others."""

COLOURS = 256
"""Colours of a stored picture."""

LONGEST = 1800
"""Seconds after which a cell is taken to hang; how fast it is, is measured elsewhere."""


class ThisInterpreter(AsyncKernelManager):
    """Starts the interpreter that runs this, whatever kernels are installed."""

    @property
    def kernel_spec(self) -> KernelSpec:
        """The kernel of this interpreter."""
        argv = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}", "--log-level=ERROR"]
        return KernelSpec(argv=argv, display_name=KERNEL["display_name"], language=KERNEL["language"])


def texts() -> list[Path]:
    """The texts of all notebooks, in order."""
    return sorted(HERE.glob("[0-9]_*.py"))


def notebook_of(text: Path) -> NotebookNode:
    """The notebook that a text is paired with, without outputs."""
    notebook = jupytext.read(text, fmt="py:percent")
    notebook.metadata = {"kernelspec": KERNEL, "language_info": LANGUAGE}
    for number, cell in enumerate(notebook.cells):
        cell["id"] = f"cell-{number:02d}"  # jupytext draws one at random
    return nbformat.from_dict(notebook)


def executed(notebook: NotebookNode) -> NotebookNode:
    """The notebook with the outputs of this run, in a kernel of its own that works in this folder.

    Raises ``nbclient.exceptions.CellExecutionError`` for the first cell that fails.
    """
    client = NotebookClient(
        notebook, kernel_manager_class=ThisInterpreter, kernel_name=KERNEL["name"], timeout=LONGEST,
        record_timing=False, coalesce_streams=True, store_widget_state=False,
        resources={"metadata": {"path": str(HERE)}},
    )  # fmt: skip
    asyncio.run(client.async_execute())
    notebook.metadata["language_info"] = LANGUAGE  # the kernel has put its version there
    for data in (o.get("data", {}) for cell in notebook.cells for o in cell.get("outputs", ())):
        if WIDGET in data:  # a view of a model that ends with its kernel
            data.clear()
            data["text/plain"] = "(a widget: it needs a running kernel)"
        if "image/png" in data:
            data["image/png"] = base64.b64encode(smaller(base64.b64decode(data["image/png"]))).decode()
    return notebook


def smaller(png: bytes) -> bytes:
    """The same picture in a palette, a third of the size, without the version of what drew it."""
    picture = Image.open(io.BytesIO(png)).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    out = io.BytesIO()
    picture.save(out, format="PNG", optimize=True)
    return out.getvalue()


def needs_data(notebook: NotebookNode) -> bool:
    """Whether some of its cells show something only where the measured data of others is at hand."""
    return any(NEEDS_DATA in cell.metadata.get("tags", ()) for cell in notebook.cells)


def content(notebook: NotebookNode) -> str:
    """The notebook as it is stored."""
    return nbformat.writes(notebook, version=4) + "\n"


def main(arguments: list[str] | None = None) -> int:
    """Make the notebooks that are named, or all."""
    parser = argparse.ArgumentParser(description="Run the notebooks and store them with their outputs.")
    parser.add_argument(
        "text", nargs="*", type=Path, help="such as notebooks/1_the_wrist.py; all if not given"
    )
    for text in parser.parse_args(arguments).text or texts():
        if not text.is_file():
            parser.error(f"{text}: no such file; one of {', '.join(t.name for t in texts())}")
        place, notebook = text.with_suffix(".ipynb"), notebook_of(text)
        if needs_data(notebook) and not os.environ.get("WRIST_DATA"):
            print(f"{place.name}: left as it is, since WRIST_DATA is not set and its real rigs would go")
            continue
        try:
            new = content(executed(notebook))
        except CellExecutionError as error:
            print(f"{text.name}: a cell failed, nothing was written; {error}", file=sys.stderr)
            return 1
        same = place.is_file() and place.read_text() == new
        if not same:
            write_atomically(place, new)
        print(f"{place.name}: {'as it was' if same else 'written'}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
