# SPDX-License-Identifier: Apache-2.0
"""What an edit costs. Of all edits that explain a difference the cheapest is told, so only their order counts.

The order is that of everyday misprints and slips: a sign or a lost term before a wrong number, a wrong number before a
wrong name, a wrong name before a factor too many, anything small before a part that was written anew. The values were
set by hand until the corpus of `tests/codegen/diff` got the answers that a person would give. Behind each stands how
many of 92 answers change (the 38 edits of the corpus and eight double ones, there and back) when it is halved, and when
it is doubled.
"""

# Terms: 1 is the unit.
SIGN = 1.0
"""A flipped sign, the commonest slip. Halved, 0 answers change; doubled, 14: it loses to "-1 became 1"."""
LOST_TERM = 1.0
"""A term that is gone. 0; 4: what was lost inside a rearranged sum is told as the whole sum written anew."""
COEFFICIENT = 1.2
"""Another number before a term. 4: it beats NUMBER, and "1/2 became 11/20" gets a word too many; 2."""
ADDED_TERM = 1.6
"""A term that is new: above LOST_TERM. 2: a wrong coefficient becomes a new term; 3: sums are written anew."""
ADDED_NUMBER = 1.9
"""A number that is new, which any wrong sum could also be: above ADDED_TERM. 1: a lost constant is an added one; 0."""
ADDED_NODE = 0.02
"""For each node of a new term: only of two that would do, the smaller one is told. 0; 0."""

# Factors, names and numbers.
NUMBER = 1.1
"""A number that is another one. 14: it beats SIGN, and signs become "-1 became 1"; 2: COEFFICIENT beats it."""
EXPONENT = NAME = 1.2
"""Another exponent, another name or function. 0; 3 for an exponent, 6 for a name: "sin became cos" is told as a factor
of 1/tan."""
LOST_FACTOR = 1.3
"""A factor that is gone, or another power of one. 1; 1: told as a term lost and a term added."""
FACTOR = 1.5
"""A factor that is new, which explains much: any atom of either side may be one. 3: it beats a wrong function; 1."""
ALSO_SIGN, ALSO_NUMBER = 0.3, 0.9
"""With a factor the sign, or the number, is another one too: two slips, but in one place. 0; 0, for both."""
OTHER_ARGUMENT = 1.5
"""A sine became one of something else: more than a slip. 0; 0."""

# Inside functions without an inverse, where edits are tried one by one: more is tried, so each is believed less.
INNER_TERM = 1.4
"""A sign, a coefficient, a lost term. 0; 7: signs become "-1 became 1"."""
INNER_NAME = 1.6
"""Another name. 2: told in another order; 4: the whole function is told as another one."""
INNER_NUMBER = 1.7
"""Another number. 13: it beats INNER_TERM; 2: the whole function is told as another one."""

# Parts written anew.
PART = 2.5
"""A part of the new side in place of an old one, before its size counts. 6: whole sums are rewritten; 0."""
PART_OLD_NODE, PART_NEW_NODE = 0.3, 0.1
"""For each node that is replaced, and that replaces it: keep what can be kept. 3 and 1: whole sums are rewritten; 0."""
PART_ALIKE = 3.0
"""Both parts are of one kind, such as two sums, so that something inside them explains more. 0; 0."""
REWRITTEN = 6.0
"""All of it: when nothing else explains it. 0; 0."""

# Places.
LEVEL = 0.02
"""For each level below the root: of equal edits the outermost. 0; 0: it only has to be smaller than all other steps."""
STAYS = 0.3
"""What is edited stands on the new side as it is, so hardly was that. 1: it is rewritten with a constant
added; 2: a term that stayed is told as a new one."""
WRITTEN = 0.1
"""Off where the result of the edit stands on the new side as written. 2: of two readings the other is told; 0."""

# Limits.
PAIR = 2.4
"""Dearer edits do not make one term out of another: one was lost, one added. 10: two slips in one term; 4: unlike terms
are paired."""
ENOUGH = 4.0
"""A cheaper edit ends the search: several smaller ones are not tried. 0; 7: sums are written anew, not term by term."""
