"""The motion of the unit, from the table's encoders, tracked poses or labels."""
