## The Digital Calibration Certificate: what only a machine-readable certificate says.

dcc-record = Record from which this certificate was made
