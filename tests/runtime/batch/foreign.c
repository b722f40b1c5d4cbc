/* SPDX-License-Identifier: Apache-2.0 */
/* Runs the blocks of a batch whose job comes on standard input, and writes back the arrays it points to: for processors
 * whose structures are laid out as this machine's. Input: the job; first block, and that after the last; count; for each pointer in it its place and its bytes. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "job.h"

enum { MOST = 32, ALIGNMENT = 64 };

int64_t mv_work_size(const mv_job *job);
void mv_run_blocks(const mv_job *job, int64_t first, int64_t end, char *work);

static void take(void *to, size_t size)
{
    if (size > 0 && fread(to, size, 1, stdin) != 1) exit(EXIT_FAILURE);
}

int main(void)
{
    mv_job job;
    int64_t count, first, end, place[MOST], size[MOST];
    char *array[MOST];
    take(&job, sizeof job);
    take(&first, sizeof first);
    take(&end, sizeof end);
    take(&count, sizeof count);
    for (int i = 0; i < count; i++) {
        take(&place[i], sizeof *place);
        take(&size[i], sizeof *size);
        array[i] = malloc((size_t)size[i] + 1);
        take(array[i], (size_t)size[i]);
        memcpy((char *)&job + place[i], &array[i], sizeof *array);
    }
    const size_t work = (size_t)(mv_work_size(&job) / ALIGNMENT + 1) * ALIGNMENT;
    mv_run_blocks(&job, first, end, aligned_alloc(ALIGNMENT, work));
    for (int i = 0; i < count; i++)
        if (fwrite(array[i], 1, (size_t)size[i], stdout) != (size_t)size[i]) return EXIT_FAILURE;
    return EXIT_SUCCESS;
}
