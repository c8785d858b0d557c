"""Every parameter that `explain` states of a real recording, beside its value by hand."""
