/* A minimal controller of a wheelchair: reads the bytes of the scanner's UART from standard input and prints
 * after each sentence what the chair may do. A real controller makes the same calls with the UART's byte, a
 * millisecond timer and the odometer.
 *
 *   cc -std=c99 controller/stairscan.c controller/example.c -o example
 *   cargo sim replay recordings/stair_a | grep -o '\$PSTR.*' | ./example
 */
#include <inttypes.h>
#include <stdio.h>

#include "stairscan.h"

/* Returns the time of a byte at 115,200 baud with 10 bits a byte, without pauses. */
static uint32_t clock_ms(uint32_t bytes) {
    return (uint32_t)((uint64_t)bytes * 10000 / 115200);
}

static double millimetres(int32_t tenths) {
    return tenths / 10.0;
}

static void show_answer(const stairscan_answer_t *answer) {
    static const char *const statuses[] = {"ok", "degraded", "fault"};
    uint32_t k;
    printf("scan %" PRIu32 ": %s", answer->head.scan, statuses[answer->head.status]);
    for (k = 0; k < STAIRSCAN_REASON_COUNT; k++) {
        if ((answer->head.reasons >> k & 1) != 0) {
            printf("\n  %s: %s", stairscan_reason_word(k), stairscan_reason_meaning(k));
        }
    }
    printf("\n");
    for (k = 0; k < answer->head.steps; k++) {
        const stairscan_step_t *step = &answer->steps[k];
        printf("  step %" PRIu32 ": distance %.1f mm, height %.1f mm\n", step->index,
               millimetres(step->distance), millimetres(step->height));
    }
    if (answer->head.drops > 0) {
        printf("  the ground ends at %.1f mm, sigma %.1f mm\n", millimetres(answer->drop.distance),
               millimetres(answer->drop.distance_sigma));
    }
}

static void show_permit(stairscan_permit_t permit) {
    static const char *const actions[] = {"stop", "hint", "go"};
    static const char *const whys[] = {
        "the answer is ok",      "the answer is degraded", "it does not say how far",
        "silence",               "the scanner has a fault", "there is no answer",
        "made with other settings", "the answer is old",   "too far since the answer"};
    printf("  %s: %s", actions[permit.action], whys[permit.why]);
    if (permit.action == STAIRSCAN_GO) {
        printf("; %.1f mm vouched for, %.1f mm of them level", millimetres(permit.vouched),
               millimetres(permit.clear));
    }
    printf("\n");
}

int main(void) {
    static stairscan_t scanner;
    stairscan_rules_t rules = stairscan_default_rules();
    const int32_t travel = 0; /* an odometer, in 0.1 mm */
    uint32_t bytes = 0;
    int byte;
    stairscan_init(&scanner, &rules);
    while ((byte = getchar()) != EOF) {
        uint32_t now = clock_ms(++bytes);
        switch (stairscan_take(&scanner, (char)byte, now, travel)) {
        case STAIRSCAN_ANSWER:
            show_answer(&scanner.answer);
            show_permit(stairscan_may(&scanner, now, travel));
            break;
        case STAIRSCAN_DAMAGED:
            printf("a line is damaged\n");
            break;
        case STAIRSCAN_SENTENCE:
        case STAIRSCAN_NOTHING:
            break;
        }
    }
    /* After a second without a sentence. */
    printf("a second later:\n");
    show_permit(stairscan_may(&scanner, clock_ms(bytes) + 1000, travel));
    return scanner.damaged + scanner.dropped > 0;
}
