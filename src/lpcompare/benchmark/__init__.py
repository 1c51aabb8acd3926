"""Plans, cases in child processes, clocks, and the records of a run."""
