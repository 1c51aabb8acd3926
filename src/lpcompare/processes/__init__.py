"""Child processes: limits, the guard that ends what they leave, and the process that they are forked from."""
