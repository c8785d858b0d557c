"""What is done: estimation, uncertainty, decisions, certificates, stations, and their stages."""

import logging

logging.getLogger("mimucal").addHandler(logging.NullHandler())  # else Python prints its warnings
