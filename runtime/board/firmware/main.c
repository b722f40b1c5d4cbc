/* SPDX-License-Identifier: Apache-2.0 */
#include "mehvar/board.h"
#include "mehvar/server.h"

int main(void)
{
    mv_board_init();
    mv_server_init();
    for (;;) {
        for (int byte = mv_board_read(); byte >= 0; byte = mv_board_read()) mv_server_byte((uint8_t)byte);
        mv_server_watch(mv_board_ms());
        mv_board_wait();
    }
}
