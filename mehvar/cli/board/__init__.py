# SPDX-License-Identifier: Apache-2.0
"""`mehvar board`: a law on a real or emulated microcontroller; one module per command."""
