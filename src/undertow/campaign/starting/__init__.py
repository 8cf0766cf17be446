"""A campaign's first config, from nothing but its folder: `start` writes it with comments, and it runs as it is."""

from undertow.campaign.starting.start import Started, start

__all__ = ["Started", "start"]
