"""Speed against error over settings of a campaign: `millscale study`."""
