/* SPDX-License-Identifier: Apache-2.0 */
/* Where private C found its exp before; to be removed once nothing includes it. */
#include "mehvar/private/exp.h"
