"""Shapes: embedded in a wheel, downloaded and checked, generated, or read from a file."""
