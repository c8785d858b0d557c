"""`explain` on recordings of the program's own virtual station, whose physics is another hand's."""
