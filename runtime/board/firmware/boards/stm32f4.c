/* SPDX-License-Identifier: Apache-2.0 */
/* STM32F405 and relatives: 168 MHz from the internal oscillator, USART at 115200 baud, 8N1.
 *
 * BOARD_USART 1 (default): PA9 transmit, PA10 receive; 2: PA2 and PA3, the ST-Link's line on Nucleo boards.
 * Clocks, pins and baud rate have not been tested on silicon; QEMU's netduinoplus2 has neither RCC nor pins. */
#include "mehvar/board.h"
#include "mehvar/private/cortexm.h"

#ifndef BOARD_USART
#define BOARD_USART 1
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
#define USART_SR REGISTER(USART)
#define USART_DR REGISTER(USART + 4u)
#define USART_BRR REGISTER(USART + 8u)
#define USART_CR1 REGISTER(USART + 12u)

enum { BAUD = 115200, HSI_HERTZ = 16000000, PLL_HERTZ = 168000000, PATIENCE = 100000 };

const char mv_board_name[] = "stm32f4";

static int wait_for(volatile uint32_t *reg, uint32_t mask, uint32_t value)
{
    for (uint32_t i = 0; i < PATIENCE; i++)
        if ((*reg & mask) == value) return 1;
    return 0;
}

/* 16 MHz / 16 * 336 / 2 = 168 MHz; the buses at 42 and 84 MHz. Stays at 16 MHz when the PLL does not lock. */
static int start_pll(void)
{
    if (RCC_CR == 0) return 1; /* no clock control, as in QEMU, whose processor counts at 168 MHz */
    RCC_PLLCFGR = 16u | 336u << 6 | 7u << 24;
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

void mv_board_output(const mv_real *u) { (void)u; }
