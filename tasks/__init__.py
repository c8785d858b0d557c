"""What is done: estimation, uncertainty, decisions, certificates, stations, and their stages."""
