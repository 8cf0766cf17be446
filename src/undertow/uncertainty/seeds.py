"""Random numbers from a seed that a user gives.

Belongs here: the check of that seed. Does not belong here: what is drawn (posterior.py, front/prediction.py).
"""

from __future__ import annotations

from numbers import Integral
from typing import Any

import numpy as np

from undertow.errors import UndertowError, shown


def random_numbers(seed: Any, name: str = "seed") -> np.random.Generator:
    """numpy's generator begun with a seed, an integer from 0 on; UndertowError for anything else.

    >>> round(float(random_numbers(0).random()), 3)
    0.637
    """
    must_be_seed(seed, name)
    return np.random.default_rng(seed)


def must_be_seed(seed: Any, name: str = "seed") -> None:
    """UndertowError where a seed is no integer from 0 on."""
    if not isinstance(seed, Integral) or isinstance(seed, bool) or seed < 0:
        raise UndertowError(f"{name} is {shown(seed)}; give an integer from 0 on, as 0")
