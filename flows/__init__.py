"""The command line, and the Prefect flows behind it."""
