# SPDX-License-Identifier: Apache-2.0
"""The task's craft."""

from .system import STRUCTURE as STRUCTURE
from .system import system as system
