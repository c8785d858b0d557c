"""Many processes that issue certificates at once, and processes killed while they issue."""
