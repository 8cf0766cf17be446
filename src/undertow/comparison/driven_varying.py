"""Whether offset and friction of a driven body vary from stroke to stroke, proved on samples that nobody fitted.

Belongs here: that decision. Does not belong here: the fit (methods/driven_strokes.py), which laws an equation lacks
(driven_search.py).
"""

from __future__ import annotations

from collections.abc import Sequence

from undertow.comparison.driven_folds import CLOSER, validation_rms
from undertow.conditioning.driven import DrivenTrial
from undertow.errors import IdentificationError
from undertow.methods.driven import DrivenFit
from undertow.methods.driven_strokes import vary_by_stroke

Parts = tuple[Sequence[DrivenTrial], Sequence[DrivenTrial], Sequence[DrivenTrial]]
"""All trials, what of them was fitted while laws were sought, and what was not."""


def by_stroke(whole: DrivenFit, parts: Parts, trained: DrivenFit, lowest: float) -> tuple[DrivenFit, float]:
    """The fit to all trials with deviations by stroke, and its rms on unseen samples, where both the part that was
    ``trained`` on and all trials ask for them, and the free run over unseen samples comes no further away than
    `CLOSER`; else ``whole`` and ``lowest`` as they are."""
    trials, training, unseen = parts
    try:
        after = validation_rms(unseen, vary_by_stroke(training, trained))
        if after > (1.0 + CLOSER) * lowest:
            return whole, lowest
        return vary_by_stroke(trials, whole), after
    except IdentificationError:
        return whole, lowest
