/* SPDX-License-Identifier: Apache-2.0 */
/* Events of a run. They are recorded in C, because an exception of a Python function called within a run, such as a keyboard
 * interrupt, would be lost. */
#include <stdlib.h>

#include "single.h"

void mv_enter(mv_journal *journal, double t, int32_t event)
{
    if (journal->count == journal->room && !journal->full) {
        const int64_t room = journal->room ? 2 * journal->room : 64;
        double *const times = realloc(journal->t, (size_t)room * sizeof *times);
        if (times) journal->t = times;
        int32_t *const events = times ? realloc(journal->event, (size_t)room * sizeof *events) : 0;
        if (events) journal->event = events, journal->room = room;
        journal->full = !events;
    }
    if (journal->full) return;
    journal->t[journal->count] = t;
    journal->event[journal->count++] = event;
}

void mv_journal_free(mv_journal *journal)
{
    free(journal->t);
    free(journal->event);
}
