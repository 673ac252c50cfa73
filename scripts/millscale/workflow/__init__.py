"""Stages and jobs of a campaign: planning, running, status, verification."""
