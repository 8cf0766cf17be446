"""undertow: the equation of motion behind free-decay recordings, and the physics that a model leaves out."""

from __future__ import annotations

__version__ = "0.1.0"
