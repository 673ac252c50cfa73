"""The report of a campaign: page, figures, pictures, ParaView files."""
