# SPDX-License-Identifier: Apache-2.0
"""Costs of edits. The cheapest edit that explains a difference is reported, so only the order of costs matters.

The order is that of everyday misprints and slips: a sign or a lost term before a wrong number, a wrong number before a
wrong name, a wrong name before an additional factor, any small edit before a rewritten part. The values were set by
hand until the corpus of `tests/codegen/diff` got the answers that a person would give. Each docstring states how many
of 92 answers change when the value is halved, and when it is doubled. These answers are the 38 edits of the corpus and
eight double edits, in both directions.
"""

# Terms: 1 is the unit.
SIGN = 1.0
"""Cost of a flipped sign, the commonest slip. Half the cost changes no answer; twice the cost changes 14, because "-1
became 1" is cheaper."""
LOST_TERM = 1.0
"""A lost term. Half the cost changes no answer; twice the cost changes 4, where a lost term is reported as a
rewritten sum."""
COEFFICIENT = 1.2
"""Another coefficient of a term. Half the cost changes 4 answers, where it beats NUMBER and adds a word; twice the
cost changes 2."""
ADDED_TERM = 1.6
"""A new term; costs more than LOST_TERM. Half the cost changes 2 answers, where a wrong coefficient becomes a new
term; twice the cost changes 3, where sums are rewritten."""
ADDED_NUMBER = 1.9
"""A new number, which could explain any wrong sum; costs more than ADDED_TERM. Half the cost changes 1 answer, where
a lost constant becomes an added one; twice the cost none."""
ADDED_NODE = 0.02
"""Surcharge per node of a new term, in favour of smaller terms. Half or twice the cost changes no answer."""

# Factors, names and numbers.
NUMBER = 1.1
"""Another number. Half the cost changes 14 answers, where a sign becomes "-1 became 1"; twice the cost changes 2,
where COEFFICIENT is cheaper."""
EXPONENT = NAME = 1.2
"""Another exponent, name or function. Half the cost changes no answer; twice the cost changes 3 for an exponent, 6
for a name, where "sin became cos" is reported as a factor 1/tan."""
LOST_FACTOR = 1.3
"""A lost factor, or another power of it. Half or twice the cost changes 1 answer, where one term is lost and one
added."""
FACTOR = 1.5
"""A new factor, which could be any atom of either side. Half the cost changes 3 answers, where it beats a wrong
function; twice the cost changes 1."""
ALSO_SIGN, ALSO_NUMBER = 0.3, 0.9
"""Surcharges for a sign or number that differs together with a factor, in the same place. Half or twice the cost
changes no answer."""
OTHER_ARGUMENT = 1.5
"""A sine of another argument, more than a slip. Half or twice the cost changes no answer."""

# Inside functions without an inverse, edits are tried one by one. More are tried, so each is less credible.
INNER_TERM = 1.4
"""A sign, coefficient or lost term inside of a function. Half the cost changes no answer; twice the cost changes 7,
where a sign becomes "-1 became 1"."""
INNER_NAME = 1.6
"""Another name inside of a function. Half the cost changes the order of 2 answers; twice the cost changes 4, where
the whole function is replaced."""
INNER_NUMBER = 1.7
"""Another number inside of a function. Half the cost changes 13 answers, where it beats INNER_TERM; twice the cost
changes 2, where the whole function is replaced."""

# Rewritten parts.
PART = 2.5
"""Cost of a part of the new side that replaces an old one; its size is added. Half the cost changes 6 answers, where
whole sums are rewritten; twice the cost none."""
PART_OLD_NODE, PART_NEW_NODE = 0.3, 0.1
"""Surcharges per replaced node and per replacing node, so that most of an expression stays. Half the costs change 3
and 1 answers, where whole sums are rewritten; twice the cost none."""
PART_ALIKE = 3.0
"""Surcharge if both parts are of one kind, such as sums: an edit inside of them explains more. Half or twice the cost
changes no answer."""
REWRITTEN = 6.0
"""Cost of replacing the whole expression, if nothing else explains the difference. Half or twice the cost changes no
answer."""

# Places.
LEVEL = 0.02
"""Surcharge per level below the root, so that the outermost of equal edits wins; smaller than any other step. Half or
twice the cost changes no answer."""
STAYS = 0.3
"""Surcharge if the edited part still exists on the new side, which makes the edit unlikely. Half the cost changes 1
answer, where a part is rewritten with a constant added; twice the cost changes 2, where an unchanged term counts as
new."""
WRITTEN = 0.1
"""Discount if the new side contains the edit's result as written. Half the cost changes 2 answers to another reading;
twice the cost none."""

# Limits.
PAIR = 2.4
"""Largest cost of the edit between two paired terms. Above it, one term counts as lost and one as added. Half the
cost changes 10 answers, where one term has two slips; twice the cost changes 4, where unlike terms are paired."""
ENOUGH = 4.0
"""Cost that ends the search: below it, combinations of smaller edits are not tried. Half the cost changes no answer;
twice the cost changes 7, where sums are rewritten."""
