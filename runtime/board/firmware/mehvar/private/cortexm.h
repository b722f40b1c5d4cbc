/* SPDX-License-Identifier: Apache-2.0 */
/* What Cortex-M boards share: start-up, clock, sleep, stack. Names of handlers and sections as in CMSIS.
 *
 * Interrupts stay masked: a pending interrupt still ends `wfi`, and only the main loop runs. */
#ifndef MEHVAR_PRIVATE_CORTEXM_H
#define MEHVAR_PRIVATE_CORTEXM_H

#include <stdint.h>

#define REGISTER(address) (*(volatile uint32_t *)(address))

void cortexm_clock(uint32_t hertz); /* start SysTick, which counts the processor's clock */
uint32_t cortexm_ms(void);
void cortexm_wake_by(uint32_t interrupt);

#endif
