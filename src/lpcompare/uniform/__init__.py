"""What the paper wished for: cells, swaps against plane error, and the program with one point per cell."""
