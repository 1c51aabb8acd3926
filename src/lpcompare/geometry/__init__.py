"""Numerics on points, shared by the method, the metrics and the baselines."""
