"""What every fit of a level asks of a motion again is worked out once, and kept no longer than the motion."""

from __future__ import annotations

import gc
import weakref

import pandas as pd

import undertow
from undertow.conditioning.motion import Motion, once_a_motion


def a_motion() -> Motion:
    run = undertow.simulate({"stiffness": 400.0, "viscous_damping": 2.0}, x0=0.1, mass_kg=4.0, duration_s=6.0)
    return undertow.read([pd.DataFrame({"t": run.t, "x": run.x})], units={"x": "m"})[0]


def test_it_is_done_once_for_each_motion_and_each_further_argument() -> None:
    asked = []

    @once_a_motion
    def length(motion: Motion, share: float, end: float = 1.0) -> float:
        asked.append((motion, share, end))
        return share * end * motion.t.size

    one, other = a_motion(), a_motion()
    assert length(one, 0.5) == length(one, 0.5) == 0.5 * one.t.size
    assert length(one, 0.5, end=2.0) == one.t.size
    assert length(other, 0.5) == 0.5 * other.t.size
    assert [(m is one, end) for m, _, end in asked] == [(True, 1.0), (True, 2.0), (False, 1.0)]


def test_a_motion_that_nobody_holds_is_not_kept_by_what_is_remembered_of_it() -> None:
    @once_a_motion
    def size(motion: Motion) -> int:
        return motion.t.size

    motion = a_motion()
    assert size(motion) == motion.t.size
    held = weakref.ref(motion)
    del motion
    gc.collect()
    assert held() is None
