"""Campaign files: their keys, reading and checking, values in SI."""
