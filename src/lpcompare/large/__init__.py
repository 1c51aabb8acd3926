"""Clouds larger than memory: files are read in blocks, spilled into tiles, thinned tile by tile, and written."""
