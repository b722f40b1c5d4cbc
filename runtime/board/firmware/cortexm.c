/* SPDX-License-Identifier: Apache-2.0 */
#include "mehvar/private/cortexm.h"

#include "mehvar/board.h"
#include "mehvar/private/board_law.h"

#define SYST_CSR REGISTER(0xE000E010u)
#define SYST_RVR REGISTER(0xE000E014u)
#define SYST_CVR REGISTER(0xE000E018u)
#define NVIC_ISER(n) REGISTER(0xE000E100u + 4u * (n))
#define NVIC_ICPR(n) REGISTER(0xE000E280u + 4u * (n))
#define SCB_ICSR REGISTER(0xE000ED04u)
#define SCB_AIRCR REGISTER(0xE000ED0Cu)
#define SCB_CPACR REGISTER(0xE000ED88u)

enum { WRAP_MS = 50, PAINT = 0x5A };

extern uint32_t __stack_limit[], __stack_top[], __data_load[], __data_start[], __data_end[], __bss_start[], __bss_end[];

int main(void);
void Reset_Handler(void);
void Default_Handler(void);

static uint32_t clock_hertz, ticks_per_ms, wrap_ticks, wraps, waking;

void cortexm_clock(uint32_t hertz)
{
    clock_hertz = hertz;
    ticks_per_ms = hertz / 1000u;
    wrap_ticks = ticks_per_ms * WRAP_MS;
    SYST_RVR = wrap_ticks - 1u;
    SYST_CVR = 0;
    SYST_CSR = 7u; /* processor clock, wake at each wrap, on */
}

void cortexm_wake_by(uint32_t interrupt)
{
    waking = interrupt;
    NVIC_ISER(interrupt / 32u) = 1u << (interrupt % 32u);
}

/* Count the ticks since the last wrap, and the wraps, if called at least every WRAP_MS. */
static uint32_t ticks_in_wrap(void)
{
    uint32_t left = SYST_CVR;
    if (SYST_CSR & 1u << 16) {
        wraps++;
        left = SYST_CVR;
    }
    return wrap_ticks - 1u - left;
}

uint32_t cortexm_ms(void)
{
    const uint32_t rest = ticks_in_wrap() / ticks_per_ms;
    return wraps * WRAP_MS + rest;
}

uint32_t mv_board_ticks(void)
{
    const uint32_t rest = ticks_in_wrap();
    return wraps * wrap_ticks + rest;
}

uint32_t mv_board_ticks_per_second(void) { return clock_hertz; }

void mv_board_wait(void)
{
    __asm__ volatile("wfi" ::: "memory");
    NVIC_ICPR(waking / 32u) = 1u << (waking % 32u);
    SCB_ICSR = 1u << 25; /* SysTick no longer pending */
}

void mv_board_stack(uint32_t *used, uint32_t *size)
{
    const uint8_t *lowest = (const uint8_t *)__stack_limit, *top = (const uint8_t *)__stack_top;
    *size = (uint32_t)(top - lowest);
    while (lowest < top && *lowest == PAINT) lowest++;
    *used = (uint32_t)(top - lowest);
}

void mv_board_reset(void)
{
    __asm__ volatile("dsb" ::: "memory");
    SCB_AIRCR = 0x05FA0004u;
    for (;;) __asm__ volatile("nop");
}

void Reset_Handler(void)
{
    uint32_t *here;
    __asm__ volatile("cpsid i\n\tmov %0, sp" : "=r"(here)::"memory");
    for (uint32_t *at = __stack_limit; at < here - 8; at++) *at = 0x01010101u * PAINT;
    const uint32_t *from = __data_load;
    for (uint32_t *to = __data_start; to < __data_end; to++) *to = *from++;
    for (uint32_t *to = __bss_start; to < __bss_end; to++) *to = 0;
#ifdef __ARM_FP
    SCB_CPACR |= 0xFu << 20; /* the floating point unit */
    __asm__ volatile("dsb\n\tisb" ::: "memory");
#endif
    main();
    for (;;) __asm__ volatile("nop");
}

/* Handle a fault: set the outputs to zero, then restart. */
void Default_Handler(void)
{
    static const mv_real zero[MV_BOARD_NU];
    mv_board_output(zero);
    mv_board_reset();
}

/* Interrupts are masked, so that only the core's exceptions occur. */
typedef void (*handler)(void);
__attribute__((section(".vectors"), used)) static const union {
    uint32_t *stack;
    handler code;
} vectors[16] = {
    {.stack = __stack_top},     {.code = Reset_Handler},   {.code = Default_Handler}, {.code = Default_Handler},
    {.code = Default_Handler},  {.code = Default_Handler}, {.code = Default_Handler}, {.stack = 0},
    {.stack = 0},               {.stack = 0},              {.stack = 0},              {.code = Default_Handler},
    {.code = Default_Handler},  {.stack = 0},              {.code = Default_Handler}, {.code = Default_Handler},
};
