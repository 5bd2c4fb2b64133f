/* For the tests of stairscan.h: a scanner, the clock, the chair's travel, and how to send it sentences; random numbers. */
#ifndef STAIRSCAN_CHECK_H
#define STAIRSCAN_CHECK_H

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../stairscan.h"

static stairscan_t scanner;
static uint32_t now;
static int32_t travel;
static unsigned checks;

#define CHECK(what)                                                  \
    do {                                                             \
        checks++;                                                    \
        if (!(what)) {                                               \
            fprintf(stderr, "line %d: not so: %s\n", __LINE__, #what); \
            exit(1);                                                 \
        }                                                            \
    } while (0)

/* Processes these bytes; returns the last event. */
static enum stairscan_event take(const char *bytes, size_t length) {
    enum stairscan_event last = STAIRSCAN_NOTHING;
    size_t k;
    for (k = 0; k < length; k++) {
        enum stairscan_event event = stairscan_take(&scanner, bytes[k], now, travel);
        last = event != STAIRSCAN_NOTHING ? event : last;
    }
    return last;
}

/* Frames a body and sends it. */
static enum stairscan_event send(const char *body) {
    char line[512];
    uint32_t crc = stairscan_crc32(body, strlen(body));
    int length = snprintf(line, sizeof line, "$%s*%08" PRIX32 "\r\n", body, crc);
    return take(line, (size_t)length);
}

#define LIVE(state, scan, uptime) "PSTR,LIVE," state "," scan "," uptime ",100,good,0,0,0,0"

static void start(void) {
    stairscan_rules_t rules = stairscan_default_rules();
    stairscan_init(&scanner, &rules);
    now = 0xFFFFF000u; /* the clock is about to wrap */
    travel = 1000;
}

static uint32_t seed = 1;

/* Returns a random number below `end` (xorshift). */
static uint32_t below(uint32_t end) {
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    return seed % end;
}

#endif
