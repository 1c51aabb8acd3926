"""Tables, figures and pages drawn from a finished run."""
