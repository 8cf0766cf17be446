"""The committed audit's configuration without its rivals, and its tables as the audits take them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from undertow.audit.headings import correct_units
from undertow.audit.identities import with_releases
from undertow.audit.tables import Constants, PublishedTable
from undertow.campaign.audit.settings import AuditConfig, load_audit

CONFIG = Path(__file__).resolve().parents[2] / "configs" / "published.yaml"


def without_audits() -> AuditConfig:
    """Checks alone."""
    return load_audit(CONFIG, ["audits=[]"])


def mended_tables(tables: Sequence[PublishedTable], constants: Constants) -> list[PublishedTable]:
    """Tables with units mended and releases filled in, as the audits take them."""
    return with_releases(correct_units(tables, constants)[0], constants)
