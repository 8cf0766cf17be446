"""The committed audit's configuration without its rivals, and with small ones."""

from __future__ import annotations

from pathlib import Path

from undertow.campaign.audit.settings import AuditConfig, load_audit

CONFIG = Path(__file__).resolve().parents[2] / "configs" / "published.yaml"


def without_audits() -> AuditConfig:
    """Checks alone."""
    return load_audit(CONFIG, ["audits=[]"])
