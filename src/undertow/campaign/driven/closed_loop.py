"""What an instrument says of a driven campaign's numbers: values for verdict.json, rows for the page, words.

Belongs here: these three, for every trial that has an instrument. Does not belong here: the estimate
(methods/driven_instrument.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from undertow.conditioning.driven import DrivenTrial
from undertow.errors import IdentificationError
from undertow.methods.driven import DrivenFit
from undertow.methods.driven_instrument import BesideInstrument, beside_instrument


@dataclass(frozen=True)
class ByInstruments:
    """Comparisons of the trials that have an instrument, and trial -> reason where none could be made."""

    compared: tuple[BesideInstrument, ...] = ()
    reasons: Mapping[str, str] | None = None

    @property
    def sentences(self) -> str:
        """What is to be said, each with a space before it; empty where nothing is."""
        said = [one.sentence for one in self.compared if one.sentence]
        return "".join(f" {one[0].upper()}{one[1:]}." for one in said)

    def plain(self) -> list[Mapping[str, Any]]:
        """Values for verdict.json: a trial each."""
        out: list[Mapping[str, Any]] = []
        for one in self.compared:
            numbers = {
                name: {
                    "output_error": one.output_error[name].value, "output_error_stderr": one.output_error[name].stderr,
                    "instrument": found.value, "instrument_stderr": found.stderr, "unit": found.unit,
                    "standard_errors_apart": one.apart[name],
                }
                for name, found in one.instrument.items()
            }  # fmt: skip
            out.append({"trial": one.trial, "share_of_velocity": one.strength, "numbers": numbers, "because": ""})
        out += [
            {"trial": name, "share_of_velocity": None, "numbers": {}, "because": reason}
            for name, reason in (self.reasons or {}).items()
        ]
        return out

    def table(self) -> list[tuple[str, ...]]:
        """Rows of the page, the first the header; empty where nothing was compared."""
        rows = [
            (one.trial, name, str(one.output_error[name]), str(found), f"{one.apart[name]:.2g}")
            for one in self.compared for name, found in one.instrument.items()
        ]  # fmt: skip
        rows += [(name, "", "", reason, "") for name, reason in (self.reasons or {}).items()]
        header = ("trial", "number", "output error", "by the instrument", "standard errors apart")
        return [header, *rows] if rows else []


def by_instruments(trials: Sequence[DrivenTrial], fitted: DrivenFit) -> ByInstruments:
    """Every trial that has an instrument compared, or the reason why not."""
    compared, reasons = list[BesideInstrument](), dict[str, str]()
    for trial in trials:
        if trial.instrument is None:
            continue
        try:
            compared.append(beside_instrument(trial, fitted))
        except IdentificationError as reason:
            reasons[trial.name] = str(reason)
    return ByInstruments(tuple(compared), reasons)
