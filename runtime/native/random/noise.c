/* SPDX-License-Identifier: Apache-2.0 */
/* The noise of one run, many samples at once. */
#include "noise.h"

void mv_normals(uint64_t seed, uint64_t run, int64_t samples, int64_t size, double *e)
{
    for (int64_t k = 0; k < samples; k++) mv_noise(seed, &run, MV_OF_MEASUREMENTS, (uint64_t)k, (int)size, e + k * size);
}
