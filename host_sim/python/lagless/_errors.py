"""Errors, with the text of the program."""


class Error(ValueError):
    """A setting, a scenario or a name was refused; the text names it and the accepted values.

    `name` is the row or key with the error, "" if there is none; `line` and `column` are the place in the text of a scenario,
    0 if the error is not in such a text."""

    def __init__(self, text, name="", line=0, column=0):
        super().__init__(text)
        self.name, self.line, self.column = name, line, column

    def __reduce__(self):
        return Error, (str(self), self.name, self.line, self.column)
