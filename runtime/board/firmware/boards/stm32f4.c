/* SPDX-License-Identifier: Apache-2.0 */
/* STM32F405 and relatives: 168 MHz from the internal oscillator, USART at 115200 baud, 8N1.
 *
 * BOARD_USART 1 (default): PA9 transmit, PA10 receive; 2: PA2 and PA3, the ST-Link's line on Nucleo boards. The first
 * three outputs are pulse widths of TIM3 on PA6, PA7 and PB0: half the period is zero, the whole period is BOARD_FULL_SCALE
 * or more. The independent watchdog restarts a program that hangs, and a start sets the outputs to zero. Clocks, pins, baud
 * rate, timers and watchdog are untested on silicon. QEMU's netduinoplus2 has only the timers; under Unicorn, mehvar's model
 * of the manual (RM0090) emulates the others. */
#include "mehvar/board.h"
#include "mehvar/board_model.h"
#include "mehvar/private/cortexm.h"

#ifndef BOARD_USART
#define BOARD_USART 1
#endif
#ifndef BOARD_FULL_SCALE
#define BOARD_FULL_SCALE 1 /* of the law's inputs, in their units */
#endif

#define RCC_CR REGISTER(0x40023800u)
#define RCC_PLLCFGR REGISTER(0x40023804u)
#define RCC_CFGR REGISTER(0x40023808u)
#define RCC_AHB1ENR REGISTER(0x40023830u)
#define RCC_APB1ENR REGISTER(0x40023840u)
#define RCC_APB2ENR REGISTER(0x40023844u)
#define FLASH_ACR REGISTER(0x40023C00u)
#define GPIOA_MODER REGISTER(0x40020000u)
#define GPIOA_PUPDR REGISTER(0x4002000Cu)
#define GPIOA_AFR(n) REGISTER(0x40020020u + 4u * (n))
#if BOARD_USART == 1
#define USART 0x40011000u
enum { INTERRUPT = 37, TX_PIN = 9, RX_PIN = 10, BUS_DIVIDER = 2 };
#else
#define USART 0x40004400u
enum { INTERRUPT = 38, TX_PIN = 2, RX_PIN = 3, BUS_DIVIDER = 4 };
#endif
#define GPIOB_MODER REGISTER(0x40020400u)
#define GPIOB_AFR(n) REGISTER(0x40020420u + 4u * (n))
#define TIM3_CR1 REGISTER(0x40000400u)
#define TIM3_EGR REGISTER(0x40000414u)
#define TIM3_CCMR(n) REGISTER(0x40000418u + 4u * (n))
#define TIM3_CCER REGISTER(0x40000420u)
#define TIM3_PSC REGISTER(0x40000428u)
#define TIM3_ARR REGISTER(0x4000042Cu)
#define TIM3_CCR(n) REGISTER(0x40000434u + 4u * (n))
#define IWDG_KR REGISTER(0x40003000u)
#define IWDG_PR REGISTER(0x40003004u)
#define IWDG_RLR REGISTER(0x40003008u)
#define DBGMCU_APB1_FZ REGISTER(0xE0042008u)
#define USART_SR REGISTER(USART)
#define USART_DR REGISTER(USART + 4u)
#define USART_BRR REGISTER(USART + 8u)
#define USART_CR1 REGISTER(USART + 12u)

/* A pulse every 50 microseconds, 20 kHz, is above hearing; its width has 4200 steps at 84 MHz. The watchdog counts 200 ms of
 * the nominal 32 kHz, which is between 136 and 376 ms of 47 and 17 kHz: always more than the 50 ms of the main loop. Half
 * this time would come near 50 ms; twice keeps the outputs of a hung program for longer. */
enum { PULSE_HERTZ = 20000, PULSES = 3, WATCHDOG_TICKS = 199, WATCHDOG_BY_32 = 3 };
enum { BAUD = 115200, HSI_HERTZ = 16000000, PLL_HERTZ = 168000000, PATIENCE = 100000 };

const char mv_board_name[] = "stm32f4";

static int wait_for(volatile uint32_t *reg, uint32_t mask, uint32_t value)
{
    for (uint32_t i = 0; i < PATIENCE; i++)
        if ((*reg & mask) == value) return 1;
    return 0;
}

/* 16 MHz / 16 * 336 / 2 = 168 MHz; the buses at 42 and 84 MHz. Stays at 16 MHz when the PLL does not lock.
 * Bit 29 is as after a reset; on an F446 it belongs to PLLR, which may not be 0. */
static int start_pll(void)
{
    if (RCC_CR == 0) return 1; /* no clock control, as in QEMU, whose processor counts at 168 MHz */
    RCC_PLLCFGR = 16u | 336u << 6 | 7u << 24 | 2u << 28;
    RCC_CR |= 1u << 24;
    if (!wait_for(&RCC_CR, 1u << 25, 1u << 25)) return 0;
    FLASH_ACR = 5u | 7u << 8; /* wait states, prefetch, caches */
    RCC_CFGR = 5u << 10 | 4u << 13;
    RCC_CFGR |= 2u;
    return wait_for(&RCC_CFGR, 3u << 2, 2u << 2);
}

static void connect(uint32_t pin)
{
    GPIOA_MODER = (GPIOA_MODER & ~(3u << 2 * pin)) | 2u << 2 * pin;
    GPIOA_PUPDR = (GPIOA_PUPDR & ~(3u << 2 * pin)) | 1u << 2 * pin;
    const uint32_t shift = 4 * (pin % 8);
    GPIOA_AFR(pin / 8) = (GPIOA_AFR(pin / 8) & ~(15u << shift)) | 7u << shift;
}

static uint32_t pulse; /* ticks of a period */

static void start_timer(uint32_t hertz)
{
    static const mv_real zero[MV_BOARD_NU];
    pulse = hertz / PULSE_HERTZ;
    RCC_AHB1ENR |= 2u;
    RCC_APB1ENR |= 1u << 1;
    TIM3_PSC = 0;
    TIM3_ARR = pulse - 1u;
    TIM3_CCMR(0) = 0x6868u; /* pulse widths, taken over at the end of a period */
    TIM3_CCMR(1) = 0x0068u;
    TIM3_CCER = 0x0111u;
    mv_board_output(zero);
    TIM3_EGR = 1u;
    TIM3_CR1 = 1u << 7 | 1u;
    GPIOA_AFR(0) = (GPIOA_AFR(0) & ~(0xFFu << 24)) | 0x22u << 24;
    GPIOA_MODER = (GPIOA_MODER & ~(0xFu << 12)) | 0xAu << 12;
    GPIOB_AFR(0) = (GPIOB_AFR(0) & ~0xFu) | 2u;
    GPIOB_MODER = (GPIOB_MODER & ~3u) | 2u;
}

static void start_watchdog(void)
{
    if (RCC_CR != 0) DBGMCU_APB1_FZ |= 1u << 12; /* stops while a debugger holds the processor; QEMU has neither */
    IWDG_KR = 0xCCCCu;
    IWDG_KR = 0x5555u;
    IWDG_PR = WATCHDOG_BY_32;
    IWDG_RLR = WATCHDOG_TICKS;
    IWDG_KR = 0xAAAAu;
}

/* The main loop, and the self-test at each sample, read the time; a program that does not has hung. */
uint32_t mv_board_ms(void)
{
    IWDG_KR = 0xAAAAu;
    return cortexm_ms();
}

void mv_board_init(void)
{
    const int fast = start_pll();
    const uint32_t core = fast ? PLL_HERTZ : HSI_HERTZ, bus = fast ? core / BUS_DIVIDER : core;
    RCC_AHB1ENR |= 1u;
    if (BOARD_USART == 1)
        RCC_APB2ENR |= 1u << 4;
    else
        RCC_APB1ENR |= 1u << 17;
    connect(TX_PIN);
    connect(RX_PIN);
    USART_BRR = (bus + BAUD / 2) / BAUD;
    USART_CR1 = 1u << 13 | 1u << 5 | 1u << 3 | 1u << 2; /* on, wake by a received byte, transmit, receive */
    cortexm_wake_by(INTERRUPT);
    cortexm_clock(core);
    start_timer(fast ? core / 2u : core); /* timers of APB1 go twice as fast as their bus when that is divided */
    start_watchdog();
}

int mv_board_read(void)
{
    /* reading the data after the status clears an overrun too */
    return USART_SR & (1u << 5 | 1u << 3) ? (int)(USART_DR & 0xFFu) : -1;
}

void mv_board_write(const uint8_t *bytes, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        wait_for(&USART_SR, 1u << 7, 1u << 7);
        USART_DR = bytes[i];
    }
}

/* Width of a pulse; an output that is not a number gives the width for zero. */
static uint32_t width(mv_real u)
{
    const mv_real half = (mv_real)(pulse / 2u), ratio = u / (mv_real)BOARD_FULL_SCALE;
    if (ratio >= 1) return pulse;
    if (ratio <= -1) return 0;
    return ratio > -1 ? (uint32_t)(half + half * ratio) : (uint32_t)half;
}

void mv_board_output(const mv_real *u)
{
    for (uint32_t i = 0; i < MV_BOARD_NU && i < PULSES; i++) TIM3_CCR(i) = width(u[i]);
}
