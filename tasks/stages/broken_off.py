"""How a run ends that neither its input nor the program is to blame for."""


class BrokenOff(Exception):  # noqa: N818 (nothing is in error)
    """The operator or the machine ended a run; the sentence says where its recording lies."""
