/* Example: limits the command of a joystick by the scanner's free distance; it is never increased. A controller
 * uses `limited`. The rest is a simulated drive towards a kerb, with the scanner's sentences, an odometer and a
 * chair with a delay.
 *
 *   cc -std=c99 controller/stairscan.c controller/speed_limit.c -o speed_limit
 *   ./speed_limit          the drive
 *   ./speed_limit table    speed limits for free distances
 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "stairscan.h"

#define CYCLE_MS 20u
#define DEAD_MS 180u /* time from a command until it acts on the wheels */

/* Constants of an example chair. Measure those of your chair. */
static const stairscan_chair_t CHAIR = {CYCLE_MS + DEAD_MS, 1000, 100};

/* Maximum age of the odometer's reading when a command is calculated. */
#define ODOMETER_MS CYCLE_MS

/* Number of cycles over which the maximum speed is taken: from the odometer's reading until the command acts. */
#define RECENT ((ODOMETER_MS + CYCLE_MS + DEAD_MS) / CYCLE_MS + 1u)

/* The parser's state, and the speeds of the last cycles. */
struct limiter {
    stairscan_t scanner;
    uint32_t recent_mm_s[RECENT];
    uint32_t next;
};

static uint32_t larger(uint32_t a, uint32_t b) {
    return a > b ? a : b;
}

/* Returns the speed limit, mm/s. `measured_mm_s` is the chair's forward speed. */
static uint32_t speed_limit(struct limiter *limiter, uint32_t measured_mm_s, uint32_t now_ms, int32_t travel) {
    stairscan_ground_t ground;
    uint32_t k;
    ground.free_mm = stairscan_free_mm(&limiter->scanner, now_ms, travel);
    ground.age_ms = ODOMETER_MS;
    ground.fastest_mm_s = measured_mm_s;
    for (k = 0; k < RECENT; k++) {
        ground.fastest_mm_s = larger(ground.fastest_mm_s, limiter->recent_mm_s[k]);
    }
    return stairscan_max_speed(&ground, &CHAIR);
}

/* Returns the joystick's command, reduced to the limit. Backward commands are passed on: the scanner only looks
 * ahead. */
static int32_t limited(struct limiter *limiter, int32_t joystick_mm_s, uint32_t measured_mm_s, uint32_t limit_mm_s) {
    int32_t command = joystick_mm_s;
    if (command > 0 && (uint32_t)command > limit_mm_s) {
        command = (int32_t)limit_mm_s; /* below `command`, so within an int32_t */
    }
    limiter->recent_mm_s[limiter->next] = larger(measured_mm_s, command > 0 ? (uint32_t)command : 0);
    limiter->next = (limiter->next + 1) % RECENT;
    return command;
}

/* ---- a simulated drive ---- */

#define KERB_MM 1800     /* distance from the mirror at the start of the drive */
#define HORIZON_MM 1500  /* horizon of every answer */
#define SCAN_MS 800u     /* interval of answers */
#define LIVE_MS 200u     /* interval of LIVE */
#define UNPLUGGED_MS 9000u /* time after which no sentence is received */
#define END_MS 10400u
#define SHOWN_MS 400u
#define DEAD (DEAD_MS / CYCLE_MS)

struct drive {
    struct limiter limiter;
    uint32_t now_ms;
    uint32_t scan;
    int32_t travel_um;
    int32_t speed_mm_s;
    int32_t commands[DEAD]; /* ring of commands that have not acted yet */
};

/* The odometer's reading, 0.1 mm, rounded up. */
static int32_t odometer(const struct drive *drive) {
    return (drive->travel_um + (drive->travel_um > 0 ? 99 : 0)) / 100;
}

/* Sends a sentence to the parser in the scanner's format. */
static void send(struct drive *drive, const stairscan_sentence_t *sentence) {
    stairscan_line_t line;
    size_t k;
    stairscan_write(sentence, &line);
    for (k = 0; k < line.length; k++) {
        (void)stairscan_take(&drive->limiter.scanner, line.bytes[k], drive->now_ms, odometer(drive));
    }
}

static void scan(struct drive *drive) {
    int32_t kerb = KERB_MM * 10 - odometer(drive);
    stairscan_sentence_t sentence;
    memset(&sentence, 0, sizeof sentence);
    sentence.kind = STAIRSCAN_SCAN;
    sentence.as.scan.scan = ++drive->scan;
    sentence.as.scan.status = STAIRSCAN_OK;
    sentence.as.scan.steps = kerb < HORIZON_MM * 10;
    sentence.as.scan.direction = sentence.as.scan.steps > 0 ? STAIRSCAN_UP : STAIRSCAN_NONE;
    sentence.as.scan.horizon.present = sentence.as.scan.confidence.present = true;
    sentence.as.scan.horizon.value = HORIZON_MM * 10;
    sentence.as.scan.confidence.value = 992;
    send(drive, &sentence);
    if (kerb < HORIZON_MM * 10) {
        memset(&sentence, 0, sizeof sentence);
        sentence.kind = STAIRSCAN_STEP;
        sentence.as.step.scan = drive->scan;
        sentence.as.step.index = sentence.as.step.count = 1;
        sentence.as.step.distance = kerb;
        sentence.as.step.height = 1200;
        sentence.as.step.distance_sigma = sentence.as.step.height_sigma = 20;
        sentence.as.step.quality = 90;
        send(drive, &sentence);
    }
}

static void live(struct drive *drive) {
    stairscan_sentence_t sentence;
    memset(&sentence, 0, sizeof sentence);
    sentence.kind = STAIRSCAN_LIVE;
    sentence.as.live.state = stairscan_text("scanning");
    sentence.as.live.motion = stairscan_text("good");
    sentence.as.live.scan = drive->scan + 1;
    sentence.as.live.uptime_ms = drive->now_ms + 60000;
    send(drive, &sentence);
}

/* Full ahead, back a little, full ahead again. */
static int32_t joystick(uint32_t now_ms) {
    if (now_ms < 400) {
        return 0;
    }
    return now_ms >= 6000 && now_ms < 7600 ? -400 : 900;
}

/* Simulates one cycle of a chair. A command acts after the dead time, with 500 mm/s^2 or, when braking, the
 * deceleration of CHAIR. */
static void move(struct drive *drive, int32_t command) {
    int32_t *late = &drive->commands[drive->now_ms / CYCLE_MS % DEAD];
    int32_t change = *late - drive->speed_mm_s;
    int32_t most = (*late < 0 ? -*late : *late) > (drive->speed_mm_s < 0 ? -drive->speed_mm_s : drive->speed_mm_s)
                       ? 500 * (int32_t)CYCLE_MS / 1000
                       : (int32_t)(CHAIR.deceleration_mm_s2 * CYCLE_MS / 1000);
    *late = command;
    change = change > most ? most : change;
    change = change < -most ? -most : change;
    drive->speed_mm_s += change;
    drive->travel_um += drive->speed_mm_s * (int32_t)CYCLE_MS;
}

static int simulate(void) {
    static struct drive drive;
    stairscan_rules_t rules = stairscan_default_rules();
    stairscan_init(&drive.limiter.scanner, &rules);
    printf("  time  travel  to kerb    free   limit  joystick  command   speed\n");
    printf("    ms      mm       mm      mm    mm/s      mm/s     mm/s    mm/s\n");
    for (drive.now_ms = 0; drive.now_ms <= END_MS; drive.now_ms += CYCLE_MS) {
        uint32_t now = drive.now_ms;
        uint32_t measured = drive.speed_mm_s > 0 ? (uint32_t)drive.speed_mm_s : 0;
        int32_t wanted = joystick(now);
        uint32_t limit;
        int32_t command;
        if (now < UNPLUGGED_MS && now % SCAN_MS == 0) {
            scan(&drive);
        }
        if (now < UNPLUGGED_MS && now % LIVE_MS == 0) {
            live(&drive);
        }
        limit = speed_limit(&drive.limiter, measured, now, odometer(&drive));
        command = limited(&drive.limiter, wanted, measured, limit);
        if (now % SHOWN_MS == 0) {
            printf("%6" PRIu32 "%8" PRId32 "%9" PRId32 "%8" PRIu32 "%8" PRIu32 "%10" PRId32 "%9" PRId32 "%8" PRId32 "\n",
                   now, drive.travel_um / 1000, KERB_MM - drive.travel_um / 1000,
                   stairscan_free_mm(&drive.limiter.scanner, now, odometer(&drive)), limit, wanted, command,
                   drive.speed_mm_s);
        }
        move(&drive, command);
        if (drive.travel_um > KERB_MM * 1000 || command > (wanted > 0 ? wanted : 0)) {
            printf("the chair is at the kerb, or faster than the joystick says\n");
            return 1;
        }
    }
    return 0;
}

/* ---- speed limits for free distances ---- */

static int table(void) {
    static const uint32_t free_mm[] = {0, 50, 100, 200, 300, 500, 750, 1000, 1500, 2000, 3000};
    /* CHAIR; a slower reaction; a weaker brake; CHAIR with a sweep 100 ms ago and 500 mm/s since then. */
    static const stairscan_chair_t chairs[] = {{200, 1000, 100}, {400, 1000, 100}, {200, 500, 100}, {200, 1000, 100}};
    stairscan_ground_t ground = {0, 0, 0};
    size_t row, column;
    printf("| free, mm | 200 ms, 1,000 mm/s² | 400 ms, 1,000 mm/s² | 200 ms, 500 mm/s² "
           "| as the first, 100 ms old at 500 mm/s |\n|---|---|---|---|---|\n");
    for (row = 0; row < sizeof free_mm / sizeof free_mm[0]; row++) {
        ground.free_mm = free_mm[row];
        printf("| %" PRIu32, ground.free_mm);
        for (column = 0; column < 4; column++) {
            ground.age_ms = column == 3 ? 100 : 0;
            ground.fastest_mm_s = column == 3 ? 500 : 0;
            printf(" | %" PRIu32, stairscan_max_speed(&ground, &chairs[column]));
        }
        printf(" |\n");
    }
    return 0;
}

int main(int count, char **arguments) {
    if (count == 2 && strcmp(arguments[1], "table") == 0) {
        return table();
    }
    if (count > 1) {
        fprintf(stderr, "expected no argument or `table`, found: %s\n", arguments[1]);
        return 2;
    }
    return simulate();
}
