"""Methods that do what rivals do on bad days."""
