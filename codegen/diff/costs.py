# SPDX-License-Identifier: Apache-2.0
"""Costs of edits. Of all edits that explain a difference the cheapest is reported, so only their order counts.

The order is that of everyday misprints and slips: a sign or a lost term before a wrong number, a wrong number before a
wrong name, a wrong name before an additional factor, any small edit before a rewritten part. The values were set by
hand until the corpus of `tests/codegen/diff` got the answers that a person would give. Each docstring states how many
of 92 answers change when the value is halved, and when it is doubled. These answers are the 38 edits of the corpus and
eight double edits, in both directions.
"""

# Terms: 1 is the unit.
SIGN = 1.0
"""A flipped sign, the commonest slip. Halved, 0 answers change; doubled, 14: it loses to "-1 became 1"."""
LOST_TERM = 1.0
"""A lost term. 0; 4: a term lost inside a rearranged sum is reported as the whole sum rewritten."""
COEFFICIENT = 1.2
"""A different number before a term. 4: it beats NUMBER, and "1/2 became 11/20" gets a word too many; 2."""
ADDED_TERM = 1.6
"""A new term: above LOST_TERM. 2: a wrong coefficient becomes a new term; 3: sums are rewritten."""
ADDED_NUMBER = 1.9
"""A new number, which could explain any wrong sum: above ADDED_TERM. 1: a lost constant becomes an added one; 0."""
ADDED_NODE = 0.02
"""For each node of a new term: breaks ties in favour of the smaller term. 0; 0."""

# Factors, names and numbers.
NUMBER = 1.1
"""A different number. 14: it beats SIGN, and signs become "-1 became 1"; 2: COEFFICIENT beats it."""
EXPONENT = NAME = 1.2
"""A different exponent, name or function. 0; 3 for an exponent, 6 for a name: "sin became cos" is reported as a factor
of 1/tan."""
LOST_FACTOR = 1.3
"""A lost factor, or a different power of one. 1; 1: reported as a term lost and a term added."""
FACTOR = 1.5
"""A new factor, which explains much: any atom of either side may be one. 3: it beats a wrong function; 1."""
ALSO_SIGN, ALSO_NUMBER = 0.3, 0.9
"""In addition to a factor, the sign or the number differs: two slips, but in one place. 0; 0, for both."""
OTHER_ARGUMENT = 1.5
"""A sine of a different argument: more than a slip. 0; 0."""

# Inside functions without an inverse, edits are tried one by one. More are tried, so each is less credible.
INNER_TERM = 1.4
"""A sign, a coefficient, a lost term. 0; 7: signs become "-1 became 1"."""
INNER_NAME = 1.6
"""A different name. 2: reported in another order; 4: the whole function is reported as replaced."""
INNER_NUMBER = 1.7
"""A different number. 13: it beats INNER_TERM; 2: the whole function is reported as replaced."""

# Rewritten parts.
PART = 2.5
"""A part of the new side in place of an old one, before its size counts. 6: whole sums are rewritten; 0."""
PART_OLD_NODE, PART_NEW_NODE = 0.3, 0.1
"""For each replaced node, and for each replacing node: keeps as much as possible. 3 and 1: whole sums are rewritten;
0."""
PART_ALIKE = 3.0
"""Both parts are of one kind, such as two sums, so that an edit inside them is the better explanation. 0; 0."""
REWRITTEN = 6.0
"""The whole expression: if nothing else explains the difference. 0; 0."""

# Places.
LEVEL = 0.02
"""For each level below the root: of equal edits the outermost wins. 0; 0: it only has to be below all other steps."""
STAYS = 0.3
"""The edited part exists unchanged on the new side, so this edit is unlikely. 1: the part is rewritten with a constant
added; 2: an unchanged term is reported as a new one."""
WRITTEN = 0.1
"""Discount if the result of the edit exists on the new side as written. 2: of two readings the other is reported; 0."""

# Limits.
PAIR = 2.4
"""Limit above which an edit does not pair two terms: one was lost, one was added. 10: two slips in one term; 4: unlike
terms are paired."""
ENOUGH = 4.0
"""A cheaper edit ends the search: combinations of smaller ones are not tried. 0; 7: sums are rewritten as a whole."""
