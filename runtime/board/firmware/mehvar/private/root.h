/* SPDX-License-Identifier: Apache-2.0 */
/* Correctly rounded square root of a float without the C library: the processor's instruction if available, else digit by
 * digit. Without -fno-math-errno compilers call sqrtf for negative numbers. operations.h includes this file. */
#ifndef MEHVAR_PRIVATE_ROOT_H
#define MEHVAR_PRIVATE_ROOT_H

static inline real mv_sqrt_by_digits(real x)
{
    uint32_t bits = mv_to_bits(x);
    if (x != x || x == K(0) || bits == mv_to_bits(MV_INFINITY)) return x;
    if (bits & MV_SIGN_BITS) return MV_NAN;
    int32_t exponent = (int32_t)(bits >> 23);
    uint32_t digits = bits & 0x7FFFFFu;
    if (exponent == 0)
        for (exponent = 1; !(digits & 0x800000u); exponent--) digits <<= 1;
    digits |= 0x800000u;
    exponent -= 127;
    if (exponent & 1) digits <<= 1;
    exponent = (exponent - (exponent & 1)) / 2;
    uint32_t rest = digits << 1, root = 0, sum = 0;
    for (uint32_t digit = 0x1000000u; digit != 0; digit >>= 1) {
        const uint32_t trial = sum + digit;
        if (trial <= rest) {
            sum = trial + digit;
            rest -= trial;
            root += digit;
        }
        rest <<= 1;
    }
    if (rest != 0) root += root & 1u; /* nearest; a root is never halfway */
    return mv_from_bits((root >> 1) + ((uint32_t)(exponent + 126) << 23));
}

static inline real mv_sqrt(real x)
{
#if defined __GNUC__ && defined __ARM_FP && (__ARM_FP & 4) && !defined __aarch64__
    __asm__("vsqrt.f32 %0, %1" : "=t"(x) : "t"(x));
    return x;
#elif defined __GNUC__ && defined __aarch64__
    __asm__("fsqrt %s0, %s1" : "=w"(x) : "w"(x));
    return x;
#elif defined __GNUC__ && defined __riscv_flen
    __asm__("fsqrt.s %0, %1" : "=f"(x) : "f"(x));
    return x;
#elif defined __GNUC__ && defined __SSE__
    __asm__("sqrtss %1, %0" : "=x"(x) : "x"(x));
    return x;
#else
    return mv_sqrt_by_digits(x);
#endif
}

#endif
