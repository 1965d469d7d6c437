"""What can go wrong. Every error says what to do about it, and where it is as far as that is known."""

from __future__ import annotations


class FosError(Exception):
    """An error of fos.

    Attributes:
        message: What is wrong.
        remedy: What to do about it; None where that is not known.
        file: The file that it is about, as it was given.
        line: Its line, from 1; of a table without lines its row.
        column: Name of the column of a log, or number of the character in a line of another file.
    """

    def __init__(
        self,
        message: str,
        *,
        remedy: str | None = None,
        file: str | None = None,
        line: int | None = None,
        column: str | None = None,
    ) -> None:
        super().__init__(message)
        self.message = message
        self.remedy = remedy
        self.file = file
        self.line = line
        self.column = column

    def __str__(self) -> str:
        return self.message if self.remedy is None else f"{self.message}\nhelp: {self.remedy}"

    def __reduce__(self) -> tuple[object, ...]:
        return (_again, (type(self), self.message, self.remedy, self.file, self.line, self.column))


def _again(
    kind: type[FosError], message: str, remedy: str | None, file: str | None, line: int | None, column: str | None
) -> FosError:
    return kind(message, remedy=remedy, file=file, line=line, column=column)


class FileError(FosError, OSError):
    """A file that cannot be read or written."""


class RecordingError(FosError, ValueError):
    """A log that cannot be read or used, or a column that it does not have."""


class FitError(FosError, ValueError):
    """An axis that cannot be fitted, or an option that no fit takes."""


class CompareError(FosError, ValueError):
    """A model that cannot be compared with a log."""


class DiagnoseError(FosError, ValueError):
    """A log that cannot be diagnosed."""


class EffectError(FosError, ValueError):
    """An effect that is not known, or a file that is no effect."""


class RefineError(FosError, ValueError):
    """An effect that cannot be added or taken back."""


class StudyError(FosError, ValueError):
    """A study that cannot be read, written, or asked for what it is asked."""


class NoiseError(FosError, ValueError):
    """A log that does not tell its noise."""


class CalibrateError(FosError, ValueError):
    """A log that gives no calibration, or values that none can be applied to."""


class FleetError(FosError, ValueError):
    """Rows of units that are no fleet, or a regressor that cannot be read."""


class ImageError(FosError, ValueError):
    """An image that cannot be written or run."""


class PredictorError(FosError, ValueError):
    """Samples that do not fit the model."""


class RegressorError(FosError, ValueError):
    """Data that the regressor cannot be fitted to or predict from."""


class SimulationError(FosError, ValueError):
    """A plan that cannot be simulated."""


class InternalError(FosError):
    """A defect of fos itself."""


class FosWarning(UserWarning):
    """Something that makes a result less sure than it looks."""
