"""One campaign from recordings to its run folder."""

from undertow.campaign.run.course import Course, Read, read_and_condition, run

__all__ = ["Course", "Read", "read_and_condition", "run"]
