"""The SQL catalogue: runs, results and certificates, in SQLite or PostgreSQL."""
