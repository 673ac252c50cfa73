"""Campaign files, the cases they describe, and the stages that run them."""
