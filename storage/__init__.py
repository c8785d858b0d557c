"""Everything that is kept: the home folder, its catalogue, and the file formats."""
