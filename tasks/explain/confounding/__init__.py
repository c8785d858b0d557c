"""Effects that make up for each other: which combination of them fits, and which might as well."""
