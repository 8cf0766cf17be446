"""The configuration of a campaign: its sections, what contradicts what, what it must match."""

from undertow.campaign.config.run_config import GroupKey, RunConfig, load, look_up, schema_text, write_schema

__all__ = ["GroupKey", "RunConfig", "load", "look_up", "schema_text", "write_schema"]
