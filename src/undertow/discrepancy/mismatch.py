"""What a mismatch between a simulation and a recording is: one trial's residual, measured.

Belongs here: the frozen `Mismatch`. Does not belong here: how it is located (locate.py) or explained.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Mismatch:
    """Free-run residual of one trial against its group's baseline equation.

    ``nrmse`` is RMS error over RMS displacement in the motion window; ``sensor_floor_nrmse`` what the sensors alone
    give; ``repeatability_nrmse`` the 95 % quantile when k, c, mu vary from trial to trial. Shares are fractions of the
    residual's variance above noise: by third of the window, in its strongest line that is not the body's own, in a
    function of (x, v) alone, in memory of the motion, in a clock of its own; nan where not computed.
    """

    trial: str
    nrmse: float
    sensor_floor_nrmse: float
    repeatability_nrmse: float
    share_early: float = math.nan
    share_middle: float = math.nan
    share_late: float = math.nan
    line_frequency_hz: float = math.nan
    line_share: float = math.nan
    amplitude_exponent: float = math.nan
    static_share: float = math.nan
    memory_share: float = math.nan
    clock_share: float = math.nan

    @property
    def missing(self) -> bool:
        """Whether the equation leaves out something that scatter from trial to trial would not make."""
        return self.nrmse > self.repeatability_nrmse
