"""Runs the migrations on the connection that storage.catalog gives, in its transaction."""

from alembic import context

from storage.catalog_tables import metadata

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=metadata,
    transactional_ddl=True,
)
with context.begin_transaction():
    context.run_migrations()
