"""The file contract of a runs folder, which the campaign and the analysis share."""
