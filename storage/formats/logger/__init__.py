"""Tables as loggers write them: csv, tsv, xlsx, parquet; with a protocol of what was done when."""
