"""What the unit went through, from the table's encoders."""
