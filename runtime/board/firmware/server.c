/* SPDX-License-Identifier: Apache-2.0 */
#include "mehvar/server.h"

#include <string.h>

#include "mehvar/private/app.h"
#include "mehvar/board.h"
#include "mehvar/private/link.h"

enum { VERSION = 2, NAME = 16 };
enum { TEST_FITS = 1 / (sizeof(mv_app_test) <= MV_BOARD_PAYLOAD) }; /* no division by zero: else it is not compiled */
#define TWO_BYTES(n) (n) & 0xFF, (n) >> 8

typedef struct {
    real u[MV_BOARD_NU];
    uint32_t ticks;
} step_reply;

typedef struct {
    uint32_t steps, duplicates, refused, lost, nonfinite; /* since the last reset */
    uint32_t ticks_last, ticks_least, ticks_most;
} counters;

static mv_link_state line;
static counters count;
static uint16_t session; /* of the host that is served; 0: of none */
static uint32_t last;    /* number of its last request */
static uint8_t last_type, served; /* was it not refused? */
static uint8_t repeated;          /* the present request repeats the last one, which was served */
static step_reply answer; /* to the last step */
static mv_app_test test;  /* result of the last self-test */
static uint8_t answer_flags, has_answer, has_test, ready, silent;
static uint8_t driven; /* an output is not zero and is cleared when steps stop */
static uint32_t last_ms;
static real output[MV_BOARD_NU]; /* present outputs of the actuators */

static uint8_t *payload(void) { return line.frame.bytes + MV_LINK_HEADER; }

static uint16_t frame_session(void) { return (uint16_t)(line.frame.bytes[2] | (uint32_t)line.frame.bytes[3] << 8); }

static uint32_t frame_number(void)
{
    uint32_t number = 0;
    for (int i = 7; i >= 4; i--) number = number << 8 | line.frame.bytes[i];
    return number;
}

static uint8_t *put(uint8_t *to, const void *from, uint32_t size)
{
    memcpy(to, from, size);
    return to + size;
}

static uint8_t *put_words(uint8_t *to, const void *from, uint32_t size)
{
    memcpy(to, from, size);
    mv_link_words(to, size / 4u);
    return to + size;
}

static uint8_t *put32(uint8_t *to, uint32_t value) { return put_words(to, &value, sizeof value); }

static uint8_t *put_name(uint8_t *to, const char *name)
{
    uint8_t *const end = to + NAME;
    while (*name != 0 && to < end - 1) *to++ = (uint8_t)*name++;
    while (to < end) *to++ = 0;
    return to;
}

static void reply(uint8_t flags, const uint8_t *end)
{
    line.frame.bytes[0] = (uint8_t)(line.frame.bytes[0] | MV_SERVER_REPLY);
    line.frame.bytes[1] = (uint8_t)(flags | (ready ? 0 : MV_SERVER_FRESH));
    mv_link_send(&line, (uint32_t)(end - payload()));
}

static void refuse(uint8_t reason)
{
    line.frame.bytes[0] = MV_SERVER_NAK;
    payload()[0] = reason;
    reply(0, reason == MV_SERVER_OUT_OF_TURN ? put32(payload() + 1, last) : payload() + 1);
}

static void set_output(const real *u)
{
    driven = 0;
    for (int i = 0; i < MV_BOARD_NU; i++) driven |= u[i] != K(0);
    memcpy(output, u, sizeof output);
    mv_board_output(output);
}

static void clear_output(void)
{
    static const real zero[MV_BOARD_NU];
    set_output(zero);
}

static void forget_steps(void)
{
    memset(&count, 0, sizeof count);
    count.ticks_least = 0xFFFFFFFFu;
    has_answer = 0;
    has_test = 0;
    silent = 0;
    clear_output();
}

/* Restore compiled-in parameters, clear the memory, and set the outputs to zero. */
static void forget_all(void)
{
    mv_app_defaults();
    ready = 0;
    forget_steps();
}

static int hello(uint32_t size)
{
    static const uint8_t hash[] = MV_BOARD_HASH;
    static const uint8_t sizes[] = {TWO_BYTES(MV_BOARD_IN), TWO_BYTES(MV_BOARD_NU), TWO_BYTES(MV_BOARD_NZ),
                                    TWO_BYTES(MV_BOARD_NP), TWO_BYTES(MV_BOARD_NC), TWO_BYTES(MV_BOARD_NS),
                                    TWO_BYTES(MV_BOARD_NX)};
    if (size != 0) return MV_SERVER_WRONG_SIZE;
    uint8_t *to = payload();
    *to++ = VERSION;
    *to++ = (uint8_t)sizeof(real);
    to = put(to, hash, sizeof hash);
    to = put(to, sizes, sizeof sizes);
    to = put32(to, mv_board_ticks_per_second());
    to = put_name(to, mv_board_name);
    to = put_name(to, MV_BOARD_MODEL);
    to = put_name(to, MV_BOARD_LAW);
    reply(0, to);
    return 0;
}

static int reset(uint32_t size)
{
    if (size != 0) return MV_SERVER_WRONG_SIZE;
    forget_all();
    reply(0, payload());
    return 0;
}

static void note_ticks(uint32_t ticks)
{
    count.ticks_last = ticks;
    if (ticks < count.ticks_least) count.ticks_least = ticks;
    if (ticks > count.ticks_most) count.ticks_most = ticks;
}

static uint8_t evaluate(void)
{
    real in[MV_BOARD_IN];
    answer_flags = (uint8_t)(silent ? MV_SERVER_LOST : 0);
    mv_link_words(payload(), MV_BOARD_IN);
    memcpy(in, payload(), sizeof in);
    const uint32_t begin = mv_board_ticks();
    const int finite = mv_app_step(in, answer.u);
    answer.ticks = mv_board_ticks() - begin;
    if (!finite) answer_flags |= MV_SERVER_NONFINITE;
    count.steps++;
    count.nonfinite += (uint32_t)!finite;
    note_ticks(answer.ticks);
    has_answer = 1;
    silent = 0;
    last_ms = mv_board_ms();
    set_output(answer.u);
    return answer_flags;
}

static int step(uint32_t size)
{
    uint8_t flags = 0;
    if (size != MV_BOARD_IN * sizeof(real)) return MV_SERVER_WRONG_SIZE;
    if (!ready) {
        memset(&answer, 0, sizeof answer);
    } else if (repeated && has_answer) {
        count.duplicates++;
        flags = (uint8_t)(answer_flags | MV_SERVER_DUPLICATE);
    } else {
        flags = evaluate();
    }
    reply(flags, put32(put_words(payload(), answer.u, sizeof answer.u), answer.ticks));
    return 0;
}

static int get(uint32_t size)
{
    uint32_t numbers = 0;
    const real *group = size == 1 ? mv_app_group(payload()[0], &numbers) : 0;
    if (!group) return MV_SERVER_WRONG_SIZE;
    reply(0, put_words(payload(), group, numbers * (uint32_t)sizeof *group));
    return 0;
}

/* After its memory is set, the law is ready to start or continue. */
static int set(uint32_t size)
{
    uint32_t numbers = 0;
    const uint32_t which = payload()[0];
    real *group = size >= 1 ? mv_app_group(which, &numbers) : 0;
    if (!group || size != 1 + numbers * sizeof *group) return MV_SERVER_WRONG_SIZE;
    mv_link_words(payload() + 1, numbers);
    if (!mv_app_finite(payload() + 1, numbers)) return MV_SERVER_NOT_FINITE;
    if (!mv_app_settable(which, payload() + 1)) return MV_SERVER_CONSTANT;
    memcpy(group, payload() + 1, numbers * sizeof *group);
    if (which == MV_APP_MEMORY) {
        ready = 1;
        has_answer = 0;
    }
    reply(0, payload());
    return 0;
}

static int stats(uint32_t size)
{
    uint32_t used = 0, available = 0;
    if (size != 0) return MV_SERVER_WRONG_SIZE;
    mv_board_stack(&used, &available);
    uint8_t *to = put_words(payload(), &count, sizeof count);
    to = put32(put32(to, used), available);
    to = put32(put32(to, line.frames), line.crc);
    to = put32(put32(to, line.length), line.cobs);
    to = put32(to, mv_board_ms());
    reply(0, put_words(to, output, sizeof output));
    return 0;
}

static int selftest(uint32_t size)
{
    uint32_t samples = 0;
    if (size != sizeof samples) return MV_SERVER_WRONG_SIZE;
    mv_link_words(payload(), 1);
    memcpy(&samples, payload(), sizeof samples);
    if (!(repeated && has_test)) {
        if (!ready) return MV_SERVER_NO_MEMORY;
        ready = 0;
        forget_steps();
        mv_app_selftest(samples, &test);
        has_test = 1;
    }
    reply(test.samples < samples ? MV_SERVER_ABORTED : 0, put_words(payload(), &test, sizeof test));
    return 0;
}

/* Serve a host that sends a hello, unless another host's law is running; its memory and parameters are reset. */
static int admit_host(uint32_t size)
{
    if (line.frame.bytes[0] != MV_SERVER_HELLO || frame_session() == 0) return MV_SERVER_NO_SESSION;
    if (driven || (has_answer && !silent)) return MV_SERVER_BUSY;
    if (size != 0) return MV_SERVER_WRONG_SIZE;
    forget_all();
    session = frame_session();
    last = frame_number();
    last_type = MV_SERVER_HELLO;
    served = 0;
    return 0;
}

/* Requests of a session are numbered. The last one may be repeated, because its reply may have been lost; late requests are
 * refused. A hello may skip numbers, because requests before it may have been lost. A refused request uses its number, so
 * that a late refusal cannot be mistaken for one of the next request. */
static int admit(uint32_t size)
{
    const uint8_t type = line.frame.bytes[0];
    repeated = 0;
    if (session == 0 || frame_session() != session) return admit_host(size);
    const uint32_t ahead = frame_number() - last;
    if (ahead == 0 && type == last_type) {
        repeated = served;
        return 0;
    }
    if (ahead != 1 && (type != MV_SERVER_HELLO || ahead - 1u >= 0x7FFFFFFFu)) return MV_SERVER_OUT_OF_TURN;
    last = frame_number();
    last_type = type;
    served = 0;
    return 0;
}

static int serve(uint32_t size)
{
    switch (line.frame.bytes[0]) {
    case MV_SERVER_HELLO: return hello(size);
    case MV_SERVER_RESET: return reset(size);
    case MV_SERVER_STEP: return step(size);
    case MV_SERVER_GET: return get(size);
    case MV_SERVER_SET: return set(size);
    case MV_SERVER_STATS: return stats(size);
    case MV_SERVER_SELFTEST: return selftest(size);
    case MV_SERVER_REBOOT: mv_board_reset(); return 0;
    default: return MV_SERVER_UNKNOWN_TYPE;
    }
}

static void handle(uint32_t size)
{
    int reason = admit(size);
    if (reason == 0) {
        reason = serve(size);
        served |= reason == 0;
    }
    if (reason == 0) return;
    count.refused++;
    refuse((uint8_t)reason);
}

void mv_server_init(void)
{
    forget_all();
    session = 0;
}

void mv_server_byte(uint8_t byte)
{
    const int size = mv_link_receive(&line, byte);
    if (size >= 0) handle((uint32_t)size);
}

/* Hold the outputs for two samples after the last step, whatever the line receives, then clear them. */
void mv_server_watch(uint32_t ms)
{
    if (!(driven || (has_answer && !silent)) || ms - last_ms <= 2u * MV_BOARD_PERIOD_MS) return;
    silent = 1;
    count.lost++;
    clear_output();
}
