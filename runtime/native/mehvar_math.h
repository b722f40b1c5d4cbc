/* SPDX-License-Identifier: Apache-2.0 */
/* Where private C found its arithmetic before; to be removed once nothing includes it. */
#include "mehvar/private/arithmetic.h"
