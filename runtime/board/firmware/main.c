/* SPDX-License-Identifier: Apache-2.0 */
#include "board.h"
#include "server.h"

int main(void)
{
    board_init();
    server_init();
    for (;;) {
        for (int byte = board_read(); byte >= 0; byte = board_read()) server_byte((uint8_t)byte);
        server_watch(board_ms());
        board_wait();
    }
}
