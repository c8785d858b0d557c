"""Every claim that `explain` makes on a real recording: right, wrong, or not known by hand."""
