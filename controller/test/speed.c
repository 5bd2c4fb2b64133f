/* Tests the speed limit of stairscan.h: against its inequality in 128 bits, for monotonicity, and in a closed
 * loop with a simulated chair. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../stairscan.h"

__extension__ typedef unsigned __int128 wide;

static unsigned long checks;

/* Arguments in the order of `names`. */
#define ARGUMENTS 6
enum { FREE, AGE, FASTEST, LATENCY, DECELERATION, OLDEST };
static const char *const names[ARGUMENTS] = {"free", "age", "fastest", "latency", "deceleration", "oldest"};

static uint32_t limit(const uint32_t *with) {
    stairscan_ground_t ground;
    stairscan_chair_t chair;
    ground.free_mm = with[FREE];
    ground.age_ms = with[AGE];
    ground.fastest_mm_s = with[FASTEST];
    chair.latency_ms = with[LATENCY];
    chair.deceleration_mm_s2 = with[DECELERATION];
    chair.oldest_ms = with[OLDEST];
    return stairscan_max_speed(&ground, &chair);
}

static void check(int holds, const char *what, const uint32_t *with) {
    int k;
    checks++;
    if (holds) {
        return;
    }
    fprintf(stderr, "%s: limit %lu at", what, (unsigned long)limit(with));
    for (k = 0; k < ARGUMENTS; k++) {
        fprintf(stderr, " %s %lu", names[k], (unsigned long)with[k]);
    }
    fprintf(stderr, "\n");
    exit(1);
}

/* The inequality of the header, times 1000 * deceleration. */
static int stops(uint64_t speed, const uint32_t *with) {
    uint64_t reaction = speed > with[FASTEST] ? speed : with[FASTEST];
    wide way = (wide)with[FASTEST] * with[AGE] + (wide)reaction * with[LATENCY];
    return way * with[DECELERATION] + (wide)500 * speed * speed <= (wide)1000 * with[FREE] * with[DECELERATION];
}

/* Checks that the limit stops in time, and the next larger speed does not. */
static void is_the_largest(const uint32_t *with) {
    uint32_t speed = limit(with);
    if (with[AGE] > with[OLDEST] || with[DECELERATION] == 0) {
        check(speed == 0, "old or without a brake", with);
        return;
    }
    check(speed == 0 || stops(speed, with), "overshoots", with);
    check(speed == UINT32_MAX || !stops((uint64_t)speed + 1, with), "not the largest", with);
    /* Without the chair's earlier speed: its reaction and braking only. */
    check((wide)with[DECELERATION] * speed * with[LATENCY] + (wide)500 * speed * speed <=
              (wide)1000 * with[FREE] * with[DECELERATION],
          "overshoots by itself", with);
    check(with[FREE] > 0 || speed == 0, "drives without free ground", with);
}

/* Checks that a larger argument never changes the limit in the wrong direction. */
static void is_monotone(const uint32_t *with, int argument, uint32_t larger) {
    uint32_t other[ARGUMENTS];
    uint32_t speed = limit(with);
    memcpy(other, with, sizeof other);
    other[argument] = larger;
    if (argument == FREE || argument == DECELERATION || argument == OLDEST) {
        check(limit(other) >= speed, names[argument], with);
    } else {
        check(limit(other) <= speed, names[argument], with);
    }
}

/* Every combination of limits and values near powers of two. */
static void at_the_ends(void) {
    static const uint32_t ends[] = {0, 1, 2, 999, 1000, 65535, 65536, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFE, 0xFFFFFFFF};
    enum { ENDS = sizeof ends / sizeof ends[0] };
    unsigned long all = 1, at;
    int k;
    for (k = 0; k < ARGUMENTS - 1; k++) {
        all *= ENDS;
    }
    for (at = 0; at < all; at++) {
        uint32_t with[ARGUMENTS];
        unsigned long rest = at;
        for (k = 0; k < ARGUMENTS - 1; k++) {
            with[k] = ends[rest % ENDS];
            rest /= ENDS;
        }
        with[OLDEST] = with[AGE];
        is_the_largest(with);
        for (k = 0; k < ARGUMENTS - 1; k++) {
            if (k != AGE && with[k] < UINT32_MAX) {
                is_monotone(with, k, with[k] + 1);
            }
        }
        if (with[AGE] > 0) {
            with[OLDEST] = with[AGE] - 1;
            check(limit(with) == 0, "too old", with);
        }
    }
}

/* Every small value: the results are small, too, and each is met exactly. */
static void among_small_values(void) {
    uint32_t with[ARGUMENTS] = {0, 0, 0, 0, 0, 3};
    for (with[FREE] = 0; with[FREE] <= 60; with[FREE]++) {
        for (with[LATENCY] = 0; with[LATENCY] <= 300; with[LATENCY] += 60) {
            for (with[DECELERATION] = 0; with[DECELERATION] <= 40; with[DECELERATION]++) {
                for (with[AGE] = 0; with[AGE] <= 4; with[AGE]++) {
                    for (with[FASTEST] = 0; with[FASTEST] <= 60; with[FASTEST] += 15) {
                        is_the_largest(with);
                    }
                }
            }
        }
    }
}

static uint32_t seed = 1;

static uint32_t random_bits(void) {
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    return seed;
}

/* Returns a random number whose number of bits is uniformly distributed. */
static uint32_t of_any_size(void) {
    uint32_t size = random_bits() % 32;
    return random_bits() >> size;
}

static void at_random(unsigned long rounds) {
    unsigned long round, driving = 0;
    for (round = 0; round < rounds; round++) {
        uint32_t with[ARGUMENTS];
        int k;
        for (k = 0; k < ARGUMENTS; k++) {
            with[k] = of_any_size();
        }
        if (round % 2 == 0) {
            /* Realistic ranges: with most of the others no speed is permitted. */
            with[AGE] %= 500;
            with[FASTEST] %= 3000;
            with[LATENCY] %= 1000;
            with[OLDEST] |= with[AGE];
        }
        driving += limit(with) > 0;
        is_the_largest(with);
        for (k = 0; k < ARGUMENTS; k++) {
            uint32_t more = of_any_size();
            is_monotone(with, k, more > UINT32_MAX - with[k] ? UINT32_MAX : with[k] + more);
        }
    }
    checks++;
    if (driving < rounds / 5) {
        fprintf(stderr, "only %lu of %lu have a limit above 0\n", driving, rounds);
        exit(1);
    }
}

static uint32_t between(uint32_t least, uint32_t most) {
    return least + random_bits() % (most - least + 1);
}

#define LONGEST_MS 2048 /* length of the history of commands and speeds */

/* Simulates a chair with a dead time, a deceleration and a randomly moved joystick, which only knows a free
 * distance measured now and then. Returns the minimum distance to the end, mm. */
static uint32_t drive(void) {
    static uint32_t commands[LONGEST_MS], speeds[LONGEST_MS]; /* mm/s, by ms, as rings */
    uint32_t cycle = between(1, 50), dead = between(0, 300), sweep = between(cycle, 400);
    uint32_t joystick = between(0, 1500), accelerates = between(200, 4000);
    uint32_t with[ARGUMENTS] = {0, 0, 0, 0, 0, 1000};
    uint64_t end_nm = (uint64_t)between(0, 4000) * 1000000, at_nm = 0;
    uint32_t speed_um_s = 0, command = 0, measured_mm = 0, measured_at = 0, now, k;
    with[LATENCY] = cycle + dead;
    with[DECELERATION] = between(200, 4000);
    memset(commands, 0, sizeof commands);
    memset(speeds, 0, sizeof speeds);
    for (now = 0; now < 20000; now++) {
        uint32_t target_um_s;
        if (now % sweep == 0) {
            measured_mm = (uint32_t)((end_nm - at_nm) / 1000000);
            measured_at = now;
        }
        if (now % cycle == 0) {
            with[FREE] = measured_mm;
            with[AGE] = now - measured_at;
            with[FASTEST] = 0;
            for (k = 0; k <= with[AGE] + with[LATENCY] && k <= now; k++) {
                uint32_t then = (now - k) % LONGEST_MS;
                with[FASTEST] = speeds[then] > with[FASTEST] ? speeds[then] : with[FASTEST];
                with[FASTEST] = k > 0 && commands[then] > with[FASTEST] ? commands[then] : with[FASTEST];
            }
            joystick = between(0, 20) == 0 ? between(0, 1500) : joystick;
            command = limit(with);
            command = joystick < command ? joystick : command;
        }
        commands[now % LONGEST_MS] = command;
        target_um_s = now >= dead ? commands[(now - dead) % LONGEST_MS] * 1000 : 0;
        if (speed_um_s > target_um_s) {
            uint32_t less = speed_um_s - target_um_s;
            speed_um_s -= less < with[DECELERATION] ? less : with[DECELERATION];
        } else {
            uint32_t more = target_um_s - speed_um_s;
            speed_um_s += more < accelerates ? more : accelerates;
        }
        at_nm += speed_um_s;
        speeds[(now + 1) % LONGEST_MS] = (speed_um_s + 999) / 1000;
        check(at_nm <= end_nm, "the chair goes over the end", with);
    }
    return (uint32_t)((end_nm - at_nm) / 1000000);
}

static void closed_loops(unsigned rounds) {
    unsigned round, near = 0;
    for (round = 0; round < rounds; round++) {
        near += drive() <= 100;
    }
    checks++;
    /* In the others the joystick limits the speed, or the chair is slow. */
    if (near < rounds * 3 / 4) {
        fprintf(stderr, "only %u of %u drives come within 100 mm of the end\n", near, rounds);
        exit(1);
    }
}

int main(void) {
    at_the_ends();
    among_small_values();
    at_random(300000);
    closed_loops(400);
    printf("the speed limit holds: %lu checks\n", checks);
    return 0;
}
