"""Clouds on disk in parts: streams of points, tiles, and the graph of tasks over them."""
