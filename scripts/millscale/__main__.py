"""`python -m millscale` is the command `millscale`."""

from millscale.cli.start import main

main()
