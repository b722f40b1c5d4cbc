# SPDX-License-Identifier: Apache-2.0
"""`mehvar board`: a law on a microcontroller, emulated or real; one command a module."""
