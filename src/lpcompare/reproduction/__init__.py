"""The paper of 2017 made again: its tables, its figures, and an audit of its statements."""
