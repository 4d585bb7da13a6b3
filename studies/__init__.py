"""What reproduces the papers and judges the models: tables, experiments, stability, and the figures of reports."""
