"""Cases of a campaign: similarity law, time step, decks and their parameters, predicted cost."""
