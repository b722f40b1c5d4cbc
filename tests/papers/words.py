# SPDX-License-Identifier: Apache-2.0
"""Words of claims and captions against the numbers of the checks."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mehvar.base.manifest import Manifest
    from mehvar.reproduction.claims import Claim, ClaimText
    from mehvar.reproduction.paper import Reproduction
    from mehvar.reproduction.runs import Runs

_LIST = r"(?:(?: |,|to|and|or|-)+\(?\d+\)?(?![\w.]\d))*"
_PLACES = re.compile(
    r"\b(?:claims?|decision|sections?|diagrams?|drawings?|figures?|tables?|equations?|scenario),? \(?\d+\)?" + _LIST
    + r"|\(\d+\)(?:" + _LIST + r")", re.IGNORECASE,
)  # fmt: skip
"""References to numbered items, which are not quantities: "claims 8 to 10 and 14", "(31), (32) and (34)"."""
_NUMBER = re.compile(r"(?<![\w.^])(?<!\^-)\d+(?: \d{3})*(?:\.\d+)?(?:e[+-]?\d+)?(?![\w^]|\.\d)")
_FEW = 3
"""Largest count that also occurs in ordinary text: one of two laws, degree 2."""


def numbers(text: str) -> list[str]:
    """Return the numbers in a text, as written, without references to numbered items."""
    return [number.replace(" ", "") for number in _NUMBER.findall(_PLACES.sub(" ", text))]


def without_source(text: str, known: Iterable[float]) -> list[str]:
    """Return the numbers of a text that match no known number after rounding, also in percent."""
    values = [abs(value) * factor for value in known for factor in (1.0, 100.0) if math.isfinite(value)]
    return [n for n in numbers(text) if float(n) > _FEW or "." in n or "e" in n if not any(_same(n, v) for v in values)]


def _same(written: str, value: float) -> bool:
    """Return True if a value, rounded to the written digits, equals the written number."""
    number, (mantissa, _, exponent) = float(written), written.partition("e")
    digits = len(mantissa.partition(".")[2])
    if number >= 1000:
        digits = min(digits, len(mantissa.rstrip("0")) - len(mantissa))  # zeros that only make up the length
    return math.isclose(value, number, rel_tol=1e-9, abs_tol=0.5001 * 10.0 ** (int(exponent or 0) - digits))


def of_claim(claim: Claim, text: ClaimText | None = None) -> Iterator[float]:
    """Yield the numbers of a claim: of its checks, also under readings, and the expected numbers."""
    for check in (*claim.checks, *(check for reading in claim.readings for check in reading.checks)):
        for part in (check.what, check.expected, check.measured):
            yield from map(float, numbers(part))
    for reading in claim.readings:
        yield from map(float, numbers(f"{reading.name} {reading.text}"))
    if text is not None:
        yield from text.expected.values()


def wrong_words(paper: Reproduction, claims: Iterable[Claim], manifest: Manifest) -> Iterator[str]:
    """Yield the numbers in a paper's claims and captions that no check uses.

    A claim may have those of its own checks and of a claim that it names, a caption those of its figure's claims, the
    page on how the paper was read those of all claims; each the model's.
    """
    texts, model = {text.number: text for text in paper.texts}, list(of_model(manifest))
    by_number = {claim.number: list(of_claim(claim, texts.get(claim.number))) for claim in claims}

    def foreign(place: str, words: str, of: Iterable[str]) -> Iterator[str]:
        known = [*model, *(value for number in of for value in by_number[number])]
        yield from (f"{place}: {number}" for number in without_source(words, known))

    for text in paper.texts:
        words = f"{text.text} {text.explanation}"
        yield from foreign(f"claim {text.number}", words, (text.number, *re.findall(r"claim (\d+)", words)))
    for figure in paper.figures:
        yield from foreign(f"figure {figure.number}", f"{figure.title} {figure.caption}", figure.claims)
    for words in paper.captions.readings:
        yield from foreign(words, words, by_number)


def of_model(manifest: Manifest) -> Iterator[float]:
    """Yield the defaults of a model, of its laws, and the values of its scenarios."""
    laws = [q for law in manifest.controllers.values() for q in law.parameters]
    for quantity in (*manifest.parameters, *manifest.scenario_parameters, *laws):
        if quantity.default is not None:
            yield float(quantity.default)
    for scenario in manifest.scenarios.values():
        yield from (float(value) for value in scenario.values.values())


def silent(paper: Reproduction, runs: Runs) -> Iterator[str]:
    """Yield the expected numbers that can change without changing the words of a check."""
    for text in paper.texts:
        before = _words(paper, text, text.expected, runs)
        for name, value in text.expected.items():
            changed = 7.0 if value == 0 or math.isinf(value) else 1.37 * value
            if _words(paper, text, {**text.expected, name: changed}, runs) == before:
                yield f"{text.number}: {name}"


def _words(paper: Reproduction, text: ClaimText, expected: Mapping[str, float], runs: Runs) -> list[str]:
    functions = (paper.checks[text.number], *paper.readings.get(text.number, {}).values())
    every = [check for checks in functions for check in checks(runs, expected.__getitem__)]
    return [f"{check.what}: {check.expected}: {check.measured}" for check in every]
