"""An equation handed over to other programs: Python, Octave (MATLAB), OpenSees, SymPy, LaTeX, JSON."""

from undertow.front.handover.hand_over import HandOver

__all__ = ["HandOver"]
