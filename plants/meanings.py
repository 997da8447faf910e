"""Unit and meaning of what states remember, told beside each state, for whoever takes a law to a target."""

from collections.abc import Callable
from typing import TypeVar

MEANINGS: dict[tuple[type, str], tuple[str, str]] = {}
"""Unit and meaning by state and field."""

_State = TypeVar("_State", bound=type)


def remembers(**fields: tuple[str, str]) -> Callable[[_State], _State]:
    """Decorator of a state: unit and meaning of its fields, which exported code gives by name."""

    def told(state: _State) -> _State:
        MEANINGS.update({(state, name): known for name, known in fields.items()})
        return state

    return told
