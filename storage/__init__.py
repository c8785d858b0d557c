"""What is kept: the home folder, the catalogue of what is in it, and the file formats."""
