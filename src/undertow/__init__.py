"""undertow: the equation of motion behind free-decay recordings, and the physics that a model leaves out.

`read`, `load`: recordings as `Trials`. `fit`, `fit_driven`: an equation's numbers. `Discover`: which terms it has.
`diagnose`: what it leaves out. `simulate`, `predict`: where it takes the body. `frequency_response`, `fit_response`:
the same under a harmonic force. `open`: a finished run.
docs/python_front.md shows them.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from undertow.errors import UndertowError

if TYPE_CHECKING:
    from undertow.front.diagnosing import diagnose
    from undertow.front.discovering import Discover
    from undertow.front.driving import fit_driven
    from undertow.front.fitting import fit
    from undertow.front.opening import open_run as open
    from undertow.front.prediction import predict
    from undertow.front.reading import load, read
    from undertow.front.response import fit_response, frequency_response
    from undertow.front.simulation import simulate
    from undertow.front.trials import Trials

__version__ = "0.1.0"
__all__ = [
    "Discover", "Trials", "UndertowError", "__version__", "diagnose", "fit", "fit_driven", "fit_response",
    "frequency_response", "load", "open", "predict", "read", "simulate",
]  # fmt: skip

_HOMES = {
    "Discover": ("discovering", "Discover"),
    "Trials": ("trials", "Trials"),
    "diagnose": ("diagnosing", "diagnose"),
    "fit": ("fitting", "fit"),
    "fit_driven": ("driving", "fit_driven"),
    "fit_response": ("response", "fit_response"),
    "frequency_response": ("response", "frequency_response"),
    "load": ("reading", "load"),
    "open": ("opening", "open_run"),
    "predict": ("prediction", "predict"),
    "read": ("reading", "read"),
    "simulate": ("simulation", "simulate"),
}
"""Public name -> module of the front and name there: imported when asked for, since numba and pysindy cost seconds."""


def __getattr__(name: str) -> object:
    """A public name, imported when it is asked for."""
    if name in _HOMES:
        module, own = _HOMES[name]
        return getattr(import_module(f"undertow.front.{module}"), own)
    raise AttributeError(f"module 'undertow' has no attribute {name!r}; it has {', '.join(__all__)}")


def __dir__() -> list[str]:
    """Public names, for completion."""
    return sorted(__all__)
