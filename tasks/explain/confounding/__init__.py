"""Effects that compensate for one another: which combinations of them fit equally well."""
