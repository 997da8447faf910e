"""Controllers as values: settings, a pure law compiled with the plant; `controller.py` says what one is.

A controller of your own need not stand here: `register` makes it known for as long as Python runs.
"""

from design.controllers.registry import register

__all__ = ["register"]
