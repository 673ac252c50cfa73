"""Parameter studies: speed against error over settings of a campaign."""
