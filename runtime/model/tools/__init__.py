# SPDX-License-Identifier: Apache-2.0
"""A generated model in the terms of other libraries; each is imported when it is asked for."""
