/* SPDX-License-Identifier: Apache-2.0 */
/* A generated function over arrays with broadcast leading axes. */
#include <stdint.h>

#define MV_MAX_ARRAYS 32

typedef void (*mv_call)(const double *const *arguments, double *const *results);

/* Evaluate call at every index of the leading axes (the last one fastest).
 * strides[a * axes + d] is the byte stride of argument a along axis d; results are contiguous, sizes[r] numbers each. */
void mv_map(mv_call call, int64_t arguments, int64_t results, int64_t axes, const int64_t *shape,
            const double *const *first, const int64_t *strides, double *const *out, const int64_t *sizes)
{
    const double *in[MV_MAX_ARRAYS];
    double *to[MV_MAX_ARRAYS];
    int64_t index[MV_MAX_ARRAYS] = {0};
    for (int64_t d = 0; d < axes; d++)
        if (shape[d] == 0) return;
    for (int64_t a = 0; a < arguments; a++) in[a] = first[a];
    for (int64_t r = 0; r < results; r++) to[r] = out[r];
    for (;;) {
        call(in, to);
        for (int64_t r = 0; r < results; r++) to[r] += sizes[r];
        int64_t d = axes - 1;
        for (; d >= 0; d--) {
            const int64_t back = ++index[d] == shape[d] ? 1 - shape[d] : 1;
            for (int64_t a = 0; a < arguments; a++)
                in[a] = (const double *)((const char *)in[a] + back * strides[a * axes + d]);
            if (back == 1) break;
            index[d] = 0;
        }
        if (d < 0) return;
    }
}
