"""undertow: the equation of motion behind free-decay recordings, and the physics that a model leaves out."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from undertow.comparison.discover import Discover

__version__ = "0.1.0"
__all__ = ["Discover", "__version__"]


def __getattr__(name: str) -> object:
    """`Discover`, imported when it is asked for: it brings numba and pysindy along, which cost a second."""
    if name == "Discover":
        from undertow.comparison.discover import Discover

        return Discover
    raise AttributeError(f"module 'undertow' has no attribute {name!r}; it has {', '.join(__all__)}")
