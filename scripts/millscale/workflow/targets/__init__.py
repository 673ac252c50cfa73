"""Where jobs run: this machine or a batch system."""
