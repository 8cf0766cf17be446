"""How much work a search may do, counted in the integrator's steps: the same on every machine.

A meter counts steps times the columns that are carried along (the motion and its derivatives). Meters stand inside one
another: what one spends, those around it spend too.

Belongs here: counting and stopping. Does not belong here: how much a search is given (comparison).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from undertow.errors import UndertowError


class BudgetError(UndertowError):
    """A search has spent what it was given. ``meter`` is the one that ran out."""

    def __init__(self, meter: Meter) -> None:
        super().__init__(
            f"a search took more than the {meter.limit:.3g} integrator steps it was given; raise discrepancy.budget"
        )
        self.meter = meter


@dataclass(eq=False)
class Meter:
    """Steps times columns that may be spent (``limit``) and were (``spent``). The one mutable object of a search."""

    limit: float
    spent: float = 0.0


_METERS: ContextVar[tuple[Meter, ...]] = ContextVar("meters", default=())


@contextmanager
def metered(limit: float) -> Iterator[Meter]:
    """A block that may spend so much. BudgetError inside it where it spends more.

    >>> with metered(10.0) as meter:
    ...     spend(4)
    >>> meter.spent
    4.0
    """
    meter = Meter(limit)
    token = _METERS.set((*_METERS.get(), meter))
    try:
        yield meter
    finally:
        _METERS.reset(token)


def spend(steps: float) -> None:
    """Count work in every meter around; BudgetError where one has run out, the outermost first."""
    for meter in _METERS.get():
        meter.spent += steps
        if meter.spent > meter.limit:
            raise BudgetError(meter)
