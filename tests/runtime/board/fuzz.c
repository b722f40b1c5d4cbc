/* SPDX-License-Identifier: Apache-2.0 */
/* Throws frames at the server: whole ones, damaged ones, old ones, noise. Usage: fuzz SEED FRAMES; prints what became of
 * them. With -DGUIDED and clang's -fsanitize=fuzzer the choices come from an input that grows with what it covers. Each
 * reply is decoded, and what it says is compared with what changed:
 *   a reply carries type, session and number of the frame it answers;
 *   a refusal changes neither outputs, memory nor parameters;
 *   a step is evaluated at most once for each number, and only a step changes the outputs, but for going to zero;
 *   a step that is answered as before has the number of the step that was evaluated;
 *   memory, parameters and outputs are finite;
 *   outputs that nobody renewed for two samples are zero. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "process.h"
#include "mehvar/private/app.h"

enum { WATCH_MS = 2 * MV_BOARD_PERIOD_MS, STEP_BYTES = 4 * MV_BOARD_IN, TURN = 10 };

static uint64_t state;
static const uint8_t *choices; /* of a guided run; then 0 */
static size_t choices_left;
static uint32_t number, evaluated_at, evaluated;
static int any_evaluated;
static uint8_t wish; /* what a host would send next, or 0 */
static long frames, answers, refusals, evaluations, duplicates, lost;

static void fail(const char *what)
{
    fprintf(stderr, "%s\n", what); /* abort does not empty stdout */
    abort();
}

static uint32_t draw(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (uint32_t)(state >> 16);
}

/* A choice; a guided run's come from its input. What payloads hold is drawn, or one memory would use up an input. */
static uint32_t next(void)
{
    if (choices_left < 2) return draw();
    const uint32_t choice = choices[0] | (uint32_t)choices[1] << 8;
    choices += 2;
    choices_left -= 2;
    return choice | (choice * 40503u) << 16; /* two bytes decide on all four */
}

static uint32_t below(uint32_t n) { return next() % n; }

static void put(uint8_t *to, uint32_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) to[i] = (uint8_t)(value >> 8 * i);
}

static uint32_t get(const uint8_t *from, int bytes)
{
    uint32_t value = 0;
    for (int i = bytes - 1; i >= 0; i--) value = value << 8 | from[i];
    return value;
}

static int all_finite(const mv_real *v, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++)
        if (!isfinite(v[i])) return 0;
    return 1;
}

static int driven(void)
{
    for (int i = 0; i < MV_BOARD_NU; i++)
        if (actuators[i] != 0) return 1;
    return 0;
}

/* CRC over all that a refusal must leave as it is. */
static uint32_t fingerprint(void)
{
    uint32_t crc = 0;
    for (uint32_t group = 0; group < MV_APP_GROUPS; group++) {
        uint32_t n = 0;
        const mv_real *v = mv_app_group(group, &n);
        if (!all_finite(v, n)) fail("a number of the board is not finite");
        crc = crc * 31 + mv_link_crc((const uint8_t *)v, n * (uint32_t)sizeof *v);
    }
    return crc * 31 + mv_link_crc((const uint8_t *)actuators, sizeof actuators);
}

/* header and payload of a request, most of them sensible */
static uint32_t request(uint8_t *to, uint32_t number)
{
    static const uint8_t types[] = {1, 2, 3, 3, 3, 3, 3, 3, 4, 5, 5, 5, 6, 7, 8};
    static const uint32_t groups[] = {MV_BOARD_NZ, MV_BOARD_NP, MV_BOARD_NC, MV_BOARD_NS};
    const uint8_t usual = types[below(sizeof types)], type = wish && below(4) ? wish : usual;
    const uint32_t which = wish || below(2) ? MV_APP_MEMORY : below(4);
    const uint32_t sizes[] = {0, 0, 0, STEP_BYTES, 1, 1 + 4 * groups[which], 0, 4, 0};
    uint32_t size = below(20) ? sizes[type] : below(MV_LINK_MAX + 40);
    to[0] = below(20) ? type : (uint8_t)next();
    to[1] = (uint8_t)next();
    put(to + 2, below(50) ? 1 : below(3), 2);
    put(to + 4, number, 4);
    uint8_t *payload = to + MV_LINK_HEADER;
    for (uint32_t i = 0; i < size; i++) payload[i] = (uint8_t)draw();
    const uint32_t offset = type == MV_SERVER_SET;
    const uint32_t sound = below(5) ? size : below(MV_LINK_MAX); /* numbers up to here, then any bits */
    for (uint32_t i = 0; i + 4 + offset <= size && i < sound; i += 4) {
        const float value = (float)(draw() % 2000) * 1e-3f - 1.0f;
        memcpy(payload + i + offset, &value, sizeof value);
    }
    if (type == MV_SERVER_GET || type == MV_SERVER_SET) payload[0] = (uint8_t)(below(10) ? which : next());
    if (type == MV_SERVER_SELFTEST && size == 4) put(payload, below(3), 4);
    return MV_LINK_HEADER + size;
}

static uint32_t stuffed(const uint8_t *from, uint32_t size, uint8_t *to)
{
    uint32_t n = 0, code = n++;
    to[code] = 1;
    for (uint32_t i = 0; i < size; i++) {
        if (from[i] != 0) {
            to[n++] = from[i];
            to[code]++;
        }
        if (from[i] == 0 || to[code] == 0xFF) {
            code = n++;
            to[code] = 1;
        }
    }
    return n;
}

/* header and payload of the only frame in what the board sent */
static uint32_t unstuffed(uint8_t *to)
{
    if (sent_size < 3 || sent[0] != 0 || sent[sent_size - 1] != 0) fail("a reply without its zeros");
    uint32_t n = 0;
    for (uint32_t at = 1; at < sent_size - 1;) {
        const uint32_t code = sent[at++];
        if (code == 0 || at + code - 1 > sent_size - 1) fail("a reply whose blocks do not fit");
        for (uint32_t i = 1; i < code; i++) to[n++] = sent[at++];
        if (code != 0xFF && at < sent_size - 1) to[n++] = 0;
    }
    if (n < MV_LINK_SMALLEST || mv_link_crc(to, n - MV_LINK_CRC) != get(to + n - MV_LINK_CRC, 4))
        fail("a reply with a wrong check");
    return n - MV_LINK_CRC;
}

static uint32_t damaged(uint8_t *bytes, uint32_t size)
{
    const uint32_t at = below(size);
    switch (below(4)) {
    case 0: bytes[at] ^= (uint8_t)(1u << below(8)); return size;
    case 1: memmove(bytes + at, bytes + at + 1, size - at - 1); return size - 1;
    case 2: memmove(bytes + at + 1, bytes + at, size - at); bytes[at] = (uint8_t)next(); return size + 1;
    default: return at;
    }
}

/* One frame, and what must hold after it. */
static void throw_one(void)
{
    static uint8_t plain[2 * MV_LINK_MAX], line[4 * MV_LINK_MAX], back[4 * MV_LINK_MAX];
    frames++;
    const uint32_t turn = below(10);
    number += turn == 0 ? (uint32_t)0 - below(3) : turn == 1 ? below(3) : turn < 4 ? 0 : 1;
    uint32_t size = request(plain, number);
    put(plain + size, mv_link_crc(plain, size) ^ (below(30) ? 0 : next()), 4);
    const uint32_t whole = size + MV_LINK_CRC;
    size = stuffed(plain, whole, line);
    if (below(3) == 0) size = damaged(line, size);
    if (below(50) == 0)
        for (uint32_t noise = below(3 * MV_LINK_MAX); noise > 0; noise--) mv_server_byte((uint8_t)draw());
    mv_server_byte(0);
    sent_size = 0;
    const uint32_t before = fingerprint();
    mv_real outputs[MV_BOARD_NU];
    memcpy(outputs, actuators, sizeof outputs);
    for (uint32_t i = 0; i < size; i++) mv_server_byte(line[i]);
    mv_server_byte(0);
    const uint32_t after = fingerprint();
    if (!all_finite(actuators, MV_BOARD_NU)) fail("an output is not finite");
    if (sent_size == 0) {
        if (after != before && plain[0] != MV_SERVER_REBOOT) fail("what was not answered changed the board");
    } else {
        const uint32_t reply = unstuffed(back);
        answers++;
        if (memcmp(back + 2, plain + 2, 6) != 0) fail("a reply to another session or number");
        if (back[0] == (MV_SERVER_NAK | MV_SERVER_REPLY)) {
            refusals++;
            if (back[MV_LINK_HEADER] == MV_SERVER_OUT_OF_TURN) number = get(back + MV_LINK_HEADER + 1, 4);
            if (back[MV_LINK_HEADER] == MV_SERVER_NO_SESSION) wish = MV_SERVER_HELLO;
            if (after != before) fail("a refused request changed the board");
        } else if (back[0] != (plain[0] | MV_SERVER_REPLY)) {
            fail("a reply of another type");
        } else if (plain[0] == MV_SERVER_STEP && !(back[1] & MV_SERVER_FRESH)) {
            if (reply != MV_LINK_HEADER + sizeof actuators + 4) fail("an answer of the wrong size");
            if (back[1] & MV_SERVER_DUPLICATE) {
                duplicates++;
                if (after != before) fail("a step that came again changed the board");
                if (evaluations == 0 || evaluated != number) fail("a step has the answer of another one");
            } else {
                if (any_evaluated && evaluated == number) fail("a step was evaluated twice");
                evaluations++;
                evaluated = number, any_evaluated = 1;
                evaluated_at = ms;
                if (memcmp(back + MV_LINK_HEADER, actuators, sizeof actuators) != 0) fail("outputs not as answered");
            }
        } else if (memcmp(outputs, actuators, sizeof outputs) != 0 && driven()) {
            fail("something else than a step changed the outputs");
        }
        if (back[0] != (MV_SERVER_NAK | MV_SERVER_REPLY)) {
            wish = back[1] & MV_SERVER_FRESH ? MV_SERVER_SET : 0;
            if (plain[0] == MV_SERVER_HELLO || plain[0] == MV_SERVER_RESET || plain[0] == MV_SERVER_SET) any_evaluated = 0;
        }
    }
    if (plain[0] == MV_SERVER_REBOOT) any_evaluated = 0;
    const int was_driven = driven();
    pass(below(8) ? below(MV_BOARD_PERIOD_MS) : below(3 * MV_BOARD_PERIOD_MS));
    if (driven() && ms - evaluated_at > WATCH_MS + TURN) fail("outputs are held for more than two samples");
    lost += was_driven && !driven();
}

static void report(void)
{
    printf("%ld frames sent, %ld answers, %ld refusals, %ld steps evaluated, %ld again, %ld outputs cleared\n", frames,
           answers, refusals, evaluations, duplicates, lost);
}

#ifdef GUIDED
int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc, (void)argv;
    return atexit(report);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    choices = data;
    choices_left = size;
    state = 1;
    number = 0;
    any_evaluated = 0;
    wish = 0;
    memset(actuators, 0, sizeof actuators);
    mv_server_init();
    while (choices_left >= 2) throw_one();
    return 0;
}
#else
int main(int argc, char **argv)
{
    state = argc > 1 ? strtoull(argv[1], 0, 10) * 2654435761u + 1 : 1;
    mv_server_init();
    for (long left = argc > 2 ? atol(argv[2]) : 0; left > 0; left--) throw_one();
    report();
    return 0;
}
#endif
