"""One file per metric: a function of the file's name, and the columns that it fills."""
