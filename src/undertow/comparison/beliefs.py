"""What is known of an equation's coefficients before its recordings are looked at, as values with errors.

    sum_i weight_i theta_i = value +- stderr,    theta_i = coefficient_i / mass

Belongs here: such a statement. Does not belong here: where it comes from (dry_beliefs.py) and its use (laws.py,
polish.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from undertow.errors import IdentificationError


@dataclass(frozen=True)
class Belief:
    """sum of ``weights`` (term name -> factor) times coefficients over mass = ``value`` +- ``stderr``, in SI over kg.

    Raises IdentificationError without a term, or where a number is not finite or ``stderr`` is not above 0.

    >>> Belief({"viscous_damping": 1.0}, 0.24, 0.01).value
    0.24
    """

    weights: Mapping[str, float]
    value: float
    stderr: float
    source: str = field(default="given", compare=False)

    def __post_init__(self) -> None:
        if not self.weights or not all(math.isfinite(weight) for weight in self.weights.values()):
            raise IdentificationError(f"a belief about {dict(self.weights)}; give finite weights of one term or more")
        if not math.isfinite(self.value) or not 0.0 < self.stderr < math.inf:
            raise IdentificationError(
                f"a belief about {', '.join(self.weights)} of {self.value:g} +- {self.stderr:g}; give a finite value "
                "with an error above 0"
            )
