"""`HandOver`: what every result with an equation can write for other programs.

Belongs here: the methods and their words. Does not belong here: the texts they write (programs.py, opensees.py,
exchange.py, symbols.py).
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from undertow.equation.equation import Equation
from undertow.front.handover.exchange import json_text
from undertow.front.handover.opensees import opensees_text
from undertow.front.handover.programs import octave_text, python_text
from undertow.front.handover.symbols import SymbolicEquation, symbolic

if TYPE_CHECKING:
    from collections.abc import Mapping

REACH_M = 1.0
"""Largest displacement that a program is made for where nobody says one."""


class HandOver:
    """Methods that write an equation for other programs. Each gives the text, and writes it where a path is given.

    Programs are made for releases up to ``reach_m``: it sets their largest step where a spring hardens (and the range
    of OpenSees' tables). Friction sticks and slips in all of them; hidden states start at rest.
    """

    if TYPE_CHECKING:

        @property
        def equation(self) -> Equation:
            """The equation with its numbers."""

    def _errors(self) -> Mapping[str, float]:
        """Standard errors by term name, where the result has some."""
        return {}

    def _turns(self) -> bool:
        """Whether the trials that it was found from are rotations: units are then those of moments and inertias."""
        return getattr(getattr(self, "trials", None), "coordinate", "translation") == "rotation"

    def _reach(self, reach_m: float | None) -> float:
        own = getattr(self, "x0", None)
        return float(reach_m if reach_m is not None else abs(own) if own else REACH_M)

    def to_python(self, path: str | Path | None = None, reach_m: float | None = None) -> str:
        """A Python module that needs numpy alone: ``simulate(x0, times, v0=0.0)`` gives x and v, exact at every stick.

        >>> from undertow.front.simulation import simulate
        >>> run = simulate({"stiffness": 400.0, "coulomb_friction": 4.0}, x0=0.1, mass_kg=4.0)
        >>> scope = {}
        >>> exec(run.to_python(), scope)
        >>> x, v = scope["simulate"](0.1, run.t)
        >>> bool(abs(x - run.x).max() < 1e-6)
        True
        """
        return _written(python_text(self.equation, self._reach(reach_m)), path)

    def to_octave(self, path: str | Path | None = None, reach_m: float | None = None) -> str:
        """A function file for Octave and MATLAB: ``[x, v] = NAME(x0, times, v0)``, NAME as the file's (free_decay)."""
        name = Path(path).stem if path is not None else "free_decay"
        return _written(octave_text(self.equation, self._reach(reach_m), name), path)

    def to_opensees(self, path: str | Path | None = None, reach_m: float | None = None) -> str:
        """A Python module for OpenSeesPy: ``simulate(x0, times)`` gives x and v.

        Raises UndertowError for a term that no material of OpenSees follows (an echo, Stribeck's friction, ...).
        """
        return _written(opensees_text(self.equation, self._reach(reach_m)), path)

    def to_latex(self, path: str | Path | None = None, numbers: bool = True) -> str:
        """The equation in LaTeX, with numbers, units and standard errors, or with symbols.

        >>> from undertow.front.simulation import simulate
        >>> print(simulate({"stiffness": 400.0}, x0=0.1, mass_kg=4.0).to_latex())
        4\\,\\mathrm{kg}\\,\\ddot{x} + 400\\,\\mathrm{N/m}\\,x = 0
        """
        return _written(self.equation.to_latex(numbers, self._errors(), self._turns()), path)

    def to_sympy(self) -> SymbolicEquation:
        """The equation in SymPy: symbols, and the numbers that stand for them."""
        return symbolic(self.equation)

    def to_json(self, path: str | Path | None = None) -> str:
        """The equation as JSON: every term with its law, parameters, units and errors, in full precision.

        `undertow.front.handover.exchange.equation_from_json` reads it again.
        """
        return _written(json_text(self.equation, self._errors(), self._turns()), path)


def _written(text: str, path: str | Path | None) -> str:
    if path is not None:
        Path(path).write_text(text, encoding="utf-8")
    return text
