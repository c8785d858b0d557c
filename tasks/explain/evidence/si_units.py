"""SI equivalents of the units that the standards print."""

from tasks.model.term import Parameter

SI_UNITS = (("arcsec", "rad"), ("deg", "rad"), ("mT", "T"), ("/g", "/(m/s2)"))


def unit_of(parameter: Parameter) -> str:
    """In which a parameter's value is known to the model."""
    return parameter.unit if parameter.factor == 1.0 else si_unit(parameter.unit)


def si_unit(printed: str) -> str:
    """The SI unit of what is printed in a unit of the standard."""
    for shown, si in SI_UNITS:
        printed = printed.replace(shown, si)
    return printed
