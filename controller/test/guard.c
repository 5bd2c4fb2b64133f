/* Tests the rules for driving by guard sweeps of stairscan.h one by one, over damaged streams, and in drives. */
#include "check.h"

#define BOOT(settings) "PSTR,BOOT,0.2.0,abc,power-on,hse-168,1," settings ",000000010000000200000003"
#define STAT(settings) "PSTR,STAT,idle,hse-168,0,likelihood,,good,0," settings
#define GUARD(sweep, free) "PSTR,GUARD," sweep ",ok," free ",rise,99.8,"
#define DEGRADED(sweep) "PSTR,GUARD," sweep ",degraded,900.0,unknown,50.0,lost-rows"
#define FAULT(sweep) "PSTR,GUARD," sweep ",fault,,unknown,0.0,motor-stall"

static bool stops(enum stairscan_why why) {
    stairscan_guard_permit_t permit = stairscan_guard_may(&scanner, now, travel);
    return permit.action == STAIRSCAN_STOP && permit.why == (uint32_t)why && permit.clear == 0 &&
           stairscan_guard_free_mm(&scanner, now, travel) == 0;
}

/* Whether the chair may drive, over this length (0.1 mm). */
static bool goes(int32_t clear) {
    stairscan_guard_permit_t permit = stairscan_guard_may(&scanner, now, travel);
    return permit.action == STAIRSCAN_GO && permit.why == STAIRSCAN_WHY_OK && permit.clear == clear &&
           stairscan_guard_free_mm(&scanner, now, travel) == (uint32_t)clear / 10;
}

static void swept(void) {
    start();
    CHECK(send(GUARD("1", "1000.0")) == STAIRSCAN_SENTENCE);
    CHECK(goes(9400));
}

static void an_ok_sweep_counts_from_where_the_chair_is(void) {
    stairscan_guard_permit_t permit;
    start();
    CHECK(stops(STAIRSCAN_WHY_SILENCE));
    permit = stairscan_guard_may(&scanner, now, travel);
    CHECK(permit.ending == STAIRSCAN_ENDS_UNKNOWN && permit.age_ms == UINT32_MAX);
    CHECK(send("PSTR,DONE,guard") == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_NO_ANSWER));
    swept();
    permit = stairscan_guard_may(&scanner, now + 100, travel);
    CHECK(permit.ending == STAIRSCAN_ENDS_RISE && permit.age_ms == 150);
    travel += 3001;
    CHECK(goes(6399) && stairscan_guard_free_mm(&scanner, now, travel) == 639);
    /* Full scans do not count, nor do sweeps for stairscan_may. */
    CHECK(stairscan_may(&scanner, now, travel).why == STAIRSCAN_WHY_NO_ANSWER);
    CHECK(send("PSTR,SCAN,1,ok,none,0,0,,1500.0,99.1,0,01234567,0") == STAIRSCAN_ANSWER);
    CHECK(goes(6399));
    start();
    CHECK(send("PSTR,SCAN,1,ok,none,0,0,,1500.0,99.1,0,01234567,0") == STAIRSCAN_ANSWER);
    CHECK(stops(STAIRSCAN_WHY_NO_ANSWER));
}

static void the_next_sweep_replaces_it(void) {
    swept();
    CHECK(send(GUARD("2", "1400.0")) == STAIRSCAN_SENTENCE && goes(13400));
    CHECK(send(GUARD("5", "300.0")) == STAIRSCAN_SENTENCE && goes(2400));
    /* After `guard off` and `guard on` the numbers begin again. */
    CHECK(send(GUARD("1", "800.0")) == STAIRSCAN_SENTENCE && goes(7400));
    CHECK(send(DEGRADED("2")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_DEGRADED));
    CHECK(send(GUARD("3", "800.0")) == STAIRSCAN_SENTENCE && goes(7400));
    CHECK(send(FAULT("4")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_FAULT));
    CHECK(send(GUARD("5", "800.0")) == STAIRSCAN_SENTENCE && goes(7400));
    CHECK(send("PSTR,GUARD,6,ok,,unknown,0.0,") == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_NO_HORIZON));
    /* Damage leaves the sweep before, until it is old. */
    CHECK(send(GUARD("7", "800.0")) == STAIRSCAN_SENTENCE && goes(7400));
    CHECK(take("$PSTR,GUARD,8,ok,1800.0,rise,99.8,*00000000\r\n", 45) == STAIRSCAN_DAMAGED && goes(7400));
}

static void a_sweep_that_ends_at_the_chair_stops_it(void) {
    swept();
    CHECK(send(GUARD("2", "60.1")) == STAIRSCAN_SENTENCE && goes(1));
    CHECK(send(GUARD("3", "60.0")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_NEAR));
    CHECK(send(GUARD("4", "-214748364.7")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_NEAR));
    CHECK(stairscan_guard_may(&scanner, now, travel).ending == STAIRSCAN_ENDS_RISE);
    CHECK(send(GUARD("5", "1000.0")) == STAIRSCAN_SENTENCE);
    scanner.rules.margin = 4600; /* footplates */
    CHECK(goes(5400));
}

static void a_sweep_gets_old(void) {
    swept();
    /* 50 ms have passed from its last row until it was received. */
    now += 350;
    CHECK(goes(9400) && stairscan_guard_may(&scanner, now, travel).age_ms == 400);
    now += 1;
    CHECK(stops(STAIRSCAN_WHY_OLD));
    /* It stays old when the clock wraps. */
    scanner.rules.silence_ms = UINT32_MAX;
    now -= 351;
    CHECK(stops(STAIRSCAN_WHY_OLD));
    scanner.rules.silence_ms = 500;
    /* The same sweep again does not renew it, another one does. */
    CHECK(send(GUARD("1", "1000.0")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_OLD));
    CHECK(send(GUARD("2", "1000.0")) == STAIRSCAN_SENTENCE && goes(9400));
    now += 300;
    CHECK(send(GUARD("2", "1000.0")) == STAIRSCAN_SENTENCE && goes(9400));
    now += 51;
    CHECK(stops(STAIRSCAN_WHY_OLD));
    /* But where it is not ok it counts. */
    CHECK(send(GUARD("3", "1000.0")) == STAIRSCAN_SENTENCE && goes(9400));
    CHECK(send(DEGRADED("3")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_DEGRADED));
    CHECK(send(GUARD("3", "1000.0")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_DEGRADED));
    swept();
    travel += 5000;
    CHECK(goes(4400));
    travel += 1;
    CHECK(stops(STAIRSCAN_WHY_FAR));
    travel -= 10002;
    CHECK(stops(STAIRSCAN_WHY_FAR));
    travel = INT32_MIN;
    CHECK(stops(STAIRSCAN_WHY_FAR));
    /* A maximum age that no sweep can keep. */
    start();
    scanner.rules.oldest_sweep_ms = 49;
    CHECK(send(GUARD("1", "1000.0")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_OLD));
}

static void silence_and_restarts_void_it(void) {
    swept();
    scanner.rules.oldest_sweep_ms = 5000;
    now += 500;
    CHECK(goes(9400));
    now += 1;
    CHECK(stops(STAIRSCAN_WHY_SILENCE));
    CHECK(send(LIVE("guarding", "1", "5000")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_NO_ANSWER));
    CHECK(send(GUARD("9", "1000.0")) == STAIRSCAN_SENTENCE && goes(9400));
    /* A missed full scan is nothing that a sweep rests on. */
    CHECK(send(LIVE("guarding", "7", "5200")) == STAIRSCAN_SENTENCE && goes(9400));
    CHECK(send(LIVE("guarding", "7", "400")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_NO_ANSWER));
    swept();
    CHECK(send(BOOT("01234567")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_NO_ANSWER));
    swept();
    CHECK(send("PSTR,HALT,crash") == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_FAULT));
    CHECK(send(BOOT("01234567")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_NO_ANSWER));
    swept();
    CHECK(send(LIVE("fault", "1", "5000")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_FAULT));
    CHECK(send(LIVE("self-test", "1", "5200")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_FAULT));
    CHECK(send(GUARD("1", "1000.0")) == STAIRSCAN_SENTENCE && goes(9400));
}

static void settings_are_compared(void) {
    swept();
    scanner.rules.check_settings = true;
    scanner.rules.settings = 0x01234567;
    CHECK(stops(STAIRSCAN_WHY_SETTINGS));
    CHECK(send(STAT("01234567")) == STAIRSCAN_SENTENCE && goes(9400));
    CHECK(send(STAT("01234568")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_SETTINGS));
    CHECK(send("PSTR,SCAN,1,fault,none,0,0,no-echo,,,0,01234567,0") == STAIRSCAN_ANSWER && goes(9400));
    CHECK(send(BOOT("01234567")) == STAIRSCAN_SENTENCE);
    CHECK(send(GUARD("1", "1000.0")) == STAIRSCAN_SENTENCE && goes(9400));
    /* After a restart whose BOOT was lost the hash is unknown. */
    CHECK(send(LIVE("guarding", "0", "9000")) == STAIRSCAN_SENTENCE && goes(9400));
    CHECK(send(LIVE("guarding", "0", "400")) == STAIRSCAN_SENTENCE);
    CHECK(send(GUARD("2", "1000.0")) == STAIRSCAN_SENTENCE && stops(STAIRSCAN_WHY_SETTINGS));
}

/* ---- random damage ---- */

/* Sweeps in order, some lost, damaged or doubled, with arbitrary time and travel: the chair never drives on but by
 * the newest sweep, and never farther than that. */
static void damaged_streams(uint32_t rounds) {
    uint32_t driven = 0;
    uint32_t round;
    start();
    for (round = 0; round < rounds; round++) {
        char body[80];
        char line[128];
        uint32_t what = below(16);
        uint32_t free_mm = below(2000);
        stairscan_guard_permit_t permit;
        int length, k;
        bool ok = what > 3;
        (void)snprintf(body, sizeof body, "PSTR,GUARD,%" PRIu32 ",%s,%" PRIu32 ".0,none,99.8,", round,
                       ok ? "ok" : "degraded", free_mm);
        length = snprintf(line, sizeof line, "$%s*%08" PRIX32 "\r\n", body, stairscan_crc32(body, strlen(body)));
        if (what == 4) {
            line[below((uint32_t)length)] = (char)(uint8_t)below(256);
        }
        for (k = 0; k < length; k++) {
            (void)stairscan_take(&scanner, line[k], now, travel);
        }
        permit = stairscan_guard_may(&scanner, now, travel);
        CHECK(permit.action == STAIRSCAN_GO || permit.clear == 0);
        CHECK(permit.age_ms >= STAIRSCAN_SWEEP_DELAY_MS);
        CHECK(ok || permit.action == STAIRSCAN_STOP);
        CHECK(what <= 4 || permit.clear == (free_mm > 60 ? 10 * (int32_t)free_mm - 600 : 0));
        driven += permit.action == STAIRSCAN_GO;
        now += below(what == 5 ? UINT32_MAX : 400);
        travel += (int32_t)below(300);
        permit = stairscan_guard_may(&scanner, now, travel);
        CHECK(permit.action == STAIRSCAN_STOP || permit.age_ms <= 400);
    }
    CHECK(driven > rounds / 2);
}

/* ---- drives ---- */

#define CYCLE_MS 20u
#define SWEEP_MS 137u
#define BRAKING_MM_S2 1000

/* Drives towards a kerb 2 m ahead of the mirror, with 200 ms of dead time and sweeps that are lost with this
 * probability (per cent), and returns the distance left to the kerb, 0.1 mm, once the chair stands. */
static int32_t drive(uint32_t lost, bool odometer) {
    static const stairscan_chair_t chair = {200, BRAKING_MM_S2, 400};
    int32_t commands[10] = {0};
    int32_t speed = 0;
    uint32_t ms, sweep = 0;
    int32_t place = 0; /* 0.01 mm */
    start();
    for (ms = 0; ms < 12000; ms += CYCLE_MS) {
        stairscan_guard_permit_t permit;
        stairscan_ground_t ground;
        uint32_t k;
        now += CYCLE_MS;
        travel = odometer ? place / 10 : 0;
        if (ms / SWEEP_MS != sweep) {
            char body[80];
            sweep = ms / SWEEP_MS;
            /* Of 60 ms ago at most: the margin covers it. */
            (void)snprintf(body, sizeof body, "PSTR,GUARD,%" PRIu32 ",ok,%" PRId32 ".0,rise,99.8,", sweep,
                           (200000 - place) / 100 - 80 > 0 ? (200000 - place) / 100 - 80 : 0);
            CHECK(below(100) < lost || send(body) == STAIRSCAN_SENTENCE);
        }
        permit = stairscan_guard_may(&scanner, now, travel);
        ground.free_mm = stairscan_guard_free_mm(&scanner, now, travel);
        ground.age_ms = odometer ? CYCLE_MS : permit.age_ms;
        ground.fastest_mm_s = (uint32_t)speed;
        for (k = 0; k < 10; k++) {
            ground.fastest_mm_s = commands[k] > (int32_t)ground.fastest_mm_s ? (uint32_t)commands[k] : ground.fastest_mm_s;
        }
        k = ms / CYCLE_MS % 9; /* 180 ms and this cycle */
        /* Braking takes its time, speeding up does not. */
        speed = commands[k] < speed - BRAKING_MM_S2 / 50 ? speed - BRAKING_MM_S2 / 50 : commands[k];
        commands[k] = (int32_t)stairscan_max_speed(&ground, &chair);
        commands[k] = commands[k] > 800 ? 800 : commands[k];
        place += speed * (int32_t)CYCLE_MS / 10;
    }
    CHECK(speed == 0);
    return 20000 - place / 10;
}

static void chairs_stop_before_the_kerb(void) {
    uint32_t lost;
    for (lost = 0; lost <= 60; lost += 20) {
        int32_t with = drive(lost, true);
        int32_t without = drive(lost, false);
        CHECK(with > 0 && without > 0);
        /* And they come near it: 80 mm are the scanner's, 60 mm the margin. */
        CHECK(with < 2500 && without < 6000);
    }
    CHECK(drive(100, true) == 20000);
}

int main(void) {
    an_ok_sweep_counts_from_where_the_chair_is();
    the_next_sweep_replaces_it();
    a_sweep_that_ends_at_the_chair_stops_it();
    a_sweep_gets_old();
    silence_and_restarts_void_it();
    settings_are_compared();
    damaged_streams(100000);
    chairs_stop_before_the_kerb();
    printf("driving by the guard holds: %u checks\n", checks);
    return 0;
}
