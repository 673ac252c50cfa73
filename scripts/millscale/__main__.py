"""`python -m millscale` is the command `millscale`."""

from millscale.cli.main import main

main()
