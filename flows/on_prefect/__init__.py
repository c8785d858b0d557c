"""The line on a Prefect server: flows, deployments, queues, and what survives a lost part."""
