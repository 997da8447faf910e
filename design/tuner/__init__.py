"""The interactive tuner: sliders beside responses, margins and the map of the gains, for Jupyter.

    from design.tuner import Tuner

    Tuner("deviation")

What it shows is computed by plain functions (`design.tuner.picture`), which need no browser; the widget
(`design.tuner.widget`) needs anywidget and is imported when it is first asked for.
"""

from typing import Any

__all__ = ["Tuner"]


def __getattr__(name: str) -> Any:
    if name != "Tuner":
        raise AttributeError(f"module 'design.tuner' has no attribute {name!r}")
    try:
        import anywidget  # noqa: F401  (only to say so in one line where it is not)
    except ModuleNotFoundError:
        raise ImportError(
            'the tuner needs anywidget; install it: pip install "wrist-workbench[notebooks]"'
        ) from None
    from design.tuner.widget import Tuner

    return Tuner
