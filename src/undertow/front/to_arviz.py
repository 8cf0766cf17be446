"""Posterior draws as ArviZ's InferenceData.

Belongs here: that shape. Does not belong here: the draws (uncertainty/posterior.py).
"""

from __future__ import annotations

import importlib
from typing import Any

from undertow.errors import UndertowError


def to_arviz(found: Any, draws: int, seed: int, chains: int) -> Any:
    """``chains`` times ``draws`` draws of a fit's parameters; UndertowError where ArviZ is not installed."""
    if chains < 1:
        raise UndertowError(f"chains is {chains}; give at least 1")
    try:
        arviz = importlib.import_module("arviz")
    except ImportError as error:
        raise UndertowError(
            f"to_arviz needs ArviZ, which is not installed ({error}); run: pip install 'undertow[arviz]'"
        ) from error
    sampled = found.posterior(chains * draws, seed)
    groups = {"posterior": {name: values.reshape(chains, draws) for name, values in sampled.values.items()}}
    try:
        made = arviz.from_dict(**groups)
    except TypeError:  # from version 1 on the groups are one mapping
        made = arviz.from_dict(groups)
    made["posterior"].attrs.update(
        {"inference_library": "undertow", "effective_draws": sampled.effective, "outcome": sampled.outcome}
    )
    return made
