"""Old name of `plants.kernel.pytrees`, until all who import it have moved."""

from plants.kernel.pytrees import leaves, like, names, places

__all__ = ["leaves", "like", "names", "places"]
