"""Finished cases as files of other programs: ParaView, OVITO, tables."""
