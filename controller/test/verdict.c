/* Prints the results of stairscan.c for lines, for comparison with the scanner's own parser.
 *
 *   verdict            reads from standard input: 'R' (report) or 'C' (command), the line's length in two
 *                      bytes, little-endian, its bytes; repeatedly. Writes one line of text for each.
 *   verdict FILE       checks the lines of a file of vectors: R or C, tab, line, tab, that text.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../stairscan.h"

#define LONGEST 65536

struct out {
    char text[4 * LONGEST];
    size_t length;
};

static void put(struct out *out, const char *bytes, size_t length) {
    if (length > sizeof out->text - out->length) {
        fputs("verdict: no room\n", stderr);
        exit(2);
    }
    memcpy(out->text + out->length, bytes, length);
    out->length += length;
}

static void say(struct out *out, const char *text) {
    put(out, text, strlen(text));
}

static void text(struct out *out, const char *name, stairscan_text_t value) {
    say(out, name);
    say(out, "[");
    put(out, value.length > 0 ? value.at : "", value.length);
    say(out, "]");
}

static void whole(struct out *out, const char *name, int64_t value) {
    char digits[32];
    (void)snprintf(digits, sizeof digits, "%" PRId64, value);
    say(out, name);
    say(out, digits);
}

static void optional(struct out *out, const char *name, stairscan_optional_t value) {
    if (value.present) {
        whole(out, name, value.value);
    } else {
        say(out, name);
        say(out, "-");
    }
}

static void reasons(struct out *out, uint64_t set) {
    uint32_t k;
    say(out, " reasons=");
    for (k = 0; k < 64; k++) {
        if ((set >> k & 1) != 0) {
            say(out, "<");
            say(out, stairscan_reason_word(k));
            say(out, ">");
        }
    }
}

static void say_scan(struct out *out, const stairscan_scan_t *s) {
    whole(out, "SCAN scan=", s->scan);
    whole(out, " status=", s->status);
    whole(out, " direction=", s->direction);
    whole(out, " steps=", s->steps);
    whole(out, " lost=", s->lost_rows);
    reasons(out, s->reasons);
    optional(out, " horizon=", s->horizon);
    optional(out, " confidence=", s->confidence);
    whole(out, " maybes=", s->maybes);
    whole(out, " settings=", s->settings);
    whole(out, " drops=", s->drops);
    whole(out, " plane=", s->plane);
    optional(out, " from=", s->slope_from);
    optional(out, " slope=", s->slope);
}

static void say_step(struct out *out, const stairscan_step_t *s) {
    whole(out, "STEP scan=", s->scan);
    whole(out, " index=", s->index);
    whole(out, " count=", s->count);
    whole(out, " distance=", s->distance);
    whole(out, " height=", s->height);
    optional(out, " tread=", s->tread);
    optional(out, " riser=", s->riser);
    whole(out, " distance-sigma=", s->distance_sigma);
    whole(out, " height-sigma=", s->height_sigma);
    whole(out, " quality=", s->quality);
}

static void say_drop(struct out *out, const stairscan_drop_t *d) {
    whole(out, "DROP scan=", d->scan);
    whole(out, " distance=", d->distance);
    whole(out, " distance-sigma=", d->distance_sigma);
    optional(out, " depth=", d->depth);
    whole(out, " probability=", d->probability);
}

static void say_maybe(struct out *out, const stairscan_maybe_t *m) {
    whole(out, "MAYBE scan=", m->scan);
    whole(out, " index=", m->index);
    whole(out, " count=", m->count);
    whole(out, " distance=", m->distance);
    whole(out, " height=", m->height);
    whole(out, " probability=", m->probability);
}

static void say_guard(struct out *out, const stairscan_guard_t *g) {
    whole(out, "GUARD sweep=", g->sweep);
    whole(out, " status=", g->status);
    optional(out, " free=", g->free);
    whole(out, " ending=", g->ending);
    whole(out, " confidence=", g->confidence);
    reasons(out, g->reasons);
}

static void word(struct out *out, const char *name, stairscan_word_t value) {
    if (value.present) {
        whole(out, name, value.word);
    } else {
        say(out, name);
        say(out, "-");
    }
}

static void say_crash(struct out *out, const stairscan_crash_site_t *c) {
    word(out, " pc=", c->pc);
    word(out, " lr=", c->lr);
    word(out, " cfsr=", c->cfsr);
    word(out, " address=", c->address);
    word(out, " place=", c->place);
}

static void say_boot(struct out *out, const stairscan_boot_t *b) {
    text(out, "BOOT version=", b->version);
    text(out, " revision=", b->revision);
    text(out, " reset=", b->reset);
    text(out, " clock=", b->clock);
    whole(out, " boots=", b->boots);
    whole(out, " settings=", b->settings);
    whole(out, " serial=", b->serial[0]);
    whole(out, "/", b->serial[1]);
    whole(out, "/", b->serial[2]);
    text(out, " second-memory=", b->second_memory);
    word(out, " option-bytes=", b->option_bytes);
    say_crash(out, &b->crash);
}

static void say_stat(struct out *out, const stairscan_stat_t *s) {
    text(out, "STAT state=", s->state);
    text(out, " clock=", s->clock);
    whole(out, " scans=", s->scans);
    text(out, " estimator=", s->estimator);
    reasons(out, s->reasons);
    text(out, " motion=", s->motion);
    whole(out, " motion-faults=", s->motion_faults);
    whole(out, " settings=", s->settings);
}

static void say_live(struct out *out, const stairscan_live_t *l) {
    text(out, "LIVE state=", l->state);
    whole(out, " scan=", l->scan);
    whole(out, " uptime=", l->uptime_ms);
    if (l->age.present) {
        whole(out, " age=", l->age.ms);
    } else {
        say(out, " age=-");
    }
    text(out, " motion=", l->motion);
    whole(out, " motion-faults=", l->motion_faults);
    whole(out, " refused=", l->refused);
    whole(out, " port-errors=", l->port_errors);
    whole(out, " link-errors=", l->link_errors);
}

static void say_sentence(struct out *out, const stairscan_sentence_t *sentence) {
    switch (sentence->kind) {
    case STAIRSCAN_SCAN:
        say_scan(out, &sentence->as.scan);
        return;
    case STAIRSCAN_STEP:
        say_step(out, &sentence->as.step);
        return;
    case STAIRSCAN_DROP:
        say_drop(out, &sentence->as.drop);
        return;
    case STAIRSCAN_MAYBE:
        say_maybe(out, &sentence->as.maybe);
        return;
    case STAIRSCAN_GUARD:
        say_guard(out, &sentence->as.guard);
        return;
    case STAIRSCAN_BOOT:
        say_boot(out, &sentence->as.boot);
        return;
    case STAIRSCAN_STAT:
        say_stat(out, &sentence->as.stat);
        return;
    case STAIRSCAN_LIVE:
        say_live(out, &sentence->as.live);
        return;
    case STAIRSCAN_CONF:
        text(out, "CONF key=", sentence->as.conf.key);
        text(out, " value=", sentence->as.conf.value);
        return;
    case STAIRSCAN_DONE:
        text(out, "DONE command=", sentence->as.done.command);
        return;
    case STAIRSCAN_FAIL:
        text(out, "FAIL command=", sentence->as.fail.command);
        text(out, " field=", sentence->as.fail.field);
        text(out, " expected=", sentence->as.fail.expected);
        return;
    case STAIRSCAN_CRASH:
        text(out, "CRASH cause=", sentence->as.crash.cause);
        whole(out, " boot=", sentence->as.crash.boot);
        say_crash(out, &sentence->as.crash.site);
        return;
    case STAIRSCAN_HALT:
        say(out, "HALT reason=<");
        say(out, stairscan_reason_word(sentence->as.halt.reason));
        say(out, ">");
        return;
    default:
        say(out, "a kind that there is not");
    }
}

static void say_line(struct out *out, const stairscan_line_t *line) {
    say(out, " => ");
    put(out, line->bytes, line->length - 2);
    if (strcmp(line->bytes + line->length - 2, "\r\n") != 0) {
        say(out, " without its end");
    }
}

static void report(struct out *out, const char *line, size_t length) {
    stairscan_sentence_t sentence;
    stairscan_line_t again;
    stairscan_result_t result = stairscan_parse(line, length, &sentence);
    switch (result.error) {
    case STAIRSCAN_FINE:
        say_sentence(out, &sentence);
        stairscan_write(&sentence, &again);
        say_line(out, &again);
        return;
    case STAIRSCAN_BAD_FRAME:
        say(out, "bad frame");
        return;
    case STAIRSCAN_BAD_CRC:
        say(out, "bad crc");
        return;
    default:
        say(out, "bad field ");
        say(out, result.field);
    }
}

static void command(struct out *out, const char *line, size_t length) {
    static const char *const names[] = {"start",   "stop",   "scan",        "guard",    "watch", "status",
                                        "version", "crash?", "crash-clear", "selftest", "save",  "update",
                                        "reset",   "get",    "set",         "calibrate", "MOTION"};
    stairscan_command_t command;
    stairscan_line_t again;
    stairscan_refusal_t refusal = stairscan_parse_command(line, length, &command);
    if (refusal.field != NULL) {
        say(out, "bad ");
        say(out, refusal.command);
        say(out, " ");
        say(out, refusal.field);
        return;
    }
    say(out, names[command.kind]);
    if (command.kind == STAIRSCAN_COMMAND_GET || command.kind == STAIRSCAN_COMMAND_SET) {
        text(out, " key=", command.key);
        text(out, " value=", command.value);
    }
    if (command.kind == STAIRSCAN_COMMAND_GUARD || command.kind == STAIRSCAN_COMMAND_WATCH) {
        text(out, " value=", command.value);
    }
    if (command.kind == STAIRSCAN_COMMAND_MOTION) {
        whole(out, " sequence=", command.motion.sequence);
        whole(out, " travel=", command.motion.travel);
        optional(out, " pitch=", command.motion.pitch);
    }
    if (command.kind == STAIRSCAN_COMMAND_CALIBRATE) {
        whole(out, " wall=", command.calibration.wall_mm);
        whole(out, " date=", command.calibration.date);
    }
    stairscan_write_command(&command, &again);
    say_line(out, &again);
}

static void verdict(struct out *out, int kind, const char *line, size_t length) {
    /* A copy of exactly this size: the address sanitizer detects reads behind it. */
    char *exact = malloc(length > 0 ? length : 1);
    if (exact == NULL) {
        exit(2);
    }
    memcpy(exact, line, length);
    out->length = 0;
    if (kind == 'C') {
        command(out, exact, length);
    } else {
        report(out, exact, length);
    }
    free(exact);
}

static int from_input(struct out *out, char *line) {
    int kind;
    while ((kind = getchar()) != EOF) {
        int low = getchar();
        int high = getchar();
        size_t length;
        if (low == EOF || high == EOF) {
            return 2;
        }
        length = (size_t)low + 256 * (size_t)high;
        if (fread(line, 1, length, stdin) != length) {
            return 2;
        }
        verdict(out, kind, line, length);
        say(out, "\n");
        (void)fwrite(out->text, 1, out->length, stdout);
    }
    return 0;
}

static int from_file(struct out *out, char *line, const char *path) {
    unsigned long number = 0;
    unsigned long checked = 0;
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        perror(path);
        return 2;
    }
    while (fgets(line, LONGEST, file) != NULL) {
        char *tab = strchr(line + 1, '\t');
        char *second = tab == NULL ? NULL : strchr(tab + 1, '\t');
        size_t length;
        number++;
        if (line[0] == '#') {
            continue;
        }
        if (second == NULL) {
            fprintf(stderr, "%s:%lu: not three fields\n", path, number);
            return 1;
        }
        verdict(out, line[0], tab + 1, (size_t)(second - tab - 1));
        length = strlen(second + 1);
        if (length != out->length + 1 || memcmp(second + 1, out->text, out->length) != 0) {
            fprintf(stderr, "%s:%lu: expected %sfound    %.*s\n", path, number, second + 1,
                    (int)out->length, out->text);
            return 1;
        }
        checked++;
    }
    (void)fclose(file);
    printf("%lu vectors of %s hold\n", checked, path);
    return checked > 0 ? 0 : 1;
}

int main(int argc, char **argv) {
    static struct out out;
    static char line[LONGEST];
    return argc > 1 ? from_file(&out, line, argv[1]) : from_input(&out, line);
}
