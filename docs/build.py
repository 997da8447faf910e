"""API pages from the docstrings: python -m docs.build writes them to build/api, to begin at index.html.

Docstrings are Markdown, in which a name in single backticks becomes a link and an indented block is shown
as it stands.
"""

import argparse
import importlib
import pkgutil
import warnings
from pathlib import Path

PACKAGES = ("plants", "design", "reports")
PLACE = Path("build/api")


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


def build(folder: Path, packages: tuple[str, ...] = PACKAGES) -> Path:
    """Write the pages of packages into a folder; the path of the first one.

    Raises RuntimeError with what pdoc warns of: a page that it cannot make whole is not handed out.
    """
    import pdoc
    import pdoc.render

    pdoc.render.configure(
        docformat="markdown",
        template_directory=Path(__file__).parent / "templates",
        footer_text="Wrist workbench, MIT licence",
    )
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        pdoc.pdoc(*(name for package in packages for name in named(package)), output_directory=folder)
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
