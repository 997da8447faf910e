"""The site of guides and API, searchable: python -m docs.build makes build/site, to begin at index.html.

Docstrings and guides are Markdown.  In a docstring a name in single backticks becomes a link and an indented
block is shown as it stands.  A guide goes in as the words of a module without code, so that one search finds
guides and API; the README is the first of them.
"""

import argparse
import importlib
import pkgutil
import re
import sys
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PACKAGES = ("plants", "design", "reports")
PLACE = Path("build/site")
ROOT = Path(__file__).resolve().parents[1]
GUIDES = "guides"


def named(module: str) -> list[str]:
    """What pdoc has to be told to make pages of a module and all below it: it goes no further down than
    `__all__` says, where there is one, and finds no name that is imported only when it is used."""
    found = importlib.import_module(module)
    if not hasattr(found, "__path__") or not hasattr(found, "__all__"):
        return [module]
    for name in found.__all__:
        setattr(found, name, getattr(found, name))
    below = [m.name for m in pkgutil.iter_modules(found.__path__) if m.name not in found.__all__]
    return [module, *(name for part in below for name in named(f"{module}.{part}"))]


def guide(text: str) -> str:
    """A guide for the site: links to other guides lead to their pages, those to other files of the project
    are shown as paths.

    >>> guide("see [the rig](your-own-rig.md) and [the file](../plants/rig.py)")
    'see [the rig](your_own_rig.html) and the file (`plants/rig.py`)'
    """

    def link(found: re.Match[str]) -> str:
        words, to = found.groups()
        name, _, anchor = to.partition("#")
        if to.startswith(("http", "#")):
            return found.group(0)
        if name.endswith(".md") and (ROOT / "docs" / Path(name).name).is_file():
            return f"[{words}]({_module(Path(name))}.html{'#' + anchor if anchor else ''})"
        return f"{words} (`{name.removeprefix('../')}`)"

    return re.sub(r"(?<!!)\[([^\]]+)\]\(([^)]+)\)", link, re.sub(r"<img [^>]*>", "", text))


def _module(path: Path) -> str:
    """The name of the module that a guide becomes."""
    return path.stem.replace("-", "_")


@contextmanager
def guides() -> Iterator[str]:
    """The package of the guides, importable while the site is made."""
    with tempfile.TemporaryDirectory() as place:
        package = Path(place) / GUIDES
        package.mkdir()
        texts = {"__init__": ROOT / "README.md"}
        texts |= {_module(p): p for p in sorted((ROOT / "docs").glob("*.md"))}
        for name, path in texts.items():
            words = guide(path.read_text(encoding="utf-8"))
            if name == "__init__":  # its links lead down into the package
                words = re.sub(r"\]\((\w+)\.html", rf"]({GUIDES}/\1.html", words)
            (package / f"{name}.py").write_text(f"__doc__ = {words!r}\n", encoding="utf-8")
        sys.path.insert(0, place)
        try:
            yield GUIDES
        finally:
            sys.path.remove(place)
            for name in [n for n in sys.modules if n == GUIDES or n.startswith(f"{GUIDES}.")]:
                del sys.modules[name]


def build(folder: Path, packages: tuple[str, ...] = PACKAGES) -> Path:
    """Write the guides and the pages of packages into a folder; the path of the first one.

    Raises RuntimeError with what pdoc warns of: a page that it cannot make whole is not handed out.
    """
    import pdoc
    import pdoc.render

    pdoc.render.configure(
        docformat="markdown",
        template_directory=Path(__file__).parent / "templates",
        footer_text="Wrist workbench, MIT licence",
    )
    with warnings.catch_warnings(record=True) as caught, guides() as written:
        warnings.simplefilter("always")
        names = (written, *(name for package in packages for name in named(package)))
        pdoc.pdoc(*names, output_directory=folder)
    said = [str(w.message) for w in caught if "pdoc" in w.filename]
    if said:
        raise RuntimeError("pdoc warns: " + "; ".join(said))
    return folder / "index.html"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m docs.build", description=__doc__)
    parser.add_argument("--out", type=Path, default=PLACE, help="folder of the pages")
    print(f"pages in {build(parser.parse_args().out)}")


if __name__ == "__main__":
    main()
