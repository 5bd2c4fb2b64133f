/* Parser, writer and rules for the stair scanner's report, for a wheelchair's controller.
 *
 * C99, two files (this and stairscan.c), no heap, no stdio, no floating point, no global state, and no library
 * function of their own. Time and travel are arguments. No input, however damaged, causes undefined behaviour.
 * Full description: docs/user/controller.md. Meaning of each field: docs/user/report.md.
 *
 * Use: pass every byte of the scanner's UART to stairscan_take, call stairscan_may in every control cycle, and
 * act on its result:
 *
 *   state of the report   stairscan_may      permitted motion
 *   ok, not old, near     STAIRSCAN_GO       drive forward, at most `clear`; climb the reported steps
 *                                            up to `vouched`
 *   degraded              STAIRSCAN_HINT     begin no motion on it, stop the current one; show the steps
 *                                            to the user
 *   fault                 STAIRSCAN_STOP     stand: there is no answer, which does not mean "no stairs"
 *   silence               STAIRSCAN_STOP     stand: scanner or line is dead, older answers are void
 *   old answer            STAIRSCAN_STOP     stand until a newer one is received: its age, or the travel
 *                                            since, is too large
 *
 * With the guard on call stairscan_guard_may in place of stairscan_may: it gives STAIRSCAN_GO or STAIRSCAN_STOP.
 *
 * Speed: stairscan_max_speed calculates a limit from stairscan_free_mm, or from stairscan_guard_free_mm. Use the
 * smaller of it and the joystick's command.
 *
 * For forward driving only. The scanner does not look backward, sideways or into a turn.
 *
 * Rules of state and timeouts, all implemented by stairscan_take and stairscan_may:
 * - An answer is one SCAN, its STEPs, its DROP, its MAYBEs, complete and in order. If one is missing, the whole
 *   answer is discarded (`dropped` counts those). LIVE and replies to commands may come between them.
 * - A SCAN that is not ok voids the older answer at once, even if its own STEPs get lost.
 * - The older answer is also voided by BOOT, HALT, an uptime that restarts, the state `fault` in LIVE, silence,
 *   and a LIVE that shows that a whole answer was missed.
 * - Silence is no intact sentence for `silence_ms`. The scanner sends LIVE five times a second in every state,
 *   except while `save` erases its flash (some seconds, only when it was stopped).
 * - An answer is old after `oldest_ms` since its SCAN was received, or after `farthest` of travel since. The
 *   clock may wrap; call stairscan_may at least once in a few days.
 * - If you configure the scanner, set `settings` to the hash in BOOT, STAT and SCAN: answers made with other
 *   settings are then ignored.
 * - Only the newest guard sweep counts, and only if it is ok. It is voided by the next one, BOOT, HALT, an uptime
 *   that restarts, the state `fault` in LIVE and silence; it is old after `oldest_sweep_ms` or `farthest` of
 *   travel. A GUARD that repeats the number before does not renew it. GUARD has no hash: that of the last BOOT,
 *   STAT or SCAN is compared with `settings`.
 *
 * Lengths are integers in tenths of a millimetre, probabilities in tenths of a per cent, angles in 0.001
 * degrees, as in the sentences. Distances are measured from the mirror at the scan's last row.
 *
 * Comments that begin with "@" are contracts in ACSL: what a function requires of its arguments, what it writes
 * (`assigns`) and what it ensures. `controller/prove` checks the parser against them.
 */
#ifndef STAIRSCAN_H
#define STAIRSCAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __FRAMAC__
#include <__fc_string_axiomatic.h> /* valid_read_string, strlen in contracts */
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define STAIRSCAN_MAX_SENTENCE 224 /* maximum length of a sentence, bytes, including CR LF */
#define STAIRSCAN_MAX_COMMAND 96   /* maximum length of a command to the scanner, bytes */
#define STAIRSCAN_MAX_STEPS 16     /* maximum number in an answer */
#define STAIRSCAN_MAX_MAYBES 6     /* maximum number in an answer */

/* Reasons: constant, word in sentences, meaning. */
/* begin generated: `cargo run -p stairscan-fuzz --example controller -- --write` */
#define STAIRSCAN_REASONS(X) \
    X(LOST_ROWS, "lost-rows", "Some rows' chirps were lost after all retries.") \
    X(INFERRED_STEP, "inferred-step", "A step, or its height, was inferred from its neighbours: no echo of its own shows it clearly.") \
    X(CLOSE_RIVAL, "close-rival", "The runner-up is nearly as probable.") \
    X(WEAK_ECHOES, "weak-echoes", "The steps rest on echoes little above the noise.") \
    X(BLOCKED_VIEW, "blocked-view", "An object blocks the line of sight.") \
    X(SHORT_HORIZON, "short-horizon", "The answer is not valid over the first metre of the way, or not certain enough of stairs that begin farther away.") \
    X(IRREGULAR_STEP, "irregular-step", "A step deviates from the others by more than a person would expect.") \
    X(UNCONFIGURED, "unconfigured", "The mounting is not configured: no settings were saved, and none were set.") \
    X(UNCONFIRMED, "unconfirmed", "No second sweep over the same scene has confirmed yet that the chair stands, or moves as reported.") \
    X(MOVING, "moving", "The chair moves otherwise than reported: two sweeps over the scene do not agree, or the echoes' phases turn otherwise.") \
    X(MOTION_INPUT, "motion-input", "The motion input was lost, late, damaged or impossible: the scan was processed without it.") \
    X(SCENE_CHANGED, "scene-changed", "Evidence of earlier scans contradicts this scan and was discarded.") \
    X(SCAN_NEARER, "scan-nearer", "The last full scan has a nearer hazard than this guard sweep: the nearer one is used.") \
    X(SATURATED, "saturated", "Samples at the converter's full scale.") \
    X(SILENT, "silent", "No signal at all.") \
    X(MIRROR_MISSING, "mirror-missing", "No echo from the mirror.") \
    X(MIRROR_FROZEN, "mirror-frozen", "The mirror's echo never changes: all chirps are the same.") \
    X(NO_ECHO, "no-echo", "Nothing but noise: not even the ground was detected.") \
    X(ADC_BIT, "adc-bit", "A bit of the converter never changes.") \
    X(IQ_SWAPPED, "iq-swapped", "I and Q are exchanged, or one has the wrong sign: the spectrum is mirrored.") \
    X(CHANNEL_DEAD, "channel-dead", "One of the two channels is dead, or both give the same signal.") \
    X(IQ_IMBALANCE, "iq-imbalance", "The imbalance of I and Q is so large that echoes have images.") \
    X(DC_DRIFT, "dc-drift", "The converter's offset drifts during the scan.") \
    X(CLIPPED, "clipped", "Samples are clipped below the converter's full scale.") \
    X(GAIN_DRIFT, "gain-drift", "The level of the mirror's own echo changes during the scan.") \
    X(INTERFERENCE, "interference", "Rows were discarded because of interference, or a tone is present in all of them.") \
    X(RANGE_SCALE, "range-scale", "The mirror's own echo does not match the mirror's offset: the range scale is wrong.") \
    X(STALE_CHIRP, "stale-chirp", "The same chirp was received more than once.") \
    X(MIRROR_STUCK, "mirror-stuck", "Echoes do not change though the mirror should have turned.") \
    X(ANGLE_JUMP, "angle-jump", "Echoes change faster or slower over the rows than the beam width allows: rows are not at their angles.") \
    X(MOUNT, "mount", "The ground is not where mount height, angle and offset put it.") \
    X(TOO_MANY_LOST, "too-many-lost", "Too many chirps were lost.") \
    X(LINK_SILENT, "link-silent", "The radar module does not answer.") \
    X(MODULE_ERROR, "module-error", "The radar module reports an error.") \
    X(MODULE_CONFIG, "module-config", "The radar module has settings with which the scanner cannot work.") \
    X(MOTOR_STALL, "motor-stall", "The motor's driver reports a stall.") \
    X(HOME_NOT_FOUND, "home-not-found", "The home switch was not found.") \
    X(SELF_TEST, "self-test", "The known-answer test of the arithmetic failed.") \
    X(SETTINGS_DAMAGED, "settings-damaged", "The settings in memory are corrupted: only a reset helps.") \
    X(WATCHDOG, "watchdog", "The watchdog reset the chip.") \
    X(CRASH, "crash", "The firmware panicked or took a hardware fault.") \
    X(CRASH_LOOP, "crash-loop", "Repeated resets by crash, watchdog or supply: the scanner stays idle until a command starts it.") \
    X(IMAGE_DAMAGED, "image-damaged", "The image in flash is corrupted.") \
    X(IMAGE_UNSEALED, "image-unsealed", "The image has no checksum; its integrity is unknown.") \
    X(MEMORY_DAMAGED, "memory-damaged", "The memory does not store what is written to it.") \
    X(SUPPLY, "supply", "The supply is too low, or was before the reset.") \
    X(INTERNAL_CLOCK, "internal-clock", "The crystal does not run, and the setting `internal-clock` is off.") \
    X(MOTOR_DRIVER, "motor-driver", "The motor's driver does not answer, was reset, or reports an error.") \
    X(MIRROR_SLIPPED, "mirror-slipped", "The home switch or the encoder finds the mirror elsewhere: its angle does not match its steps.") \
    X(ENCODER_SILENT, "encoder-silent", "The encoder on the mirror's shaft does not answer, or finds no magnet.") \
    X(NO_PROMISE, "no-promise", "The estimator computes no horizon: how far the answer is right is not known.")

/* Keys of settings: for `get` and `set`. */
#define STAIRSCAN_KEYS(X) \
    X("plane") \
    X("mirror-offset") \
    X("mirror-echo") \
    X("mirror-level") \
    X("range-scale") \
    X("mount-height") \
    X("beamwidth") \
    X("first-angle") \
    X("angle-step") \
    X("angle-count") \
    X("cfar-guard") \
    X("cfar-training") \
    X("cfar-false-alarm") \
    X("cfar-near-margin") \
    X("particles") \
    X("modes") \
    X("spread") \
    X("rounds") \
    X("mode-sigma") \
    X("vigilance") \
    X("radar-carrier") \
    X("radar-bandwidth") \
    X("radar-samples") \
    X("estimator") \
    X("seed") \
    X("settle") \
    X("chirp-timeout") \
    X("configure-timeout") \
    X("connect-timeout") \
    X("retries") \
    X("max-lost") \
    X("fault-hold") \
    X("chirp-duration") \
    X("motion-timeout") \
    X("internal-clock") \
    X("driver") \
    X("microsteps-per-turn") \
    X("enable-level") \
    X("stall-level") \
    X("pulse-width") \
    X("enable-wake") \
    X("motor-current") \
    X("stall-threshold") \
    X("encoder") \
    X("encoder-home") \
    X("home-angle") \
    X("speed") \
    X("acceleration") \
    X("search-speed") \
    X("home-check") \
    X("calibrated") \
    X("calibrated-chip") \
    X("module") \
    X("module-bandwidth") \
    X("module-samples") \
    X("link-rate") \
    X("trigger-pin") \
    X("chirps-per-row") \
    X("guard-first") \
    X("guard-last") \
    X("guard-step") \
    X("guard-rate") \
    X("watch-distance") \
    X("sweep") \
    X("sweep-mode") \
    X("motion") \
    X("fusion")

/* Keys of what is measured: for `get`. */
#define STAIRSCAN_MEASURES(X) \
    X("stack-used") \
    X("stack-size") \
    X("option-bytes")
/* end generated */

/* STAIRSCAN_REASON_LOST_ROWS and so on. A set of reasons is a bit mask: bit 1 << constant. */
enum stairscan_reason {
#define STAIRSCAN_X(name, word, meaning) STAIRSCAN_REASON_##name,
    STAIRSCAN_REASONS(STAIRSCAN_X)
#undef STAIRSCAN_X
    STAIRSCAN_REASON_COUNT
};

/* Return the word or the meaning of a reason; "" for an unknown number. */
/*@ assigns \nothing;
    ensures valid_read_string(\result); */
const char *stairscan_reason_word(uint32_t reason);
/*@ assigns \nothing;
    ensures valid_read_string(\result); */
const char *stairscan_reason_meaning(uint32_t reason);

enum stairscan_status { STAIRSCAN_OK, STAIRSCAN_DEGRADED, STAIRSCAN_FAULT };
enum stairscan_direction { STAIRSCAN_NONE, STAIRSCAN_UP, STAIRSCAN_DOWN };

/* Hazards at the end of the free distance of a guard sweep. NOTHING: no hazard within the range of the sweep;
 * UNKNOWN: the ground beyond is unknown. */
enum stairscan_ending {
    STAIRSCAN_ENDS_NOTHING,
    STAIRSCAN_ENDS_RISE,
    STAIRSCAN_ENDS_DROP,
    STAIRSCAN_ENDS_OBSTACLE,
    STAIRSCAN_ENDS_UNKNOWN
};

/* Plane of a scan. AS_SET: that of the setting `plane`; SCAN then has no such field. */
enum stairscan_plane { STAIRSCAN_PLANE_AS_SET, STAIRSCAN_PLANE_DEPTH, STAIRSCAN_PLANE_HEIGHT };

/* ---- sentences of the report ---- */

/* Text within the parsed line: not zero-terminated, valid as long as the line. */
typedef struct {
    const char *at;
    size_t length;
} stairscan_text_t;

/* An optional number; 0 if absent. */
typedef struct {
    bool present;
    int32_t value;
} stairscan_optional_t;

/* An optional time; 0 if absent. */
typedef struct {
    bool present;
    uint32_t ms;
} stairscan_time_t;

/* An optional word of 32 bits; 0 if absent. */
typedef struct {
    bool present;
    uint32_t word;
} stairscan_word_t;

/* SCAN: head of an answer. */
typedef struct {
    uint32_t scan;                   /* number since boot, from 1; 0 is a failed self-test */
    uint32_t status;                 /* enum stairscan_status */
    uint32_t direction;              /* enum stairscan_direction */
    uint32_t steps;                  /* number of STEP sentences that follow */
    uint32_t lost_rows;
    uint64_t reasons;                /* set of enum stairscan_reason */
    stairscan_optional_t horizon;    /* 0.1 mm: the answer is valid up to here */
    stairscan_optional_t confidence; /* 0.1 %: probability that nothing is wrong up to there */
    uint32_t maybes;                 /* number of MAYBE sentences that follow */
    uint32_t settings;               /* hash of the settings */
    uint32_t drops;                  /* number of DROP sentences that follow: 0 or 1 */
    uint32_t plane;                  /* enum stairscan_plane */
    stairscan_optional_t slope_from; /* 0.1 mm: the ground slopes from here on; none where it is level */
    stairscan_optional_t slope;      /* 0.1 mm of rise per metre, negative going down; with slope_from */
} stairscan_scan_t;

/* STEP: one step of an answer, 0.1 mm. */
typedef struct {
    uint32_t scan;
    uint32_t index; /* from 1, nearest first */
    uint32_t count;
    int32_t distance; /* to the foremost edge; negative for a drop behind the mirror */
    int32_t height;   /* above the ground that the chair stands on */
    stairscan_optional_t tread;
    stairscan_optional_t riser;
    int32_t distance_sigma;
    int32_t height_sigma;
    uint32_t quality; /* 0 to 100 */
} stairscan_step_t;

/* DROP: the ground ends or falls by more than 40 mm, and no downward staircase is reported. The nearest
 * possible place of the edge is distance - 3 distance_sigma. */
typedef struct {
    uint32_t scan;
    int32_t distance; /* 0.1 mm, to the edge */
    int32_t distance_sigma;
    stairscan_optional_t depth; /* 0.1 mm, of the next surface below the ground */
    uint32_t probability;       /* 0.1 % */
} stairscan_drop_t;

/* MAYBE: a possible step or drop that is not part of the answer. */
typedef struct {
    uint32_t scan;
    uint32_t index; /* from 1, nearest first */
    uint32_t count;
    int32_t distance;     /* 0.1 mm */
    int32_t height;       /* 0.1 mm; negative: the ground may end */
    uint32_t probability; /* 0.1 % */
} stairscan_maybe_t;

/* GUARD: free distance of one guard sweep. Only valid with the status ok. */
typedef struct {
    uint32_t sweep;            /* number since the guard was switched on, from 1 */
    uint32_t status;           /* enum stairscan_status */
    stairscan_optional_t free; /* 0.1 mm from the mirror at the sweep's last row; absent for a fault */
    uint32_t ending;           /* enum stairscan_ending */
    uint32_t confidence;       /* 0.1 %: probability that no hazard is nearer */
    uint64_t reasons;          /* set of enum stairscan_reason */
} stairscan_guard_t;

/* Where the firmware crashed; all absent if it did not. */
typedef struct {
    stairscan_word_t pc;
    stairscan_word_t lr;
    stairscan_word_t cfsr;    /* register SCB_CFSR */
    stairscan_word_t address; /* whose access failed */
    stairscan_word_t place;   /* hash of a panic's place in the source */
} stairscan_crash_site_t;

/* BOOT: first sentence after a reset. An older firmware sends it up to `serial`: the rest is then empty. */
typedef struct {
    stairscan_text_t version;
    stairscan_text_t revision;
    stairscan_text_t reset; /* cause of the reset */
    stairscan_text_t clock;
    uint32_t boots; /* number since power-up */
    uint32_t settings;
    uint32_t serial[3];
    stairscan_text_t second_memory; /* none, ccm-64, sram3-64, damaged; empty if unknown */
    stairscan_word_t option_bytes;
    stairscan_crash_site_t crash; /* before the reset */
} stairscan_boot_t;

/* CRASH: reply to `crash?`. */
typedef struct {
    stairscan_text_t cause; /* as `reset` of BOOT; none without a crash */
    uint32_t boot;          /* number since power-up of the boot that crashed; 0 without a crash */
    stairscan_crash_site_t site;
} stairscan_crash_t;

/* STAT: reply to `status`. */
typedef struct {
    stairscan_text_t state; /* boot, self-test, idle, scanning, reporting, guarding, fault */
    stairscan_text_t clock;
    uint32_t scans;
    stairscan_text_t estimator;
    uint64_t reasons;
    stairscan_text_t motion; /* absent, good, late, jumping, frozen, garbled, disordered */
    uint32_t motion_faults;
    uint32_t settings;
} stairscan_stat_t;

/* LIVE: sent five times a second in every state. The counters start at boot and saturate at 65535. */
typedef struct {
    stairscan_text_t state; /* as in STAT */
    uint32_t scan;          /* number of the scan that began last */
    uint32_t uptime_ms;
    stairscan_time_t age; /* time since the last row of the last scan without a fault */
    stairscan_text_t motion;
    uint32_t motion_faults;
    uint32_t refused;     /* number of refused lines */
    uint32_t port_errors; /* number of damaged or lost bytes at the scanner's input */
    uint32_t link_errors; /* number of requests without a correct answer of the radar module */
} stairscan_live_t;

/* CONF: one value of the configuration. */
typedef struct {
    stairscan_text_t key;
    stairscan_text_t value;
} stairscan_conf_t;

/* DONE: a command was executed. */
typedef struct {
    stairscan_text_t command;
} stairscan_done_t;

/* FAIL: a command was refused and nothing changed. `command` and `field` may be "-". */
typedef struct {
    stairscan_text_t command;
    stairscan_text_t field;
    stairscan_text_t expected;
} stairscan_fail_t;

/* HALT: the firmware stopped and resets the chip. */
typedef struct {
    uint32_t reason; /* enum stairscan_reason */
} stairscan_halt_t;

enum stairscan_kind {
    STAIRSCAN_SCAN,
    STAIRSCAN_STEP,
    STAIRSCAN_DROP,
    STAIRSCAN_MAYBE,
    STAIRSCAN_GUARD,
    STAIRSCAN_BOOT,
    STAIRSCAN_STAT,
    STAIRSCAN_LIVE,
    STAIRSCAN_CONF,
    STAIRSCAN_DONE,
    STAIRSCAN_FAIL,
    STAIRSCAN_HALT,
    STAIRSCAN_CRASH
};

typedef struct {
    uint32_t kind; /* enum stairscan_kind: the valid member of the union */
    union {
        stairscan_scan_t scan;
        stairscan_step_t step;
        stairscan_drop_t drop;
        stairscan_maybe_t maybe;
        stairscan_guard_t guard;
        stairscan_boot_t boot;
        stairscan_stat_t stat;
        stairscan_live_t live;
        stairscan_conf_t conf;
        stairscan_done_t done;
        stairscan_fail_t fail;
        stairscan_halt_t halt;
        stairscan_crash_t crash;
    } as;
} stairscan_sentence_t;

enum stairscan_error {
    STAIRSCAN_FINE,
    STAIRSCAN_BAD_FRAME, /* no $PSTR, no '*', or not printable ASCII */
    STAIRSCAN_BAD_CRC,
    STAIRSCAN_BAD_FIELD
};

typedef struct {
    uint32_t error;    /* enum stairscan_error */
    const char *field; /* wrong field for STAIRSCAN_BAD_FIELD; else NULL */
} stairscan_result_t;

/* Parses a line, with or without its CR LF. `sentence` is valid only if the result is STAIRSCAN_FINE. */
/*@ requires length <= 0x7FFFFFFF;
    requires \valid_read(line + (0 .. length - 1));
    requires \valid(sentence);
    assigns *sentence;
    ensures \result.error <= STAIRSCAN_BAD_FIELD;
    ensures \result.error == STAIRSCAN_FINE ==> sentence->kind <= STAIRSCAN_CRASH; */
stairscan_result_t stairscan_parse(const char *line, size_t length, stairscan_sentence_t *sentence);

/* A line to send, including CR LF, zero-terminated. */
typedef struct {
    size_t length;
    char bytes[STAIRSCAN_MAX_SENTENCE + 1];
} stairscan_line_t;

/* Writes a sentence as the scanner does. Characters that would break the frame become spaces, and text that is
 * too long is truncated. */
/*@ requires \valid_read(sentence);
    requires \valid(line);
    requires \separated(sentence, line);
    assigns *line;
    ensures line->length <= STAIRSCAN_MAX_SENTENCE && line->bytes[line->length] == 0; */
void stairscan_write(const stairscan_sentence_t *sentence, stairscan_line_t *line);

/* CRC-32 (ISO-HDLC) of the bytes between '$' and '*'. */
/*@ requires length <= 0x7FFFFFFF;
    requires \valid_read(bytes + (0 .. length - 1));
    assigns \nothing; */
uint32_t stairscan_crc32(const char *bytes, size_t length);

/* ---- commands and the motion sentence ---- */

enum stairscan_command {
    STAIRSCAN_COMMAND_START,
    STAIRSCAN_COMMAND_STOP,
    STAIRSCAN_COMMAND_SCAN,
    STAIRSCAN_COMMAND_GUARD, /* `value`: on or off */
    STAIRSCAN_COMMAND_WATCH, /* `value`: on or off */
    STAIRSCAN_COMMAND_STATUS,
    STAIRSCAN_COMMAND_VERSION,
    STAIRSCAN_COMMAND_CRASH,
    STAIRSCAN_COMMAND_FORGET_CRASH,
    STAIRSCAN_COMMAND_SELFTEST,
    STAIRSCAN_COMMAND_SAVE,
    STAIRSCAN_COMMAND_UPDATE, /* leaves for the boot loader, whose protocol is not in this parser */
    STAIRSCAN_COMMAND_RESET,
    STAIRSCAN_COMMAND_GET, /* `key`; all of them if it is empty */
    STAIRSCAN_COMMAND_SET, /* `key`, `value` */
    STAIRSCAN_COMMAND_CALIBRATE, /* `calibration` */
    STAIRSCAN_COMMAND_MOTION
};

/* MOTION: up to a hundred a second, at least five. */
typedef struct {
    uint32_t sequence;          /* 0 to 65535, incremented by one each time */
    int32_t travel;             /* 0.1 mm, forward positive, cumulative */
    stairscan_optional_t pitch; /* 0.001 degrees, nose up positive, within 45 degrees */
} stairscan_motion_t;

/* calibrate: a scan of flat ground and a wall. */
typedef struct {
    uint32_t wall_mm; /* from the mirror, 0 to 65535 */
    uint32_t date;    /* year, month and day: YYYYMMDD */
} stairscan_calibration_t;

typedef struct {
    uint32_t kind; /* enum stairscan_command */
    stairscan_text_t key;
    stairscan_text_t value;
    stairscan_motion_t motion;
    stairscan_calibration_t calibration;
} stairscan_command_t;

/* Reason why a line is not a command; both NULL if it is one. */
typedef struct {
    const char *command; /* its name, or "-" */
    const char *field;
} stairscan_refusal_t;

/* Returns the text of a zero-terminated string, for `key` and `value`. */
/*@ requires string == \null || valid_read_string(string);
    assigns \nothing;
    ensures \result.at == string;
    ensures string != \null ==> \result.length == strlen(string); */
stairscan_text_t stairscan_text(const char *string);

/* Writes a command or a motion sentence with frame, CRC and CR LF. The scanner refuses `set`, `save` and
 * `calibrate` without them. */
/*@ requires \valid_read(command);
    requires \valid(line);
    requires \separated(command, line);
    requires command->key.length <= 0x7FFFFFFF;
    requires \valid_read(command->key.at + (0 .. command->key.length - 1));
    requires command->value.length <= 0x7FFFFFFF;
    requires \valid_read(command->value.at + (0 .. command->value.length - 1));
    assigns *line;
    ensures line->length <= STAIRSCAN_MAX_SENTENCE && line->bytes[line->length] == 0; */
void stairscan_write_command(const stairscan_command_t *command, stairscan_line_t *line);

/* Parses a command, with or without a frame, as the scanner does: for test benches. */
/*@ requires length <= 0x7FFFFFFF;
    requires \valid_read(line + (0 .. length - 1));
    requires \valid(command);
    assigns *command; */
stairscan_refusal_t stairscan_parse_command(const char *line, size_t length,
                                            stairscan_command_t *command);

/* ---- answers and permitted motion ---- */

typedef struct {
    uint32_t silence_ms; /* silence: maximum time without an intact sentence */
    uint32_t oldest_ms;  /* maximum age of an answer */
    int32_t farthest;    /* 0.1 mm: maximum travel since an answer */
    int32_t margin;      /* 0.1 mm: subtracted from every permitted distance */
    bool check_settings; /* whether answers made with other settings are ignored */
    uint32_t settings;   /* the hash of the required settings */
    uint32_t oldest_sweep_ms; /* maximum age of a guard sweep, from its last row */
} stairscan_rules_t;

/* Time in which a GUARD is received after its sweep's last row, ms: 5 ms in the scanner (16 with an encoder) and the
 * transfer of it and of a LIVE at 115,200 baud. */
#define STAIRSCAN_SWEEP_DELAY_MS 50

/* Returns the defaults. silence_ms 500: LIVE comes every 200 ms. oldest_ms 17 s: more than four scans of 3.7 s.
 * farthest 500 mm: an odometer's 2 % of it are 1 cm. margin 60 mm: 30 mm error of an ok answer with a
 * sigma of at most 10 mm, and 30 mm of travel at 0.6 m/s from a scan's last row until its SCAN is read.
 * For a guard sweep, which leaves 80 mm for errors itself, these 60 mm are the travel in 50 ms at 1.2 m/s.
 * oldest_sweep_ms 400: people step in; two sweeps may be lost at 7.3 a second. Settings are not checked. */
/*@ assigns \nothing; */
stairscan_rules_t stairscan_default_rules(void);

/* A complete answer. */
typedef struct {
    stairscan_scan_t head;
    stairscan_step_t steps[STAIRSCAN_MAX_STEPS];    /* head.steps are valid */
    stairscan_drop_t drop;                          /* valid if head.drops is 1 */
    stairscan_maybe_t maybes[STAIRSCAN_MAX_MAYBES]; /* head.maybes are valid */
    uint32_t came_ms;                               /* time at which its SCAN was received */
    int32_t travel;                                 /* the chair's travel at that time */
} stairscan_answer_t;

/* A received guard sweep. */
typedef struct {
    stairscan_guard_t guard;
    uint32_t came_ms; /* time at which it was received */
    int32_t travel;   /* the chair's travel at that time */
} stairscan_sweep_t;

/* State of a scanner: about 2.4 KB. Members without a comment belong to the parser. */
typedef struct {
    stairscan_rules_t rules;
    bool has_answer;
    stairscan_answer_t answer;     /* the newest complete answer, if has_answer */
    bool has_sweep;
    stairscan_sweep_t sweep;       /* the newest guard sweep, if has_sweep */
    stairscan_sentence_t sentence; /* the last intact sentence; its text is valid until the next byte */
    uint32_t damaged;              /* number of damaged lines; saturates */
    uint32_t dropped;              /* number of incomplete answers; saturates */

    stairscan_answer_t coming;
    bool collecting;
    uint32_t got_steps, got_drops, got_maybes;
    uint32_t last_scan;
    bool heard, faulty, doubtful, aged, edge_known, sweep_aged, sweep_faulty;
    stairscan_word_t made_with; /* last hash of the settings in BOOT, STAT or SCAN */
    int64_t edge; /* 0.1 mm of travel: nearest place of the last drop that the depth plane reported */
    uint32_t heard_ms, uptime_ms;
    bool skipping;
    size_t length;
    char line[STAIRSCAN_MAX_SENTENCE];
} stairscan_t;

/* What every function requires of a scanner and ensures: the parser itself keeps to it. */
/*@ predicate stairscan_sound(stairscan_t *scanner) =
        scanner->length <= STAIRSCAN_MAX_SENTENCE &&
        (scanner->edge_known ==> -0x400000000 <= scanner->edge <= 0x400000000); */

/*@ requires \valid(scanner);
    requires \valid_read(rules);
    requires \separated(scanner, rules);
    assigns *scanner;
    ensures stairscan_sound(scanner); */
void stairscan_init(stairscan_t *scanner, const stairscan_rules_t *rules);

enum stairscan_event {
    STAIRSCAN_NOTHING,  /* no complete line yet */
    STAIRSCAN_SENTENCE, /* scanner->sentence is new, but completes no answer */
    STAIRSCAN_ANSWER,   /* scanner->sentence is new, and scanner->answer is a new, complete answer */
    STAIRSCAN_DAMAGED   /* a damaged line */
};

/* Processes one byte. `now_ms` is any clock in ms, `travel` the chair's travel as in its motion sentences. */
/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns *scanner;
    ensures stairscan_sound(scanner);
    ensures \result <= STAIRSCAN_DAMAGED; */
enum stairscan_event stairscan_take(stairscan_t *scanner, char byte, uint32_t now_ms, int32_t travel);

enum stairscan_action { STAIRSCAN_STOP, STAIRSCAN_HINT, STAIRSCAN_GO };

enum stairscan_why {
    STAIRSCAN_WHY_OK,
    STAIRSCAN_WHY_DEGRADED,   /* the answer is degraded; its reasons give the cause */
    STAIRSCAN_WHY_NO_HORIZON, /* ok without a horizon or free distance: valid nowhere */
    STAIRSCAN_WHY_SILENCE,
    STAIRSCAN_WHY_FAULT,
    STAIRSCAN_WHY_NO_ANSWER, /* none yet, or it was voided */
    STAIRSCAN_WHY_SETTINGS,  /* the answer was made with other settings */
    STAIRSCAN_WHY_OLD,       /* the answer is too old */
    STAIRSCAN_WHY_FAR,       /* the chair has travelled too far since the answer */
    STAIRSCAN_WHY_NEAR       /* guard sweeps only: the free distance ends within the margin */
};

typedef struct {
    uint32_t action; /* enum stairscan_action */
    uint32_t why;    /* enum stairscan_why */
    int32_t vouched; /* 0.1 mm ahead of the mirror's current position: the answer is valid up to here */
    int32_t clear;   /* 0.1 mm: and contains no step, drop or MAYBE up to here. Both are 0 unless GO */
} stairscan_permit_t;

/* Returns the free distance of an answer, 0.1 mm from the mirror at its last row: the ground is level up to the
 * nearest of horizon, first step, and drop less 3 sigma. Absent unless the answer is ok and has a horizon. Age,
 * travel and margin are not taken into account: see stairscan_may. */
/*@ requires \valid_read(answer);
    assigns \nothing;
    ensures 0 <= \result.value; */
stairscan_optional_t stairscan_free(const stairscan_answer_t *answer);

/* Returns what the chair may do now. Call it in every control cycle, also without new bytes. */
/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns *scanner;
    ensures stairscan_sound(scanner);
    ensures \result.action <= STAIRSCAN_GO && \result.why <= STAIRSCAN_WHY_FAR;
    ensures 0 <= \result.clear && 0 <= \result.vouched; */
stairscan_permit_t stairscan_may(stairscan_t *scanner, uint32_t now_ms, int32_t travel);

/* What the chair may do by the newest guard sweep. */
typedef struct {
    uint32_t action; /* STAIRSCAN_GO or STAIRSCAN_STOP */
    uint32_t why;    /* enum stairscan_why, of the sweep in place of an answer */
    uint32_t ending; /* enum stairscan_ending of the sweep; STAIRSCAN_ENDS_UNKNOWN without one */
    int32_t clear;   /* 0.1 mm ahead of the mirror's current position: free of rises, drops and obstacles up to here.
                      * 0 unless GO */
    uint32_t age_ms; /* time since the sweep's last row, rounded up; UINT32_MAX without a sweep */
} stairscan_guard_permit_t;

/* Returns what the chair may do now by guard sweeps alone; full scans do not count. Call it in every control cycle,
 * also without new bytes. During a full scan in between (0.7 to 3.7 s) no sweep comes: it gives STAIRSCAN_STOP. */
/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns *scanner;
    ensures stairscan_sound(scanner);
    ensures \result.action == STAIRSCAN_STOP || \result.action == STAIRSCAN_GO;
    ensures \result.why <= STAIRSCAN_WHY_NEAR;
    ensures 0 <= \result.clear;
    ensures \result.action == STAIRSCAN_STOP ==> \result.clear == 0; */
stairscan_guard_permit_t stairscan_guard_may(stairscan_t *scanner, uint32_t now_ms, int32_t travel);

/* ---- speed limit ---- */

/* Returns the free distance ahead of the mirror when the chair is at `travel`, mm, rounded down: `clear` of
 * stairscan_may. 0 unless its action is STAIRSCAN_GO (silence, a fault, an answer that is degraded, old or too
 * far back). */
/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns *scanner;
    ensures stairscan_sound(scanner); */
uint32_t stairscan_free_mm(stairscan_t *scanner, uint32_t now_ms, int32_t travel);

/* The same by guard sweeps: `clear` of stairscan_guard_may, mm, rounded down. */
/*@ requires \valid(scanner);
    requires stairscan_sound(scanner);
    assigns *scanner;
    ensures stairscan_sound(scanner); */
uint32_t stairscan_guard_free_mm(stairscan_t *scanner, uint32_t now_ms, int32_t travel);

/* A free distance, with the time since it was measured and the speed during it. */
typedef struct {
    uint32_t free_mm;      /* free distance ahead of the mirror at one instant: stairscan_free_mm or
                            * stairscan_guard_free_mm */
    uint32_t age_ms;       /* time since that instant, rounded up: the age of `travel`; without an odometer the time
                            * since the last row, for a sweep `age_ms` of stairscan_guard_may */
    uint32_t fastest_mm_s; /* maximum forward speed, measured or commanded, over the last age_ms + latency_ms */
} stairscan_ground_t;

/* Constants of the chair and its controller. */
typedef struct {
    uint32_t latency_ms;         /* maximum time from this call until the next call's command acts on the wheels:
                                  * control cycle, bus, motor controller, brake */
    uint32_t deceleration_mm_s2; /* minimum deceleration from then on: steepest downward slope, heaviest rider */
    uint32_t oldest_ms;          /* maximum age_ms; with a larger one nothing counts as free */
} stairscan_chair_t;

/* Returns the speed limit, mm/s: the largest v, at most UINT32_MAX, with
 *
 *   fastest * age + max(fastest, v) * latency + v * v / (2 * deceleration) <= free
 *
 * calculated without rounding. Returns 0 if there is none, if age_ms is larger than oldest_ms, or if the
 * deceleration is 0. The chair continues at `fastest` until this command acts. A controller that calls it in
 * every cycle therefore stops before the ground ends, unless a newer answer puts the end within the braking
 * distance. Defined for all values: never larger for less free ground, more age, speed or latency, or less
 * deceleration. */
/*@ requires \valid_read(ground);
    requires \valid_read(chair);
    assigns \nothing; */
uint32_t stairscan_max_speed(const stairscan_ground_t *ground, const stairscan_chair_t *chair);

#ifdef __cplusplus
}
#endif

#endif
