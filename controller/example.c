/* A minimal controller of a wheelchair: reads the bytes of the scanner's UART from standard input and prints
 * after each answer what the chair may do, and after each guard sweep how it drives. A real controller makes the
 * same calls in every control cycle, with the UART's byte, a millisecond timer and the odometer.
 *
 *   cc -std=c99 controller/stairscan.c controller/example.c -o example
 *   cargo sim replay recordings/stair_a | grep -o '\$PSTR.*' | ./example
 *   cargo sim replay recordings/guard_kerb | grep -o '\$PSTR.*' | ./example
 */
#include <inttypes.h>
#include <stdio.h>

#include "stairscan.h"

#define WANTED_MM_S 600u  /* the joystick's command */
#define CREEPING_MM_S 100u /* lower limits count as 0 */
#define STANDS_OUT_MM 400u /* footplates before the mirror */

/* Constants of an example chair: latency 200 ms, braking with 1 m/s^2, a sweep counts for 400 ms. Measure those of
 * your chair. */
static const stairscan_chair_t CHAIR = {200, 1000, 400};

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

/* In the order of enum stairscan_why. */
static const char *const WHYS[] = {
    "the answer is ok",         "the answer is degraded",  "it has no horizon",
    "silence",                  "the scanner has a fault", "there is no answer",
    "made with other settings", "the answer is old",       "too far since the answer",
    "no free ground"};

static void show_permit(stairscan_permit_t permit) {
    static const char *const actions[] = {"stop", "hint", "go"};
    printf("  %s: %s", actions[permit.action], WHYS[permit.why]);
    if (permit.action == STAIRSCAN_GO) {
        printf("; valid for %.1f mm, level for %.1f mm", millimetres(permit.vouched),
               millimetres(permit.clear));
    }
    printf("\n");
}

/* Drives by the newest guard sweep: prints the command and its reason, and returns it, mm/s. `speed_mm_s` is the
 * command before. */
static uint32_t drive(stairscan_t *scanner, uint32_t speed_mm_s, uint32_t now, int32_t travel) {
    static const char *const endings[] = {"nothing in range", "a rise", "a drop", "an obstacle", "unknown ground"};
    stairscan_guard_permit_t permit = stairscan_guard_may(scanner, now, travel);
    stairscan_ground_t ground;
    uint32_t limit;
    ground.free_mm = stairscan_guard_free_mm(scanner, now, travel);
    ground.free_mm = ground.free_mm > STANDS_OUT_MM ? ground.free_mm - STANDS_OUT_MM : 0;
    ground.age_ms = permit.age_ms; /* with an odometer: the age of its reading */
    ground.fastest_mm_s = speed_mm_s; /* a real one takes the largest of the last age_ms + latency_ms */
    limit = stairscan_max_speed(&ground, &CHAIR);
    if (permit.action != STAIRSCAN_GO) {
        printf("  stop: %s", WHYS[permit.why]);
    } else if (limit < CREEPING_MM_S) {
        printf("  stop: no braking distance left in %" PRIu32 " mm", ground.free_mm);
    } else if (limit < WANTED_MM_S) {
        printf("  slow, %" PRIu32 " mm/s: free for %" PRIu32 " mm", limit, ground.free_mm);
    } else {
        printf("  go, %u mm/s: free for %" PRIu32 " mm", WANTED_MM_S, ground.free_mm);
    }
    if (permit.action == STAIRSCAN_GO || permit.why == STAIRSCAN_WHY_NEAR) {
        printf(", then %s", endings[permit.ending]);
    }
    printf("\n");
    if (permit.action != STAIRSCAN_GO || limit < CREEPING_MM_S) {
        return 0;
    }
    return limit < WANTED_MM_S ? limit : WANTED_MM_S;
}

/* Returns the chair's command after a guard sweep, or after a sentence that voids it. */
static uint32_t after_sentence(stairscan_t *scanner, uint32_t speed_mm_s, uint32_t now, int32_t travel) {
    const stairscan_sentence_t *last = &scanner->sentence;
    if (last->kind == STAIRSCAN_GUARD) {
        printf("sweep %" PRIu32 "\n", last->as.guard.sweep);
        return drive(scanner, speed_mm_s, now, travel);
    }
    if (speed_mm_s > 0 && stairscan_guard_may(scanner, now, travel).action != STAIRSCAN_GO) {
        return drive(scanner, speed_mm_s, now, travel);
    }
    return speed_mm_s;
}

int main(void) {
    static stairscan_t scanner;
    stairscan_rules_t rules = stairscan_default_rules();
    const int32_t travel = 0; /* an odometer, in 0.1 mm */
    uint32_t speed_mm_s = 0; /* the command by the guard */
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
            speed_mm_s = after_sentence(&scanner, speed_mm_s, now, travel);
            break;
        case STAIRSCAN_NOTHING:
            break;
        }
    }
    /* After a second without a sentence. */
    printf("a second later:\n");
    if (speed_mm_s > 0) {
        (void)drive(&scanner, speed_mm_s, clock_ms(bytes) + 1000, travel);
    } else {
        show_permit(stairscan_may(&scanner, clock_ms(bytes) + 1000, travel));
    }
    return scanner.damaged + scanner.dropped > 0;
}
