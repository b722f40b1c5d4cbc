/* Three laws of three models in one image, two states of one of them, on the measurements of samples.h. The bits of all
 * commands and memories go out as text: by the serial line of an MPS2 board, or by a process's standard output. */
#include "samples.h"

#ifdef __arm__
extern uint32_t stack_top[];
int main(void);
static void put(char letter) { *(volatile uint32_t *)0x40004000u = (uint32_t)letter; }
void reset(void); /* which the linker looks for */
void reset(void)
{
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* the floating point unit */
    *(volatile uint32_t *)0x40004008u = 1;           /* the transmitter of UART 0 */
    main();
    for (;;) {}
}
__attribute__((section(".vectors"), used)) static const void *const vectors[2] = {stack_top, (const void *)reset};
#else
#include <stdio.h>
static void put(char letter) { putchar(letter); }
#endif

static void print(const mv_real *v, int n)
{
    for (int i = 0; i < n; i++) {
        union {
            mv_real number;
            uint32_t bits;
        } word = {v[i]};
        for (int shift = 28; shift >= 0; shift -= 4) put("0123456789abcdef"[word.bits >> shift & 15]);
        put(' ');
    }
}

#define STEP(state, law, LAW, k)                                                                                       \
    do {                                                                                                               \
        mv_real command[LAW##_NCOMMAND];                                                                               \
        if (k == 0 && law##_init(&state, &law##_defaults) != MV_LAW_ACCEPTED) put('!');                                \
        for (int i = 0; i < LAW##_NCOMMAND; i++) state.applied[i] = law##_applied[k][i];                               \
        if (law##_step(&state, law##_measured[k], law##_reference[k], command)) put('?');                              \
        print(command, LAW##_NCOMMAND);                                                                                \
        print(law##_memory(&state), LAW##_NMEMORY);                                                                    \
        put('\n');                                                                                                     \
    } while (0)

int main(void)
{
    static satellite_mrac_state one, other;
    static triangle_path_state path;
    static third_state last;
    for (int k = 0; k < SAMPLES; k++) {
        STEP(one, satellite_mrac, SATELLITE_MRAC, k);
        STEP(path, triangle_path, TRIANGLE_PATH, k);
        STEP(last, third, THIRD, k);
        STEP(other, satellite_mrac, SATELLITE_MRAC, k);
    }
    put('.');
    return 0;
}
