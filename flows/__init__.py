"""What is ordered: the command line and the Prefect flows behind it."""
