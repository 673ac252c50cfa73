"""The file contract of a runs folder: layout, safe readers, digests, lock."""
