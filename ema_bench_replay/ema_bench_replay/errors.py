"""The one exception for input that cannot be used."""


class InputError(ValueError):
    """Input refused. Its text is one line, `FILE: place: what is wrong; what to do`.

    The command line prints it and ends with status 2.
    """
