"""What dry trials say of wet ones, as beliefs.

The body's own damping is the same in water, where it hides behind drag. The mass is not the same, so that what carries
over is the ratio to the stiffness.

Belongs here: that step. Does not belong here: fitting dry trials (structure.py) or a campaign's own dry parameters
(dry.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from undertow.comparison.beliefs import Belief
from undertow.comparison.structure import FoundStructure
from undertow.errors import IdentificationError


def from_dry(
    dry: FoundStructure, names: Sequence[str] = ("viscous_damping",), factors: Mapping[str, float] | None = None
) -> tuple[Belief, ...]:
    """What a structure of dry trials says of wet ones on the same spring: coefficients ``names`` over the stiffness.

    theta_i / theta_k is c / k, F / k and so on, whatever the mass. ``factors`` multiply a ratio where the force itself
    differs by a known factor, as friction does by buoyancy: N wet / N dry. Errors and correlations are the dry fit's;
    they are taken at the dry mass, which makes them too wide in water by the added mass, never too narrow.

    Raises IdentificationError for a term that the dry structure does not hold, or without a stiffness.
    """
    have = [term.name for term in dry.terms]
    missing = [name for name in ("stiffness", *names) if name not in have]
    if missing:
        raise IdentificationError(
            f"the dry structure holds {', '.join(have)} and not {', '.join(missing)}; name terms that it holds"
        )
    places = [have.index(name) for name in names]
    k = have.index("stiffness")
    scale = np.array([(factors or {}).get(name, 1.0) for name in names])
    ratios = scale * dry.coefficients[places] / dry.coefficients[k]
    slopes = np.zeros((len(names), len(have)))
    slopes[range(len(names)), places] = scale
    slopes[:, k] -= ratios
    # theta_i - ratio theta_k has this covariance; whitened, every statement stands for itself
    covariance = slopes @ dry.covariance[: len(have), : len(have)] @ slopes.T
    size = np.sqrt(np.diag(covariance))
    white = np.linalg.inv(np.linalg.cholesky(covariance / np.outer(size, size))) / size
    source = f"dry trials {', '.join(dry.trials)}"
    return tuple(
        Belief({**dict(zip(names, row.tolist(), strict=True)), "stiffness": float(-row @ ratios)}, 0.0, 1.0, source)
        for row in white
    )
