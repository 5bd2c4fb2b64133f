/* Tests the rules of stairscan.h one by one, and over streams of randomly damaged sentences. */
#include "check.h"

static bool may(enum stairscan_action action, enum stairscan_why why) {
    stairscan_permit_t permit = stairscan_may(&scanner, now, travel);
    bool none = permit.vouched == 0 && permit.clear == 0;
    return permit.action == (uint32_t)action && permit.why == (uint32_t)why &&
           (none || action == STAIRSCAN_GO);
}

#define OK_UP "PSTR,SCAN,1,ok,up,2,0,,1200.0,99.1,1,01234567,1"
#define STEP_1 "PSTR,STEP,1,1,2,500.0,170.0,280.0,170.0,1.0,2.0,100"
#define STEP_2 "PSTR,STEP,1,2,2,780.0,340.0,,170.0,1.0,2.0,100"
#define DROP_1 "PSTR,DROP,1,1300.0,10.0,,97.5"
#define MAYBE_1 "PSTR,MAYBE,1,1,1,1500.0,510.0,12.0"
#define CLEAR(scan) "PSTR,SCAN," scan ",ok,none,0,0,,1500.0,99.1,0,01234567,0"
#define DEGRADED(scan) "PSTR,SCAN," scan ",degraded,up,2,0,weak-echoes,0.0,0.0,0,01234567,0"
#define FAULT(scan) "PSTR,SCAN," scan ",fault,none,0,0,no-echo,,,0,01234567,0"
static void ok(void) {
    start();
    CHECK(send(OK_UP) == STAIRSCAN_SENTENCE);
    CHECK(send(STEP_1) == STAIRSCAN_SENTENCE);
    CHECK(send(STEP_2) == STAIRSCAN_SENTENCE);
    CHECK(send(DROP_1) == STAIRSCAN_SENTENCE);
    CHECK(send(MAYBE_1) == STAIRSCAN_ANSWER);
}

/* Sends LIVE for `ms` milliseconds. */
static void live_on(uint32_t ms) {
    uint32_t until = now + ms;
    while (now != until) {
        now += until - now < 200 ? until - now : 200;
        CHECK(send(LIVE("scanning", "2", "4000000000")) == STAIRSCAN_SENTENCE);
    }
}

static void an_ok_vouches_from_where_the_chair_is(void) {
    stairscan_permit_t permit;
    start();
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_SILENCE));
    ok();
    CHECK(scanner.has_answer && scanner.answer.steps[1].height == 3400);
    CHECK(scanner.answer.maybes[0].probability == 120);
    permit = stairscan_may(&scanner, now, travel);
    CHECK(permit.action == STAIRSCAN_GO && permit.why == STAIRSCAN_WHY_OK);
    CHECK(permit.vouched == 12000 - 600 && permit.clear == 5000 - 600);
    permit = stairscan_may(&scanner, now, travel + 4000);
    CHECK(permit.vouched == 12000 - 4600 && permit.clear == 400);
    permit = stairscan_may(&scanner, now, travel + 5000);
    CHECK(permit.action == STAIRSCAN_GO && permit.clear == 0);
    CHECK(send(CLEAR("2")) == STAIRSCAN_ANSWER);
    permit = stairscan_may(&scanner, now, travel);
    CHECK(permit.vouched == 14400 && permit.clear == 14400);
    /* The limits of `travel`. */
    permit = stairscan_may(&scanner, now, INT32_MIN);
    CHECK(permit.action == STAIRSCAN_STOP && permit.why == STAIRSCAN_WHY_FAR);
    permit = stairscan_may(&scanner, now, INT32_MAX);
    CHECK(permit.action == STAIRSCAN_STOP && permit.why == STAIRSCAN_WHY_FAR);
}

/* 20 mm of sigma: the step may be 60 mm nearer, of which the margin covers 30 mm. */
static void a_vague_step_may_stand_nearer(void) {
    stairscan_permit_t permit;
    start();
    (void)send("PSTR,SCAN,1,ok,up,1,0,,1200.0,99.1,0,01234567,0");
    CHECK(send("PSTR,STEP,1,1,1,500.0,170.0,,170.0,20.0,5.0,90") == STAIRSCAN_ANSWER);
    permit = stairscan_may(&scanner, now, travel);
    CHECK(permit.vouched == 11400 && permit.clear == 5000 - 600 - 300);
}

static void a_maybe_is_not_clear(void) {
    stairscan_permit_t permit;
    start();
    (void)send("PSTR,SCAN,1,ok,none,0,0,,1200.0,99.1,1,01234567,0");
    CHECK(send("PSTR,MAYBE,1,1,1,900.0,-100.0,5.0") == STAIRSCAN_ANSWER);
    permit = stairscan_may(&scanner, now, travel);
    CHECK(permit.vouched == 11400 && permit.clear == 8400);
}

/* 10 mm of sigma: the ground may end 30 mm nearer than reported. */
static void the_way_ends_at_a_drop(void) {
    stairscan_permit_t permit;
    stairscan_optional_t way;
    start();
    (void)send("PSTR,SCAN,1,ok,none,0,0,,870.0,99.1,0,01234567,1");
    CHECK(send("PSTR,DROP,1,900.0,10.0,180.0,97.5") == STAIRSCAN_ANSWER);
    CHECK(scanner.answer.drop.depth.present && scanner.answer.drop.depth.value == 1800);
    permit = stairscan_may(&scanner, now, travel);
    CHECK(permit.vouched == 8700 - 600 && permit.clear == 8700 - 600);
    way = stairscan_free(&scanner.answer);
    CHECK(way.present && way.value == 8700);
    /* Before the horizon, behind a step, behind the mirror. */
    (void)send("PSTR,SCAN,2,ok,none,0,0,,1500.0,99.1,0,01234567,1");
    CHECK(send("PSTR,DROP,2,900.0,20.0,,97.5") == STAIRSCAN_ANSWER);
    permit = stairscan_may(&scanner, now, travel);
    CHECK(permit.vouched == 14400 && permit.clear == 8400 - 600);
    CHECK(stairscan_free(&scanner.answer).value == 8400);
    ok();
    way = stairscan_free(&scanner.answer);
    CHECK(way.present && way.value == 5000);
    (void)send("PSTR,SCAN,2,ok,none,0,0,,1500.0,99.1,0,01234567,1");
    CHECK(send("PSTR,DROP,2,-10.0,214748364.7,,97.5") == STAIRSCAN_ANSWER);
    way = stairscan_free(&scanner.answer);
    CHECK(way.present && way.value == 0);
    CHECK(stairscan_may(&scanner, now, travel).clear == 0);
    /* Nothing is free if the answer is not ok, or has no horizon. */
    (void)send("PSTR,SCAN,3,degraded,none,0,0,short-horizon,700.0,99.1,0,01234567,1");
    CHECK(send("PSTR,DROP,3,900.0,10.0,,97.5") == STAIRSCAN_ANSWER);
    CHECK(!stairscan_free(&scanner.answer).present);
    CHECK(send("PSTR,SCAN,4,ok,none,0,0,,,,0,00000000,0") == STAIRSCAN_ANSWER);
    CHECK(!stairscan_free(&scanner.answer).present);
    /* A fault with a drop is invalid. */
    CHECK(send("PSTR,SCAN,5,fault,none,0,0,crash,,,0,01234567,1") == STAIRSCAN_SENTENCE);
    CHECK(scanner.dropped == 1);
}

/* With `plane both`: an answer of the height plane follows the one that reported the drop. */
static void the_height_plane_takes_no_drop_back(void) {
    start();
    CHECK(send("PSTR,SCAN,1,ok,none,0,0,,1100.0,99.1,0,01234567,1,depth") == STAIRSCAN_SENTENCE);
    CHECK(send("PSTR,DROP,1,1100.0,10.0,,97.5") == STAIRSCAN_ANSWER);
    CHECK(scanner.answer.head.plane == STAIRSCAN_PLANE_DEPTH);
    CHECK(stairscan_may(&scanner, now, travel).clear == 11000 - 300 - 600);
    CHECK(send("PSTR,SCAN,2,ok,none,0,0,,1400.0,99.1,0,01234567,0,height") == STAIRSCAN_ANSWER);
    CHECK(scanner.answer.head.plane == STAIRSCAN_PLANE_HEIGHT);
    CHECK(stairscan_may(&scanner, now, travel).clear == 11000 - 300 - 600);
    CHECK(stairscan_may(&scanner, now, travel + 1000).clear == 11000 - 300 - 600 - 1000);
    /* It may report a nearer end. */
    CHECK(send("PSTR,SCAN,3,ok,down,1,0,,1400.0,99.1,0,01234567,0,height") == STAIRSCAN_SENTENCE);
    CHECK(send("PSTR,STEP,3,1,1,1050.0,-170.0,,170.0,5.0,2.0,100") == STAIRSCAN_ANSWER);
    CHECK(stairscan_may(&scanner, now, travel).clear == 10500 - 600);
    /* The next answer of the depth plane replaces the drop. */
    CHECK(send("PSTR,SCAN,4,ok,none,0,0,,1500.0,99.1,0,01234567,0,depth") == STAIRSCAN_ANSWER);
    CHECK(stairscan_may(&scanner, now, travel).clear == 15000 - 600);
    /* Without the answer that reported the drop, the following one is not usable. */
    CHECK(send("PSTR,SCAN,5,ok,none,0,0,,1400.0,99.1,0,01234567,0,height") == STAIRSCAN_SENTENCE);
    CHECK(scanner.answer.head.scan == 4 && scanner.dropped == 1);
    CHECK(send("PSTR,SCAN,6,ok,none,0,0,,1100.0,99.1,0,01234567,1,depth") == STAIRSCAN_SENTENCE);
    CHECK(send("PSTR,SCAN,7,ok,none,0,0,,1400.0,99.1,0,01234567,0,height") == STAIRSCAN_SENTENCE);
    CHECK(scanner.answer.head.scan == 4);
}

static void a_degraded_one_is_a_hint(void) {
    ok();
    CHECK(send(DEGRADED("2")) == STAIRSCAN_SENTENCE);
    /* From its head on, even if its steps are never received. */
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_DEGRADED));
    CHECK(send("PSTR,STEP,2,1,2,500.0,170.0,,,1.0,2.0,9") == STAIRSCAN_SENTENCE);
    CHECK(send("PSTR,STEP,2,2,2,500.0,170.0,,,1.0,2.0,9") == STAIRSCAN_ANSWER);
    CHECK(may(STAIRSCAN_HINT, STAIRSCAN_WHY_DEGRADED));
    CHECK(send("PSTR,SCAN,3,ok,none,0,0,,,,0,00000000,0") == STAIRSCAN_ANSWER);
    CHECK(may(STAIRSCAN_HINT, STAIRSCAN_WHY_NO_HORIZON));
}

static void a_fault_stops(void) {
    ok();
    CHECK(send(FAULT("2")) == STAIRSCAN_ANSWER);
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_FAULT));
    CHECK(send(CLEAR("3")) == STAIRSCAN_ANSWER);
    CHECK(stairscan_may(&scanner, now, travel).action == STAIRSCAN_GO);
    CHECK(send(LIVE("fault", "3", "1000")) == STAIRSCAN_SENTENCE);
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_FAULT));
    CHECK(send(LIVE("self-test", "3", "1200")) == STAIRSCAN_SENTENCE);
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_FAULT));
    /* A fault with steps is invalid. */
    ok();
    CHECK(send("PSTR,SCAN,2,fault,up,1,0,crash,,,0,01234567,0") == STAIRSCAN_SENTENCE);
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_FAULT) && scanner.dropped == 1);
    CHECK(send("PSTR,STEP,2,1,1,500.0,170.0,,,1.0,2.0,9") == STAIRSCAN_SENTENCE);
    CHECK(!scanner.has_answer);
}

static void silence_stops_and_stays(void) {
    ok();
    now += 500;
    CHECK(stairscan_may(&scanner, now, travel).action == STAIRSCAN_GO);
    now += 1;
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_SILENCE));
    CHECK(send(LIVE("scanning", "2", "5000")) == STAIRSCAN_SENTENCE);
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_NO_ANSWER));
    /* Noise does not count as a sentence. */
    ok();
    now += 400;
    CHECK(take("$PSTR,DONE,start*00000000\r\nabc\r\n", 32) == STAIRSCAN_DAMAGED);
    now += 101;
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_SILENCE) && scanner.damaged == 2);
    /* Silence does not end when the clock wraps. */
    now += 0xFFFFFFF0u;
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_SILENCE));
}

static void an_answer_gets_old(void) {
    ok();
    live_on(17000);
    CHECK(stairscan_may(&scanner, now, travel).action == STAIRSCAN_GO);
    now += 1;
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_OLD));
    ok();
    travel += 5000;
    CHECK(stairscan_may(&scanner, now, travel).action == STAIRSCAN_GO);
    travel += 1;
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_FAR));
    travel -= 10002;
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_FAR));
}

static void an_answer_counts_whole_or_not(void) {
    const char *const sentences[] = {OK_UP, STEP_1, STEP_2, DROP_1, MAYBE_1};
    size_t lost, k;
    for (lost = 0; lost < 5; lost++) {
        start();
        for (k = 0; k < 5; k++) {
            CHECK(k == lost || send(sentences[k]) == STAIRSCAN_SENTENCE);
        }
        (void)send(LIVE("scanning", "1", "4000000000"));
        CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_NO_ANSWER));
        CHECK(send(CLEAR("2")) == STAIRSCAN_ANSWER);
        CHECK(scanner.dropped == (lost > 0));
    }
    for (k = 0; k < 4; k++) {
        /* The same sentence twice, and the wrong order. */
        start();
        (void)send(OK_UP);
        (void)send(sentences[k + 1]);
        CHECK(send(sentences[k + 1]) == STAIRSCAN_SENTENCE && !scanner.has_answer);
        CHECK(send(STEP_2) == STAIRSCAN_SENTENCE && send(DROP_1) == STAIRSCAN_SENTENCE);
        CHECK(send(MAYBE_1) == STAIRSCAN_SENTENCE);
        CHECK(!scanner.has_answer && scanner.dropped == 1);
    }
    start();
    (void)send(OK_UP);
    CHECK(send("PSTR,STEP,2,1,2,500.0,170.0,,,1.0,2.0,9") == STAIRSCAN_SENTENCE);
    CHECK(scanner.dropped == 1 && !scanner.collecting);
    CHECK(send("PSTR,SCAN,2,ok,up,17,0,,1000.0,99.0,0,01234567,0") == STAIRSCAN_SENTENCE);
    CHECK(scanner.dropped == 2 && !scanner.collecting);
    CHECK(send("PSTR,SCAN,3,ok,up,0,0,,1000.0,99.0,7,01234567,0") == STAIRSCAN_SENTENCE);
    CHECK(scanner.dropped == 3 && !scanner.collecting);
    CHECK(send("PSTR,SCAN,4,ok,none,0,0,,1000.0,99.0,0,01234567,2") == STAIRSCAN_SENTENCE);
    CHECK(scanner.dropped == 4 && !scanner.collecting);
    /* A drop that was not announced, and one of another scan. */
    (void)send(OK_UP);
    (void)send(STEP_1);
    (void)send(STEP_2);
    CHECK(send("PSTR,DROP,2,1300.0,10.0,,97.5") == STAIRSCAN_SENTENCE);
    CHECK(scanner.dropped == 5 && !scanner.collecting);
    CHECK(send(CLEAR("5")) == STAIRSCAN_ANSWER);
    CHECK(send("PSTR,DROP,5,1300.0,10.0,,97.5") == STAIRSCAN_SENTENCE);
    CHECK(scanner.answer.head.scan == 5 && scanner.answer.head.drops == 0);
}

static void an_incomplete_ok_leaves_the_older_one(void) {
    ok();
    CHECK(send("PSTR,SCAN,2,ok,up,1,0,,1000.0,99.0,0,01234567,0") == STAIRSCAN_SENTENCE);
    CHECK(stairscan_may(&scanner, now, travel).action == STAIRSCAN_GO);
    CHECK(send("PSTR,STEP,2,2,2,500.0,170.0,,,1.0,2.0,9") == STAIRSCAN_SENTENCE);
    CHECK(scanner.dropped == 1 && scanner.has_answer && scanner.answer.head.scan == 1);
    CHECK(stairscan_may(&scanner, now, travel).action == STAIRSCAN_GO);
}

static void others_may_stand_between(void) {
    start();
    (void)send(OK_UP);
    (void)send(LIVE("reporting", "1", "1000"));
    (void)send(STEP_1);
    (void)send("PSTR,DONE,start");
    (void)send(STEP_2);
    (void)send("PSTR,FAIL,set,crc,send $PSTC,set,seed,7*352B37A8");
    CHECK(scanner.sentence.kind == STAIRSCAN_FAIL);
    CHECK(scanner.sentence.as.fail.expected.length == 30);
    CHECK(send(DROP_1) == STAIRSCAN_SENTENCE);
    CHECK(send(MAYBE_1) == STAIRSCAN_ANSWER && scanner.damaged == 0);
}

static void a_restart_takes_the_answer_away(void) {
    ok();
    CHECK(send("PSTR,BOOT,0.1.0,abc,watchdog,hse-168,2,01234567,000000010000000200000003") ==
          STAIRSCAN_SENTENCE);
    CHECK(scanner.sentence.as.boot.serial[2] == 3);
    CHECK(scanner.sentence.as.boot.second_memory.length == 0);
    CHECK(!scanner.sentence.as.boot.option_bytes.present && !scanner.sentence.as.boot.crash.pc.present);
    CHECK(send("PSTR,BOOT,0.1.0,abc,panic,hse-168,3,01234567,000000010000000200000003,ccm-64,0FFFAAED,08021234,"
               "08020801,00000000,,89ABCDEF") == STAIRSCAN_SENTENCE);
    CHECK(scanner.sentence.as.boot.crash.place.word == 0x89ABCDEFu);
    CHECK(!scanner.sentence.as.boot.crash.address.present);
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_NO_ANSWER));
    ok();
    CHECK(send("PSTR,HALT,crash") == STAIRSCAN_SENTENCE);
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_FAULT));
    /* A lost BOOT is detected by the uptime. */
    ok();
    (void)send(LIVE("scanning", "2", "9000"));
    CHECK(stairscan_may(&scanner, now, travel).action == STAIRSCAN_GO);
    (void)send(LIVE("self-test", "0", "400"));
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_NO_ANSWER));
    CHECK(send(OK_UP) == STAIRSCAN_SENTENCE && scanner.collecting);
}

static void a_missed_answer_takes_the_one_before_away(void) {
    ok();
    (void)send(LIVE("scanning", "2", "9000"));
    CHECK(stairscan_may(&scanner, now, travel).action == STAIRSCAN_GO);
    (void)send(LIVE("scanning", "3", "9200"));
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_NO_ANSWER));
}

/* The free distance is that of `clear`, and 0 if the chair must not drive. */
static void free_ground_is_what_is_clear(void) {
    start();
    CHECK(stairscan_free_mm(&scanner, now, travel) == 0);
    ok();
    CHECK(stairscan_free_mm(&scanner, now, travel) == 440);
    /* Rounded down: 439.9 mm. */
    CHECK(stairscan_free_mm(&scanner, now, travel + 1) == 439);
    CHECK(stairscan_free_mm(&scanner, now, travel + 4395) == 0);
    CHECK(stairscan_free_mm(&scanner, now, travel + 5000) == 0);
    CHECK(send(DEGRADED("2")) == STAIRSCAN_SENTENCE);
    CHECK(stairscan_free_mm(&scanner, now, travel) == 0);
    CHECK(send(CLEAR("3")) == STAIRSCAN_ANSWER);
    CHECK(stairscan_free_mm(&scanner, now, travel) == 1440);
    CHECK(stairscan_free_mm(&scanner, now, INT32_MAX) == 0);
    CHECK(stairscan_free_mm(&scanner, now, INT32_MIN) == 0);
    /* The stored answer is unchanged and still `ok`: only stairscan_t knows that it is void. */
    CHECK(send("PSTR,HALT,crash") == STAIRSCAN_SENTENCE);
    CHECK(stairscan_free(&scanner.answer).present);
    CHECK(stairscan_free_mm(&scanner, now, travel) == 0);
    ok();
    live_on(17000);
    CHECK(stairscan_free_mm(&scanner, now, travel) == 440);
    CHECK(stairscan_free_mm(&scanner, now + 1, travel) == 0);
    ok();
    CHECK(stairscan_free_mm(&scanner, now + 500, travel) == 440);
    CHECK(stairscan_free_mm(&scanner, now + 501, travel) == 0);
    CHECK(send(LIVE("scanning", "2", "4000000000")) == STAIRSCAN_SENTENCE);
    CHECK(stairscan_free_mm(&scanner, now, travel) == 0);
    ok();
    scanner.rules.check_settings = true;
    CHECK(stairscan_free_mm(&scanner, now, travel) == 0);
}

static void settings_are_compared(void) {
    ok();
    scanner.rules.check_settings = true;
    scanner.rules.settings = 0x01234567;
    CHECK(stairscan_may(&scanner, now, travel).action == STAIRSCAN_GO);
    scanner.rules.settings = 0x01234568;
    CHECK(may(STAIRSCAN_STOP, STAIRSCAN_WHY_SETTINGS));
}

static void lines_end_anyhow_and_never_overflow(void) {
    char full[1000];
    start();
    memset(full, 'x', sizeof full);
    CHECK(take(full, sizeof full) == STAIRSCAN_NOTHING);
    CHECK(take("\n", 1) == STAIRSCAN_DAMAGED && scanner.damaged == 1);
    CHECK(take("\r\n\r\n", 4) == STAIRSCAN_NOTHING);
    /* A lost line end does not cost the following line. */
    CHECK(take("$PSTR,STEP,1,1", 14) == STAIRSCAN_NOTHING);
    CHECK(send(CLEAR("1")) == STAIRSCAN_ANSWER && scanner.damaged == 2);
    CHECK(take(full, sizeof full) == STAIRSCAN_NOTHING);
    CHECK(send(CLEAR("2")) == STAIRSCAN_ANSWER && scanner.damaged == 3);
    /* Nor do bytes before it, of which the last may be a space. */
    CHECK(take("\0", 1) == STAIRSCAN_NOTHING);
    CHECK(send(CLEAR("3")) == STAIRSCAN_ANSWER && scanner.damaged == 4);
    CHECK(take("at 12.5 ", 8) == STAIRSCAN_NOTHING);
    CHECK(send(CLEAR("4")) == STAIRSCAN_ANSWER && scanner.damaged == 5);
}

static void commands_are_written(void) {
    stairscan_command_t set = {STAIRSCAN_COMMAND_SET, {NULL, 0}, {NULL, 0}, {0, 0, {false, 0}}, {0, 0}};
    stairscan_command_t motion = {STAIRSCAN_COMMAND_MOTION, {NULL, 0}, {NULL, 0}, {7, 1234, {true, -250}}, {0, 0}};
    stairscan_line_t line;
    set.key = stairscan_text("seed");
    set.value = stairscan_text("7");
    stairscan_write_command(&set, &line);
    CHECK(strcmp(line.bytes, "$PSTC,set,seed,7*352B37A8\r\n") == 0);
    stairscan_write_command(&motion, &line);
    CHECK(strcmp(line.bytes, "$PSTC,MOTION,7,123.4,-250*A5DC3450\r\n") == 0 && line.length == 36);
    set.kind = STAIRSCAN_COMMAND_UPDATE;
    stairscan_write_command(&set, &line);
    CHECK(strcmp(line.bytes, "$PSTC,update*E84C43C4\r\n") == 0);
    CHECK(strcmp(stairscan_reason_word(STAIRSCAN_REASON_NO_ECHO), "no-echo") == 0);
    CHECK(strcmp(stairscan_reason_meaning(STAIRSCAN_REASON_COUNT), "") == 0);
}

/* ---- random damage ---- */

/* Checks the invariants after any input. */
static void holds(enum stairscan_event event) {
    stairscan_permit_t permit = stairscan_may(&scanner, now, travel);
    const stairscan_answer_t *answer = &scanner.answer;
    uint32_t k;
    CHECK(permit.action == STAIRSCAN_GO || (permit.vouched == 0 && permit.clear == 0));
    CHECK(permit.clear <= permit.vouched && permit.clear >= 0);
    CHECK(!stairscan_free(answer).present || answer->head.status == STAIRSCAN_OK);
    CHECK(stairscan_free_mm(&scanner, now, travel) == (uint32_t)permit.clear / 10);
    CHECK(permit.clear == 0 || travel < answer->travel ||
          permit.clear + 600 + (travel - answer->travel) <= stairscan_free(answer).value);
    CHECK(permit.action != STAIRSCAN_GO ||
          (scanner.has_answer && answer->head.status == STAIRSCAN_OK));
    if (event == STAIRSCAN_ANSWER) {
        CHECK(scanner.has_answer && answer->head.steps <= STAIRSCAN_MAX_STEPS);
        CHECK(answer->head.maybes <= STAIRSCAN_MAX_MAYBES);
        CHECK(answer->head.status != STAIRSCAN_FAULT || answer->head.steps + answer->head.drops == 0);
        CHECK(answer->head.drops == 0 || answer->drop.scan == answer->head.scan);
        for (k = 0; k < answer->head.steps; k++) {
            CHECK(answer->steps[k].scan == answer->head.scan && answer->steps[k].index == k + 1);
        }
        for (k = 0; k < answer->head.maybes; k++) {
            CHECK(answer->maybes[k].scan == answer->head.scan && answer->maybes[k].index == k + 1);
        }
    }
}

/* Sentences in order, some lost, damaged or doubled, with arbitrary time and travel. */
static void damaged_streams(unsigned long rounds) {
    static const char *const bodies[] = {
        OK_UP, STEP_1, STEP_2, DROP_1, MAYBE_1, LIVE("scanning", "1", "1000"), LIVE("fault", "9", "10"),
        CLEAR("2"), DEGRADED("3"), FAULT("4"), "PSTR,BOOT,a,b,c,d,1,00000000,000000000000000000000000",
        "PSTR,HALT,crash", "PSTR,SCAN,9,ok,up,255,0,,1.0,1.0,255,00000000,0"};
    unsigned long answers = 0;
    unsigned long round;
    uint32_t at = 0;
    start();
    for (round = 0; round < rounds; round++) {
        char line[256];
        const char *body = bodies[at];
        uint32_t crc = stairscan_crc32(body, strlen(body));
        int length = snprintf(line, sizeof line, "$%s*%08" PRIX32 "\r\n", body, crc);
        uint32_t what = below(16);
        int k;
        at = what == 0 ? below(13) : (at + 1) % 13;
        if (what == 1) {
            line[below((uint32_t)length)] = (char)(uint8_t)below(256);
        }
        if (what == 2) {
            length = (int)below((uint32_t)length);
        }
        for (k = 0; k < length; k++) {
            enum stairscan_event event = stairscan_take(&scanner, line[k], now, travel);
            answers += event == STAIRSCAN_ANSWER;
            if (event != STAIRSCAN_NOTHING) {
                holds(event);
            }
        }
        now += below(what == 3 ? UINT32_MAX : 300);
        travel = what == 4 ? (int32_t)(uint32_t)(below(UINT32_MAX) >> 2) : travel + (int32_t)below(2);
    }
    CHECK(answers > rounds / 10);
}

int main(void) {
    an_ok_vouches_from_where_the_chair_is();
    a_vague_step_may_stand_nearer();
    a_maybe_is_not_clear();
    the_way_ends_at_a_drop();
    the_height_plane_takes_no_drop_back();
    a_degraded_one_is_a_hint();
    a_fault_stops();
    silence_stops_and_stays();
    an_answer_gets_old();
    an_answer_counts_whole_or_not();
    an_incomplete_ok_leaves_the_older_one();
    others_may_stand_between();
    a_restart_takes_the_answer_away();
    a_missed_answer_takes_the_one_before_away();
    free_ground_is_what_is_clear();
    settings_are_compared();
    lines_end_anyhow_and_never_overflow();
    commands_are_written();
    damaged_streams(200000);
    printf("the rules hold: %u checks\n", checks);
    return 0;
}
