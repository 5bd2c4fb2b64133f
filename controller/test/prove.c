/* For Frama-C's Eva, never run: calls every function of stairscan.h in any state with any arguments that its
 * contract permits. A read of a volatile variable is any value. See `controller/prove`. */
#include "../stairscan.h"

#define ANY_BYTES 512u /* more than the longest line */

static volatile uint32_t any_u32;
static volatile int32_t any_i32;
static volatile int64_t any_i64;
static volatile uint64_t any_u64;
static volatile char any_char;

static char bytes[ANY_BYTES + 1]; /* any bytes, zero-terminated */
static stairscan_t scanner;

static bool flag(void) {
    return any_u32 != 0;
}

static void fill(void) {
    size_t k;
    for (k = 0; k < ANY_BYTES; k++) {
        bytes[k] = any_char;
    }
    bytes[ANY_BYTES] = '\0';
}

static size_t length(void) {
    uint32_t length = any_u32;
    return length <= ANY_BYTES ? length : 0;
}

/* Any text; its bytes are not checked by the functions that take it. */
static stairscan_text_t text(void) {
    stairscan_text_t text;
    text.at = bytes;
    text.length = length();
    return text;
}

static stairscan_optional_t optional(void) {
    stairscan_optional_t optional;
    optional.present = flag();
    optional.value = any_i32;
    return optional;
}

static stairscan_time_t time(void) {
    stairscan_time_t time;
    time.present = flag();
    time.ms = any_u32;
    return time;
}

static stairscan_word_t word(void) {
    stairscan_word_t word;
    word.present = flag();
    word.word = any_u32;
    return word;
}

static stairscan_crash_site_t crash(void) {
    stairscan_crash_site_t crash;
    crash.pc = word();
    crash.lr = word();
    crash.cfsr = word();
    crash.address = word();
    crash.place = word();
    return crash;
}

static stairscan_scan_t scan(void) {
    stairscan_scan_t scan;
    scan.scan = any_u32;
    scan.status = any_u32;
    scan.direction = any_u32;
    scan.steps = any_u32;
    scan.lost_rows = any_u32;
    scan.reasons = any_u64;
    scan.horizon = optional();
    scan.confidence = optional();
    scan.maybes = any_u32;
    scan.settings = any_u32;
    scan.drops = any_u32;
    scan.plane = any_u32;
    scan.slope_from = optional();
    scan.slope = optional();
    return scan;
}

static stairscan_step_t step(void) {
    stairscan_step_t step;
    step.scan = any_u32;
    step.index = any_u32;
    step.count = any_u32;
    step.distance = any_i32;
    step.height = any_i32;
    step.tread = optional();
    step.riser = optional();
    step.distance_sigma = any_i32;
    step.height_sigma = any_i32;
    step.quality = any_u32;
    return step;
}

static stairscan_drop_t drop(void) {
    stairscan_drop_t drop;
    drop.scan = any_u32;
    drop.distance = any_i32;
    drop.distance_sigma = any_i32;
    drop.depth = optional();
    drop.probability = any_u32;
    return drop;
}

static stairscan_maybe_t maybe(void) {
    stairscan_maybe_t maybe;
    maybe.scan = any_u32;
    maybe.index = any_u32;
    maybe.count = any_u32;
    maybe.distance = any_i32;
    maybe.height = any_i32;
    maybe.probability = any_u32;
    return maybe;
}

static stairscan_guard_t guard(void) {
    stairscan_guard_t guard;
    guard.sweep = any_u32;
    guard.status = any_u32;
    guard.free = optional();
    guard.ending = any_u32;
    guard.confidence = any_u32;
    guard.reasons = any_u64;
    return guard;
}

static void write_numbers(void) {
    stairscan_sentence_t sentence;
    static stairscan_line_t line;
    sentence.kind = STAIRSCAN_SCAN;
    sentence.as.scan = scan();
    stairscan_write(&sentence, &line);
    sentence.kind = STAIRSCAN_STEP;
    sentence.as.step = step();
    stairscan_write(&sentence, &line);
    sentence.kind = STAIRSCAN_DROP;
    sentence.as.drop = drop();
    stairscan_write(&sentence, &line);
    sentence.kind = STAIRSCAN_MAYBE;
    sentence.as.maybe = maybe();
    stairscan_write(&sentence, &line);
    sentence.kind = STAIRSCAN_GUARD;
    sentence.as.guard = guard();
    stairscan_write(&sentence, &line);
    sentence.kind = STAIRSCAN_HALT;
    sentence.as.halt.reason = any_u32;
    stairscan_write(&sentence, &line);
    sentence.kind = any_u32;
    if (sentence.kind > STAIRSCAN_CRASH) {
        stairscan_write(&sentence, &line); /* no kind: an empty line */
    }
}

static void write_texts(void) {
    stairscan_sentence_t sentence;
    static stairscan_line_t line;
    size_t k;
    sentence.kind = STAIRSCAN_BOOT;
    sentence.as.boot.version = text();
    sentence.as.boot.revision = text();
    sentence.as.boot.reset = text();
    sentence.as.boot.clock = text();
    sentence.as.boot.boots = any_u32;
    sentence.as.boot.settings = any_u32;
    //@ loop unroll 16;
    for (k = 0; k < 3; k++) {
        sentence.as.boot.serial[k] = any_u32;
    }
    sentence.as.boot.second_memory = text();
    sentence.as.boot.option_bytes = word();
    sentence.as.boot.crash = crash();
    stairscan_write(&sentence, &line);
    sentence.kind = STAIRSCAN_CRASH;
    sentence.as.crash.cause = text();
    sentence.as.crash.boot = any_u32;
    sentence.as.crash.site = crash();
    stairscan_write(&sentence, &line);
    sentence.kind = STAIRSCAN_STAT;
    sentence.as.stat.state = text();
    sentence.as.stat.clock = text();
    sentence.as.stat.scans = any_u32;
    sentence.as.stat.estimator = text();
    sentence.as.stat.reasons = any_u64;
    sentence.as.stat.motion = text();
    sentence.as.stat.motion_faults = any_u32;
    sentence.as.stat.settings = any_u32;
    stairscan_write(&sentence, &line);
    sentence.kind = STAIRSCAN_LIVE;
    sentence.as.live.state = text();
    sentence.as.live.scan = any_u32;
    sentence.as.live.uptime_ms = any_u32;
    sentence.as.live.age = time();
    sentence.as.live.motion = text();
    sentence.as.live.motion_faults = any_u32;
    sentence.as.live.refused = any_u32;
    sentence.as.live.port_errors = any_u32;
    sentence.as.live.link_errors = any_u32;
    stairscan_write(&sentence, &line);
    sentence.kind = STAIRSCAN_CONF;
    sentence.as.conf.key = text();
    sentence.as.conf.value = text();
    stairscan_write(&sentence, &line);
    sentence.kind = STAIRSCAN_DONE;
    sentence.as.done.command = text();
    stairscan_write(&sentence, &line);
    sentence.kind = STAIRSCAN_FAIL;
    sentence.as.fail.command = text();
    sentence.as.fail.field = text();
    sentence.as.fail.expected = text();
    stairscan_write(&sentence, &line);
}

static void command(void) {
    stairscan_command_t command;
    static stairscan_line_t line;
    command.kind = any_u32;
    command.key = text();
    command.value = text();
    command.motion.sequence = any_u32;
    command.motion.travel = any_i32;
    command.motion.pitch = optional();
    command.calibration.wall_mm = any_u32;
    command.calibration.date = any_u32;
    stairscan_write_command(&command, &line);
}

static void read(void) {
    stairscan_sentence_t sentence;
    stairscan_command_t command;
    (void)stairscan_parse(bytes, length(), &sentence);
    (void)stairscan_parse(NULL, 0, &sentence);
    (void)stairscan_parse_command(bytes, length(), &command);
    (void)stairscan_parse_command(NULL, 0, &command);
    (void)stairscan_crc32(bytes, length());
    (void)stairscan_text(bytes);
    (void)stairscan_text(NULL);
}

static stairscan_rules_t rules(void) {
    stairscan_rules_t rules;
    rules.silence_ms = any_u32;
    rules.oldest_ms = any_u32;
    rules.farthest = any_i32;
    rules.margin = any_i32;
    rules.check_settings = flag();
    rules.settings = any_u32;
    rules.oldest_sweep_ms = any_u32;
    return rules;
}

/* An answer of any values, also such as no parser makes. */
static void set_answer(stairscan_answer_t *answer) {
    size_t k;
    answer->head = scan();
    //@ loop unroll 16;
    for (k = 0; k < STAIRSCAN_MAX_STEPS; k++) {
        answer->steps[k] = step();
    }
    answer->drop = drop();
    //@ loop unroll 16;
    for (k = 0; k < STAIRSCAN_MAX_MAYBES; k++) {
        answer->maybes[k] = maybe();
    }
    answer->came_ms = any_u32;
    answer->travel = any_i32;
}

/* Any state of a scanner that is sound (stairscan_sound). What is true of one call in any such state is true of
 * any number of calls in any order, because each leaves a sound state. */
static void set_scanner(void) {
    size_t k;
    scanner.rules = rules();
    scanner.has_answer = flag();
    set_answer(&scanner.answer);
    scanner.has_sweep = flag();
    scanner.sweep.guard = guard();
    scanner.sweep.came_ms = any_u32;
    scanner.sweep.travel = any_i32;
    scanner.damaged = any_u32;
    scanner.dropped = any_u32;
    set_answer(&scanner.coming);
    scanner.collecting = flag();
    scanner.got_steps = any_u32;
    scanner.got_drops = any_u32;
    scanner.got_maybes = any_u32;
    scanner.last_scan = any_u32;
    scanner.heard = flag();
    scanner.faulty = flag();
    scanner.doubtful = flag();
    scanner.aged = flag();
    scanner.edge_known = flag();
    scanner.edge = any_i64 % 0x400000000;
    scanner.sweep_aged = flag();
    scanner.sweep_faulty = flag();
    scanner.made_with = word();
    scanner.heard_ms = any_u32;
    scanner.uptime_ms = any_u32;
    scanner.skipping = flag();
    scanner.length = any_u32 % (STAIRSCAN_MAX_SENTENCE + 1);
    for (k = 0; k < STAIRSCAN_MAX_SENTENCE; k++) {
        scanner.line[k] = any_char;
    }
}

static void speed(void) {
    stairscan_ground_t ground;
    stairscan_chair_t chair;
    ground.free_mm = any_u32;
    ground.age_ms = any_u32;
    ground.fastest_mm_s = any_u32;
    chair.latency_ms = any_u32;
    chair.deceleration_mm_s2 = any_u32;
    chair.oldest_ms = any_u32;
    (void)stairscan_max_speed(&ground, &chair);
}

int main(void) {
    stairscan_rules_t any_rules = rules();
    fill();
    set_scanner();
    switch (any_u32) {
    case 0:
        write_numbers();
        break;
    case 1:
        write_texts();
        break;
    case 2:
        command();
        break;
    case 3:
        read();
        break;
    case 4:
        speed();
        break;
    case 5:
        (void)stairscan_may(&scanner, any_u32, any_i32);
        break;
    case 6:
        (void)stairscan_free_mm(&scanner, any_u32, any_i32);
        break;
    case 7:
        (void)stairscan_free(&scanner.answer);
        break;
    case 8:
        (void)stairscan_default_rules();
        stairscan_init(&scanner, &any_rules);
        break;
    case 9:
        (void)stairscan_guard_may(&scanner, any_u32, any_i32);
        (void)stairscan_guard_free_mm(&scanner, any_u32, any_i32);
        break;
    case 10:
        (void)stairscan_reason_word(any_u32);
        (void)stairscan_reason_meaning(any_u32);
        break;
    default:
        (void)stairscan_take(&scanner, any_char, any_u32, any_i32);
        break;
    }
    return 0;
}
