"""What a start waits for: code is compiled only where something needs it."""

from __future__ import annotations

import subprocess
import sys

import pytest

DECAYS = "undertow.cli, undertow.campaign.run.folder, undertow.discrepancy.judge"


@pytest.mark.parametrize(
    ("code", "there"),
    [
        (f"import {DECAYS}", False),
        (f"import {DECAYS}; from undertow.equation.driven import compiled_integrator; compiled_integrator()", True),
    ],
    ids=["decays", "a driven body"],
)
def test_no_campaign_of_decays_waits_for_the_integrator_of_driven_bodies(code: str, there: bool) -> None:
    asked = f"{code}; import sys; print('undertow.equation.driven_kernel' in sys.modules)"
    said = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == str(there)
