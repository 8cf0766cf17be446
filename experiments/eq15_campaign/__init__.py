"""The Eq. 15 campaign: Eq. 15 of the flume report integrated exactly and seen through ordinary sensors.

Nothing here imports the package that reads the campaign, so that an error in one is not an error in both.
"""
