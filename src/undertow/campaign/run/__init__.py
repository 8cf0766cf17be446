"""One campaign from recordings to its run folder."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from undertow.campaign.run.course import Course, Read, read_and_condition, run

__all__ = ["Course", "Read", "read_and_condition", "run"]


def __getattr__(name: str) -> object:
    """A public name, imported when it is asked for: `inspect` checks recordings and fits nothing."""
    if name in __all__:
        from undertow.campaign.run import course

        return getattr(course, name)
    raise AttributeError(f"module 'undertow.campaign.run' has no attribute {name!r}; it has {', '.join(__all__)}")
