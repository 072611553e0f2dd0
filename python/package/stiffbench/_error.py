"""The one exception of the package."""

import json


class StiffbenchError(Exception):
    """A failure of stiffbench; `stiffbench explain CODE` prints what its code means.

    Attributes
    ----------
    code : str
        Stable name, such as "stiffbench::readings::empty".
    message : str
        What is wrong, and where.
    help : str or None
        What to do.
    exit_code : int
        Exit code of the command that fails so.
    warnings : list of str
        What to know besides.
    """

    def __init__(self, message, *, code="", help=None, exit_code=70, warnings=()):
        super().__init__(message)
        self.message = message
        self.code = code
        self.help = help
        self.exit_code = exit_code
        self.warnings = list(warnings)

    def __str__(self):
        return f"{self.message}\nhelp: {self.help}" if self.help else self.message

    def __reduce__(self):
        return (_made, (self.message, self.code, self.help, self.exit_code, self.warnings))


def _made(message, code, help, exit_code, warnings):
    return StiffbenchError(message, code=code, help=help, exit_code=exit_code, warnings=warnings)


def from_json(text):
    """The exception of the object that the program prints with --json."""
    result = json.loads(text)
    error = result["error"]
    return _made(error["message"], error["code"], error["help"], error["exit_code"], result["warnings"])
